"""Loads in the picture: boxes stay where they are on the base, arrows are as long as forces are strong."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

pytest.importorskip("viser", reason="needs the extra view")

from rollgait.plan.plan import Plan
from rollgait.scenario import find_scenario
from rollgait.view.clip import Clip, clip_of_plan
from rollgait.view.layers.layer import SOLID
from rollgait.view.layers.loads import Loads, edges_of
from rollgait.view.scene import Scene
from rollgait.view.software import SoftwareScene
from tests.view.builders import motion_plan

AT, HITCH = np.array([0.1, 0.15, 0.3]), np.array([-0.3, 0.0, 0.05])
PULL = np.array([-100.0, 20.0, 0.0])
TURNING = {"goal": {"x": 0.6, "yaw_deg": 60.0}, "horizon": 3.0, "interval": 0.25, "profile": "paper"}


def plan_with(loads: dict[str, Any]) -> Plan:
    return motion_plan(find_scenario("wheeled").with_values(TURNING | {"loads": loads}))


def drawn(clip: Clip, index: int) -> Loads:
    layer = Loads(SoftwareScene(), "/clip", clip, SOLID)  # type: ignore[arg-type]
    layer.show(index)
    return layer


def test_nothing_is_drawn_where_nothing_is_carried() -> None:
    clip = clip_of_plan(plan_with({}), "bare")
    assert Loads.title not in Scene(SoftwareScene(), "/clip", clip).layers  # type: ignore[arg-type]


@pytest.mark.parametrize("index", [0, 40, 90])
def test_a_box_stays_where_it_is_on_the_base(index: int) -> None:
    clip = clip_of_plan(plan_with({"payload": [{"mass": 8.0, "at": AT.tolist()}, {"mass": 2.0}]}), "boxes")
    layer, turn = drawn(clip, index), Rotation.from_euler("ZYX", clip.samples.euler[index])
    com = clip.samples.com_position[index]
    places = np.array([box.handle.batched_positions[0] for box in layer.boxes])
    np.testing.assert_allclose(places[0] - places[1], turn.apply(AT), atol=1e-6)
    np.testing.assert_allclose(places[1], com - turn.apply(clip.robot.com_offset), atol=1e-6)
    w, x, y, z = layer.boxes[0].handle.batched_wxyzs[0]
    assert (Rotation.from_quat([x, y, z, w]) * turn.inv()).magnitude() == pytest.approx(0.0, abs=1e-5)


def test_a_cube_of_water_or_its_own_size() -> None:
    clip = clip_of_plan(plan_with({"payload": [{"mass": 8.0}, {"mass": 1.0, "size": [0.1, 0.2, 0.3]}]}), "")
    eight, sized = clip.robot.loads or ()
    assert np.prod(edges_of(eight)) == pytest.approx(8e-3)
    assert edges_of(sized) == pytest.approx([0.1, 0.2, 0.3])


@pytest.mark.parametrize("frame", ["world", "base"])
def test_an_arrow_points_as_the_force_and_only_while_it_acts(frame: str) -> None:
    wrench = {"force": PULL.tolist(), "at": HITCH.tolist(), "frame": frame, "start": 1.0, "end": 2.0}
    clip = clip_of_plan(plan_with({"wrench": [wrench, wrench | {"force": (2.0 * PULL).tolist()}]}), "pulls")
    for time, acts in ((0.5, False), (1.5, True), (2.5, False)):
        index = clip.frame(time)
        arrows, turn = drawn(clip, index).arrows, Rotation.from_euler("ZYX", clip.samples.euler[index])
        assert arrows is not None
        start, tip = arrows.shafts.batched_positions, arrows.heads.batched_positions
        long = arrows.shafts.batched_scales[:, 2] + arrows.heads.batched_scales[:, 2]
        if not acts:
            assert long.max() < 1e-4
            continue
        assert long[2] == pytest.approx(2.0 * long[0], rel=1e-5)
        assert max(long[1], long[3]) < 1e-4  # no torque
        away = turn.apply(HITCH - clip.robot.com_offset)
        np.testing.assert_allclose(start[0], clip.samples.com_position[index] + away, atol=1e-6)
        wanted = turn.apply(PULL) if frame == "base" else PULL
        np.testing.assert_allclose(
            (tip - start)[0] / np.linalg.norm((tip - start)[0]), wanted / np.linalg.norm(PULL), atol=1e-5
        )
