"""Laws of the ways on which robots skid: turns and drives to the goal, no faster than wheels may slip."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rollgait as rg
from rollgait.angles import turned
from rollgait.footing.skidding import SLIP_SHARE, SkidWay, skid_route, skid_ways, skids, turn_rate_max
from tests.skidding import SLIP_MAX, robot

COORDINATE, YAW = st.floats(-2.0, 2.0), st.floats(-np.pi, np.pi)
POSES = st.tuples(COORDINATE, COORDINATE, YAW).map(np.array)
DRIVES = rg.Scenario.from_dict({"robot": robot(), "goal": {"x": 0.5}, "gait": "drive"})


def ways(a: np.ndarray, b: np.ndarray) -> list[SkidWay]:
    return skid_ways(DRIVES, a, b)


@given(POSES, POSES)
def test_each_way_leads_from_pose_to_pose(a: np.ndarray, b: np.ndarray) -> None:
    for way in ways(a, b):
        np.testing.assert_allclose(way.poses[0], a, atol=1e-9)
        np.testing.assert_allclose(way.poses[-1], b, atol=1e-5)
        np.testing.assert_allclose(way.at(np.array([0.0, way.duration])), way.poses[[0, -1]], atol=1e-9)


@given(POSES, POSES)
def test_it_turns_on_the_spot_or_rolls_along_its_heading(a: np.ndarray, b: np.ndarray) -> None:
    for way in ways(a, b):
        for before, after in zip(way.poses, way.poses[1:], strict=False):
            gone = turned((after - before)[:2], -float(before[2]))
            turns = abs(after[2] - before[2]) > 1e-9
            # a goal within 2 mm is turned to
            assert np.abs(gone).max() < 2.1e-3 if turns else abs(gone[1]) < 1e-6


@given(POSES, POSES)
def test_no_wheel_slips_faster_than_it_may(a: np.ndarray, b: np.ndarray) -> None:
    length = 0.5 * np.ptp(robot().stance[:, 0])
    for way in ways(a, b):
        times = np.linspace(0.0, way.duration, 400)
        rate = np.diff(way.at(times)[:, 2]) / max(times[1], 1e-9)
        assert np.abs(rate).max(initial=0.0) <= SLIP_SHARE * turn_rate_max(DRIVES) * (1.0 + 1e-6)
    assert turn_rate_max(DRIVES) == pytest.approx(SLIP_MAX / length, rel=0.2)


@given(POSES, POSES)
def test_the_mirrored_goal_has_the_mirrored_way(a: np.ndarray, b: np.ndarray) -> None:
    mirror = np.array([1.0, -1.0, -1.0])
    own = {way.name: way for way in ways(a, b)}
    for way in ways(a * mirror, b * mirror):
        turned_by = np.abs(np.diff(own[way.name].poses[:, 2])).sum()
        assert np.abs(np.diff(way.poses[:, 2])).sum() == pytest.approx(turned_by, abs=1e-5)
        assert way.duration == pytest.approx(own[way.name].duration, abs=1e-5)


@given(POSES, POSES)
def test_the_quickest_is_first(a: np.ndarray, b: np.ndarray) -> None:
    durations = [way.duration for way in ways(a, b)]
    assert durations == sorted(durations, key=lambda duration: round(duration, 6))


def test_a_route_rests_at_each_goal_at_its_time() -> None:
    goal = {"x": 0.0, "yaw_deg": 30.0, "then": [{"at": 6.0, "x": 0.4, "y": 0.2, "yaw_deg": 30.0}]}
    scenario = DRIVES.with_values({"goal": goal, "horizon": 20.0})
    there, end = skid_route(scenario, np.array([6.0, 20.0]))
    np.testing.assert_allclose(there, [0.0, 0.0, np.radians(30.0)], atol=1e-9)
    np.testing.assert_allclose(end, [0.4, 0.2, np.radians(30.0)], atol=1e-9)


@pytest.mark.parametrize(
    ("values", "may"),
    [
        ({}, True),
        ({"robot.legs.FL.slip_max": None}, False),
        ({"robot.legs.FL.heading": 0.1}, False),
        ({"ground": {"parts": [{"kind": "ramp", "x": 2.0, "length": 1.0, "rise": 0.1}]}}, False),
    ],
)
def test_who_skids(values: dict[str, object], may: bool) -> None:
    assert skids(DRIVES.with_values(values)) == may
