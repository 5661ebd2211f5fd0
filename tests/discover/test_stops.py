"""Laws of the stops of steering: who may steer far enough has none, and what is tried instead has fewer."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollgait.discover.stops import TOLERANCE, stops
from rollgait.discover.ways import Way, Ways
from rollgait.footing.route import BaseWay
from tests.discover.worlds import candidates, world

STANCE = np.array([[0.35, 0.35], [0.35, -0.35], [-0.35, 0.35], [-0.35, -0.35]])
FREE = (-np.inf, np.inf)
X, Y, YAW = st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-2.5, 2.5)


def way(x: float, y: float, yaw: float) -> BaseWay:
    return BaseWay.through(np.array([[0.0, 0.0, 0.0], [x, y, yaw]]), 0.5)


def limits(degrees: float, legs: int = 4) -> list[tuple[float, float]]:
    """The same range to both sides for the first legs, none for the others."""
    return [(-np.radians(degrees), np.radians(degrees))] * legs + [FREE] * (4 - legs)


@given(x=X, y=Y, yaw=YAW)
def test_who_steers_all_the_way_round_has_no_stop(x: float, y: float, yaw: float) -> None:
    assert stops(way(x, y, yaw), STANCE, [FREE] * 4) == []
    assert stops(way(x, y, yaw), STANCE, limits(180.0)) == []


@given(x=X, y=Y)
def test_without_a_turn_no_heading_jumps(x: float, y: float) -> None:
    """Forwards or backwards: a quarter turn to both sides is enough for every direction."""
    assert stops(way(x, y, 0.0), STANCE, limits(90.0)) == []


@given(degrees=st.floats(5.0, 80.0), angle=st.floats(0.0, np.pi))
def test_a_direction_that_no_heading_has_is_a_stop_all_the_way(degrees: float, angle: float) -> None:
    off = min(angle, np.pi - angle)
    if abs(off - np.radians(degrees)) < 2.0 * TOLERANCE:
        return
    found = stops(way(np.cos(angle), np.sin(angle), 0.0), STANCE, limits(degrees, legs=1))
    assert [(c.leg, c.leaves, c.lands) for c in found] == (
        [(0, 0.0, 1.0)] if off > np.radians(degrees) else []
    )


@given(x=X, y=Y, yaw=YAW, degrees=st.floats(20.0, 120.0))
def test_a_mirrored_way_has_mirrored_stops(x: float, y: float, yaw: float, degrees: float) -> None:
    one = stops(way(x, y, yaw), STANCE, limits(degrees))
    other = stops(way(x, -y, -yaw), STANCE, limits(degrees))
    mirrored = [(c.leg ^ 1, round(c.leaves, 9), round(c.lands, 9)) for c in other]
    assert sorted(mirrored) == sorted((c.leg, round(c.leaves, 9), round(c.lands, 9)) for c in one)


@given(x=X, y=Y, yaw=YAW)
def test_stops_are_on_the_way_and_in_order(x: float, y: float, yaw: float) -> None:
    found = stops(way(x, y, yaw), STANCE, limits(40.0))
    assert all(0.0 <= c.leaves <= c.lands <= 1.0 for c in found)
    assert [c.middle for c in found] == sorted(c.middle for c in found)


def test_what_is_tried_instead_comes_after_driving_and_is_a_valid_gait() -> None:
    asked = world(goal={"x": 1.0, "y": 0.6, "yaw_deg": 30.0}, bounds={"steering_deg": (-35.0, 35.0)})
    found = candidates(asked)
    assert found[0].name == "driving"
    instead = [candidate for candidate in found if "steps to steer" in candidate.name]
    assert instead
    for candidate in instead:
        assert candidate.of(asked.with_values({"gait": "drive"})).gait.kind == "schedule"


def test_ways_that_turn_elsewhere_or_step_are_left_without_stops() -> None:
    asked = world(goal={"x": 1.0, "y": 0.6, "yaw_deg": 30.0}, bounds={"steering_deg": (-35.0, 35.0)})
    ways = Ways(asked)
    assert isinstance(ways.straight, Way)
    steered = list(ways.steered())
    assert steered
    for each in steered:
        assert len(each.steps) == len(ways.stops(each))


@pytest.mark.parametrize("goal", [{"x": 2.0, "y": 0.5, "yaw_deg": 40.0}, {"x": 0.0, "yaw_deg": 90.0}])
def test_where_no_wheel_comes_to_a_stop_nothing_else_is_tried(goal: dict[str, float]) -> None:
    ways = Ways(world(goal=goal))
    assert not list(ways.steered())
