"""When feet meet bends: where the ground is one plane never, at the foot of a ramp when they are there."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rollgait.footing.bends import APART, BESIDE, bends
from rollgait.scenario.mesh import Mesh
from rollgait.scenario.schedule import ContactSchedule
from rollgait.terrain import Terrain
from rollgait.terrain.local_models import models_along
from rollgait.terrain.regions import Regions, regions_of

RADIUS = 0.124
SCHEDULE = ContactSchedule(np.ones((4, 12), dtype=bool), Mesh.equal(1.2, 12))
BEHIND = np.array([0.0, 0.0, 0.31, 0.31])
"""m; by which the hind feet are behind the front ones."""


def ramp(degrees: float) -> Regions:
    return regions_of(
        Terrain.from_parts([{"kind": "ramp", "x": 0.0, "length": 3.0, "slope_deg": degrees}]), RADIUS
    )


def rolling(start: float, speed: float) -> Any:
    """All feet along x."""

    def motion(times: np.ndarray) -> Any:
        x = start + speed * times[:, None] - BEHIND
        return SimpleNamespace(foot_position=np.stack([x, np.zeros_like(x), np.zeros_like(x)], axis=-1))

    return motion


@given(st.floats(-0.5, -0.2), st.floats(0.5, 1.0), st.sampled_from([10.0, 15.0, 20.0]))
@settings(max_examples=20, deadline=None)
def test_cut_where_a_wheel_is_at_a_kink_the_models_are_the_ground(
    start: float, speed: float, degrees: float
) -> None:
    regions, motion = ramp(degrees), rolling(start, speed)
    slope = np.tan(np.radians(degrees))
    kink = -RADIUS * (np.sqrt(1.0 + slope**2) - 1.0) / slope  # where the wheel touches both planes
    times = bends([regions] * 4, SCHEDULE, motion)
    crossings = (kink + BEHIND[[0, 2]] - start) / speed
    for time in times:
        assert np.abs(time - crossings).min() < APART
    cut = SCHEDULE.cut_at(times)
    assert np.diff(cut.node_times).min() > 0.99 * APART
    for leg in (0, 2):
        xy = motion(cut.node_times).foot_position[:, leg, :2]
        for k, model in enumerate(models_along(regions, xy[:-1], xy[1:], np.zeros(cut.intervals))):
            way = xy[k] + np.linspace(0.0, 1.0, 9)[:, None] * (xy[k + 1] - xy[k])
            apart = np.abs(model.z(way) - regions.surface.height(*way.T)).max()
            assert apart < BESIDE + slope * speed * APART


@pytest.mark.parametrize("degrees", [0.5, 15.0])
def test_on_one_plane_nothing_is_cut(degrees: float) -> None:
    for start in (0.7, -2.0):  # all on the ramp, all before it
        assert not bends([ramp(degrees)] * 4, SCHEDULE, rolling(start, 1.0)).size
