"""Files of joints carry the ground of their plan."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rollgait.export.motion import terrain_of
from rollgait.terrain import Terrain
from rollgait.tracking import JointTrajectory
from tests.hostile.motions import joints

HILLS = np.linspace(0.0, 0.3, 24).reshape(6, 4)
HILLS[2, 1] = np.nan
GROUNDS = {
    "steps": Terrain.from_parts([{"kind": "step", "x": 1.0, "height": 0.1, "friction": 0.3}], 0.2),
    "map": Terrain.from_map(HILLS, 0.1, (-0.5, 0.0), yaw=0.3),
    "none": None,
}


@pytest.mark.parametrize("name", GROUNDS)
def test_a_file_gives_back_the_ground(name: str, tmp_path: Path) -> None:
    terrain = GROUNDS[name]
    again = JointTrajectory.load(replace(joints(), terrain=terrain).save(tmp_path / "joints.npz"))
    assert again.terrain == terrain
    np.testing.assert_array_equal(again.joint_position, joints().joint_position)
    if terrain is None:
        lowest = again.reference.foot_position[..., 2].min()
        assert terrain_of(again).height(3.0, 4.0) == pytest.approx(lowest)
