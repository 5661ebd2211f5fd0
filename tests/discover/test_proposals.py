"""Laws of the gaits that are proposed before anything is solved."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rollgait.discover.crossings import Crossing
from rollgait.discover.orders import monotone, other_orders, straying, unevenness
from rollgait.errors import NotSolvedError
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario import Scenario
from tests.discover.worlds import (
    BLOCK,
    OBLIQUE,
    PILLAR,
    PIT,
    POTHOLE,
    STEP,
    WALL,
    Part,
    candidates,
    first,
    world,
)

MIRRORED = {"FL": "FR", "FR": "FL", "HL": "HR", "HR": "HL"}


def swings(scenario: Scenario) -> dict[str, tuple[tuple[float, float], ...]]:
    return {str(name): own for name, own in scenario.gait.swings(scenario.horizon).items()}


def count(scenario: Scenario) -> int:
    return sum(len(own) for own in swings(scenario).values())


def waypoints(scenario: Scenario) -> np.ndarray:
    goals = [scenario.goal, *scenario.goal.then]
    return np.array([[g.x, g.y, g.yaw_deg] for g in goals])


# -- which ---------------------------------------------------------------------------------------------------


@given(st.floats(-2.0, 2.0), st.floats(-1.0, 1.0), st.floats(-90.0, 90.0))
@settings(max_examples=8)
def test_on_flat_ground_nobody_steps_but_to_steer(x: float, y: float, yaw: float) -> None:
    found = candidates(world(goal={"x": x, "y": y, "yaw_deg": yaw}))
    assert found[0].name == "driving"
    for candidate in found:
        steps = any(swings(candidate.of(world())).values())
        assert steps == ("steps to steer" in candidate.name)


def test_wheels_that_steer_all_the_way_round_never_step_on_flat_ground() -> None:
    free = world(goal={"x": 1.0, "y": 0.6, "yaw_deg": 46.0}, bounds={"steering_deg": (-180.0, 180.0)})
    assert [c.name for c in candidates(free)] == ["driving", "driving, 1.4 × the time"]


@given(st.floats(0.85, 1.4), st.floats(0.05, 0.25), st.floats(-25.0, 25.0))
@settings(max_examples=5)
def test_each_foot_steps_once_over_an_edge_without_end(x: float, height: float, yaw: float) -> None:
    aside = 0.5 * abs(math.tan(math.radians(yaw)))
    edge = {"kind": "step", "x": x + aside, "height": height, "yaw_deg": yaw}
    assert {
        name: len(own) for name, own in swings(first(world([edge], {"x": 3.2}))).items()
    } == dict.fromkeys(LEG_NAMES, 1)


@pytest.mark.parametrize("part", [POTHOLE, PILLAR])
def test_what_is_under_one_side_or_between_the_feet_is_gone_around_without_a_step(part: Part) -> None:
    found = first(world([part], {"x": 3.0}))
    assert count(found) == 0
    assert len(waypoints(found)) > 1


def test_what_the_gait_says_beside_its_kind_stays() -> None:
    gait = {"kind": "discover", "clearance": 0.11, "clearance_over": 0.07}
    found = first(world([STEP], gait=gait))
    assert (found.gait.kind, found.clearance, found.clearance_over) == ("schedule", 0.11, 0.07)


def test_scores_rise_names_differ_and_nothing_is_proposed_twice() -> None:
    found = candidates(world([OBLIQUE]))
    assert len(found) > 5
    assert len({c.key for c in found}) == len({c.name for c in found}) == len(found)
    assert [c.key for c in found] == [c.key for c in candidates(world([OBLIQUE]))]


# -- symmetry ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("part", [OBLIQUE, BLOCK, POTHOLE])
def test_the_mirrored_world_has_the_mirrored_steps(part: Part) -> None:
    turned = {**part, "y": -part.get("y", 0.0), "yaw_deg": -part.get("yaw_deg", 0.0)}
    here, there = first(world([part])), first(world([turned]))
    assert there.horizon == pytest.approx(here.horizon, abs=0.2)
    mirrored = {MIRRORED[name]: own for name, own in swings(there).items()}
    for name, own in swings(here).items():
        np.testing.assert_allclose(np.array(mirrored[name]), np.array(own), atol=0.1)


@given(st.floats(-180.0, 180.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
@settings(max_examples=4)
def test_a_turned_world_has_the_same_steps(yaw: float, x: float, y: float) -> None:
    c, s = math.cos(math.radians(yaw)), math.sin(math.radians(yaw))

    def moved(place: tuple[float, float]) -> tuple[float, float]:
        return x + c * place[0] - s * place[1], y + s * place[0] + c * place[1]

    part = dict(OBLIQUE)
    part["x"], part["y"] = moved((part["x"], 0.0))
    part["yaw_deg"] += yaw
    goal = dict(zip("xy", moved((2.6, 0.0)), strict=True))
    there = first(world([part], {**goal, "yaw_deg": yaw}, start={"x": x, "y": y, "yaw_deg": yaw}))
    here = first(world([OBLIQUE]))
    assert there.horizon == pytest.approx(here.horizon, abs=0.11)
    for name, own in swings(here).items():
        np.testing.assert_allclose(
            np.array(swings(there)[name]), np.array(own), atol=0.05
        )  # tracks are looked up every centimetre


# -- what cannot be ------------------------------------------------------------------------------------------


def refusal(*parts: Part) -> str:
    with pytest.raises(NotSolvedError) as caught:
        candidates(world(parts, {"x": 3.0}))
    return str(caught.value)


def test_a_wall_and_a_pit_are_refused_with_their_place_and_by_how_much() -> None:
    assert "between x = 1.17 and" in refusal(WALL)
    assert "rises by 1.00 m there, 0.77 m more than a leg steps over" in refusal(WALL)
    assert "between x = 0.97 and 1.9" in refusal(PIT)
    assert "more than a step" in refusal(PIT)


@pytest.mark.parametrize("tread", [0.12, 0.17])
def test_a_tread_that_is_too_short_is_named_and_long_enough_when_it_is_lengthened_by_so_much(
    tread: float,
) -> None:
    def stairs(length: float) -> Part:
        return {"kind": "stairs", "x": 0.9, "steps": 3, "rise": 0.2, "tread": length}

    text = refusal(stairs(tread))
    assert "the tread is" in text
    assert "shorter than the robot needs" in text  # three of 0.2 m: its front feet would be too high
    short = float(text.split("the tread is ")[1].split(" cm")[0]) / 100.0
    assert candidates(world([stairs(tread + short + 0.011)], {"x": 3.4}), 1)


def test_the_horizon_is_a_limit() -> None:
    usual = first(world([STEP]))
    tight = first(world([STEP], horizon=0.8 * usual.horizon))
    assert tight.horizon <= 0.8 * usual.horizon + 1e-9
    assert count(tight) == count(usual)
    with pytest.raises(
        NotSolvedError, match=r"the quickest one that is known takes .* s, the horizon is 5 s"
    ):
        candidates(world([STEP], horizon=5.0))


# -- orders --------------------------------------------------------------------------------------------------


@given(st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=12))
def test_isotonic_regression_rises_keeps_the_mean_and_is_idempotent(values: list[float]) -> None:
    found = monotone(values)
    assert all(b >= a - 1e-12 for a, b in pairwise(found))
    assert found.mean() == pytest.approx(np.mean(values), abs=1e-9)
    np.testing.assert_allclose(monotone(list(found)), found, atol=1e-9)


@given(st.lists(st.tuples(st.integers(0, 3), st.floats(0.0, 1.0)), min_size=1, max_size=10))
def test_other_orders_are_the_same_steps(steps: list[tuple[int, float]]) -> None:
    given_ = sorted((Crossing(leg, s, s + 0.1) for leg, s in steps), key=lambda c: c.middle)
    assert straying(given_) == 0.0
    for order in other_orders(given_, 0.05):
        assert sorted(map(id, order)) == sorted(map(id, given_))
        assert straying(order) >= 0.0


def test_front_feet_that_climb_alone_are_tried_last() -> None:
    stairs = {"kind": "stairs", "x": 0.9, "steps": 4, "rise": 0.15, "tread": 0.32}
    found = candidates(world([stairs], {"x": 3.0}), 2)
    assert found[0].name == "as it comes, another order"
    low = {"kind": "stairs", "x": 0.9, "steps": 3, "rise": 0.1, "tread": 0.32}
    assert candidates(world([low], {"x": 3.0}), 1)[0].name == "as it comes"


@given(st.lists(st.integers(0, 3), max_size=12), st.floats(0.01, 0.2))
def test_feet_are_as_uneven_as_front_feet_are_ahead(legs: list[int], rise: float) -> None:
    steps = [Crossing(leg, 0.0, 0.1, rise) for leg in legs]
    down = [Crossing(leg, 0.0, 0.1, -rise) for leg in legs]
    ahead = np.cumsum([1 if leg < 2 else -1 for leg in legs]) if legs else np.zeros(1)
    assert unevenness(steps) == pytest.approx(0.5 * rise * np.abs(ahead).max())
    assert unevenness(down) == pytest.approx(unevenness(steps))


@pytest.mark.parametrize("part", [STEP, OBLIQUE])
def test_where_feet_land_elsewhere_the_base_is_shifted_at_each_step(part: dict[str, object]) -> None:
    asked = world([part], {"x": 2.2})
    found = {candidate.name: candidate for candidate in candidates(asked)}
    assert next(iter(found)) == "as it comes"
    far, near = (found[f"as it comes, {which} at each step"] for which in ("farther", "less far"))
    places = []
    for candidate in (far, near):
        goal = candidate.of(asked.with_values({"gait": "drive"})).goal
        *on_the_way, end = [goal.x, *(later.x for later in goal.then)]
        assert end == pytest.approx(2.2)
        places.append(on_the_way)
    np.testing.assert_allclose(np.subtract(*places), 0.12, atol=1e-3)
    legs = [
        {name: len(own) for name, own in c.of(asked).gait.swings(c.of(asked).horizon).items()}
        for c in (found["as it comes"], far, near)
    ]
    assert legs[0] == legs[1] == legs[2]


def test_where_nothing_is_stepped_over_there_is_nowhere_else_to_land() -> None:
    assert not [c for c in candidates(world()) if "at each step" in c.name]
