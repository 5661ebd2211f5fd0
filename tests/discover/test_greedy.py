"""Laws of the steps of feet that cannot do what the motion asks."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rollgait as rg
from rollgait.discover.greedy import StepPace, greedy_gait, stepping, walked
from rollgait.errors import NotSolvedError
from rollgait.footing.carried import carried_ways
from rollgait.footing.stepping import stepping_route
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario import Scenario

X, Y, YAW = st.floats(-1.4, 1.4), st.floats(-0.7, 0.7), st.floats(-90.0, 90.0)
MIRRORED = {"FL": "FR", "FR": "FL", "HL": "HR", "HR": "HL"}


def robot(*feet: str) -> rg.Robot:
    """A light quadruped; kinds of the front and of the hind feet, or of all."""
    kinds = (feet[0], feet[0], feet[-1], feet[-1])
    places = [(0.36, 0.22), (0.36, -0.22), (-0.36, 0.22), (-0.36, -0.22)]
    legs = {
        name: {
            "foot": kind,
            "stance": (*place, -0.5),
            "wheel_radius": 0.1,
            "speed_max": 2.0,
            "force_max": 600.0,
        }
        for name, kind, place in zip(LEG_NAMES, kinds, places, strict=True)
    }
    inertia = {"xx": 1.2, "yy": 2.6, "zz": 3.0}
    data = {"name": "light", "mass": 45.0, "inertia": inertia, "box": (0.2, 0.12, 0.12), "legs": legs}
    return rg.Robot.model_validate(data)


FIXED, POINT, MIXED = robot("fixed"), robot("point"), robot("fixed", "point")


def to_any_place(law: Callable[..., None]) -> Callable[..., None]:
    """The law, for each kind of feet and any goal nearby."""
    few = settings(max_examples=12)(given(x=X, y=Y, yaw=YAW)(law))
    wanted: Callable[..., None] = pytest.mark.parametrize("body", [FIXED, POINT, MIXED])(few)
    return wanted


def to(body: rg.Robot, x: float = 0.0, y: float = 0.0, yaw: float = 0.0, **more: Any) -> Scenario:
    goal = {"x": x, "y": y, "yaw_deg": yaw}
    # not `from_dict`: without its steps a robot on point feet does not get there, which that refuses
    return Scenario.model_validate({"robot": body, "goal": goal, "horizon": 100.0, **more})


def swings(scenario: Scenario) -> list[tuple[str, float, float]]:
    """Leg, lift-off and touch-down, in the order of time."""
    found = scenario.gait.swings(scenario.horizon)
    return sorted(((name, *s) for name, legs in found.items() for s in legs), key=lambda s: s[1])


def test_legs_that_do_not_give_way_sideways_are_named_at_once() -> None:
    narrow = FIXED.model_copy(update={"box": (0.2, 0.002, 0.12)})
    with pytest.raises(NotSolvedError, match=r"do not steer .* sideways by 2 mm only"):
        list(stepping(to(narrow, 0.5, 0.2, 30.0, gait="discover")))
    (ahead,) = {candidate.values["gait"]["kind"] for candidate in stepping(to(narrow, 0.5, gait="discover"))}
    assert ahead == "drive"


@given(X)
def test_wheels_that_roll_straight_ahead_never_step(x: float) -> None:
    assert greedy_gait(to(FIXED, x)).gait.kind == "drive"


@pytest.mark.parametrize("body", [FIXED, POINT, MIXED])
def test_who_is_there_takes_no_step(body: rg.Robot) -> None:
    assert greedy_gait(to(body)).gait.kind == "drive"


@given(X, Y, YAW)
def test_steerable_wheels_never_step(x: float, y: float, yaw: float) -> None:
    assert greedy_gait(to(robot("steerable"), x, y, yaw)).gait.kind == "drive"


@given(X, YAW)
def test_of_mixed_feet_only_those_step_that_must(x: float, yaw: float) -> None:
    assert {name for name, *_ in swings(greedy_gait(to(MIXED, x)))} <= {"HL", "HR"}


@pytest.mark.parametrize("body", [FIXED, POINT, MIXED])
@given(x=X, y=st.floats(0.05, 0.7), yaw=st.floats(5.0, 90.0))
@settings(max_examples=12)
def test_a_mirrored_goal_asks_for_mirrored_steps(body: rg.Robot, x: float, y: float, yaw: float) -> None:
    one, other = (swings(greedy_gait(to(body, x, side * y, side * yaw))) for side in (1.0, -1.0))
    assert other == [(MIRRORED[name], *when) for name, *when in one]


@given(x=X, y=Y, yaw=YAW, turn=st.sampled_from([-170.0, 30.0, 90.0]))
@settings(max_examples=12)
def test_a_turned_world_asks_for_the_same_steps(x: float, y: float, yaw: float, turn: float) -> None:
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    here = to(FIXED, x, y, yaw)
    there = to(FIXED, c * x - s * y, s * x + c * y, yaw + turn, start={"yaw_deg": turn})
    a, b = greedy_gait(here), greedy_gait(there)
    assert [name for name, *_ in swings(a)] == [name for name, *_ in swings(b)]
    assert a.horizon == pytest.approx(b.horizon, abs=0.11)


@to_any_place
def test_one_foot_at_a_time_with_time_to_shift_between(
    body: rg.Robot, x: float, y: float, yaw: float
) -> None:
    asked = to(body, x, y, yaw)
    pace, gait = StepPace.of(asked), greedy_gait(asked)
    for earlier, later in pairwise(swings(gait)):
        assert later[1] - earlier[2] >= pace.shift * pace.interval - 1e-6
    if swings(gait):
        assert swings(gait)[-1][2] < gait.horizon


@to_any_place
def test_carried_feet_keep_to_their_boxes_and_end_at_their_places(
    body: rg.Robot, x: float, y: float, yaw: float
) -> None:
    asked = to(body, x, y, yaw)
    for way in carried_ways(asked):
        walk = walked(way, StepPace.of(asked))
        contact = greedy_gait(asked, way).schedule.contact
        assert len(walk.trace) == contact.shape[1]
        for k, (gone, nominal_at) in enumerate(walk.trace):
            for leg in np.flatnonzero(contact[:, k]):
                offset = way.offsets(int(leg), nominal_at[leg], way.index(gone))
                assert (np.abs(offset) <= np.array(body.box[:2])).all()
        assert walk.gone == pytest.approx(way.duration)
        for leg in np.flatnonzero(~contact.all(axis=1)):
            assert np.abs(way.offsets(int(leg), walk.feet.at[leg], -1)).max() < 0.1 * max(body.box)


@to_any_place
def test_from_the_steps_alone_a_route_is_found_on_which_no_foot_slips(
    body: rg.Robot, x: float, y: float, yaw: float
) -> None:
    scenario = greedy_gait(to(body, x, y, yaw))
    base, feet = stepping_route(scenario, scenario.schedule)
    np.testing.assert_allclose(base[0], 0.0, atol=1e-6)
    np.testing.assert_allclose(base[-1], [x, y, np.radians(yaw)], atol=5e-3)
    middle = 0.5 * (base[1:, 2] + base[:-1, 2])
    moved = np.diff(feet, axis=0)
    for leg, data in enumerate(body.leg_list):
        across = moved[:, leg, 1] * np.cos(middle) - moved[:, leg, 0] * np.sin(middle)
        slip = np.abs(across) if data.foot == "fixed" else np.hypot(*moved[:, leg].T)
        assert slip[scenario.schedule.contact[leg]].max(initial=0.0) < 5e-3


@given(x=X, y=Y)
@settings(max_examples=8)
def test_it_does_not_go_on_before_a_later_goal_holds(x: float, y: float) -> None:
    asked = to(POINT, x, y)
    goal = {"x": x, "y": y, "then": [{"at": 40.0, "x": 0.0}]}
    later = Scenario.model_validate({"robot": POINT, "goal": goal, "horizon": 100.0})
    alone, both = greedy_gait(asked), greedy_gait(later)
    assert both.horizon > max(40.0, alone.horizon - 1.0)
    assert not [s for s in swings(both) if alone.horizon + 4.0 < s[1] < 36.0]


def test_candidates_differ_and_what_was_asked_stays() -> None:
    asked = to(FIXED, 0.5, 0.4, 40.0, gait={"kind": "drive", "clearance": 0.06}, bounds={"force_min": 15.0})
    found = list(stepping(asked))
    assert len({candidate.key for candidate in found}) == len(found) >= 2
    for candidate in found:
        assert candidate.of(asked).clearance == 0.06
        assert candidate.of(asked).bounds == asked.bounds


def test_the_horizon_is_a_limit() -> None:
    asked = to(POINT, 0.8, 0.0, 30.0)
    all_of_them = [candidate.of(asked).horizon for candidate in stepping(asked)]
    limited = to(POINT, 0.8, 0.0, 30.0, horizon=min(all_of_them))
    assert [candidate.of(limited).horizon for candidate in stepping(limited)] == [min(all_of_them)]
    with pytest.raises(NotSolvedError, match=f"takes {min(all_of_them):g} s, the horizon is 2 s"):
        list(stepping(to(POINT, 0.8, 0.0, 30.0, horizon=2.0)))


@pytest.mark.parametrize(("body", "goal"), [(FIXED, (0.3, -0.2, 50.0)), (POINT, (-0.2, 0.2, 20.0))])
def test_what_is_discovered_is_certified(body: rg.Robot, goal: tuple[float, float, float]) -> None:
    plan = rg.plan(to(body, *goal, gait="discover"))
    assert plan.certificate().passed
    assert plan.statistics.discovery[0].outcome.startswith("certified")
    assert rg.plan(plan.scenario).certificate().passed  # its gait is given now


@pytest.mark.slow
def test_mixed_feet_are_certified() -> None:
    assert rg.plan(to(MIXED, 0.4, -0.1, 40.0, gait="discover")).certificate().passed


def quick(speed: float) -> dict[str, float]:
    """Bounds of feet that may be so fast in the air, m/s, and get there within a fifth of a second."""
    return {"swing_speed_max": speed, "swing_acceleration_max": 5.0 * speed}


def in_pairs(body: rg.Robot, x: float, y: float, yaw: float, speed: float) -> list[Scenario]:
    """What is proposed with diagonal pairs where feet may be so fast in the air, m/s."""
    asked = to(body, x, y, yaw, bounds=quick(speed))
    return [c.of(asked) for c in stepping(asked) if "diagonal pairs" in c.name]


@pytest.mark.parametrize("body", [FIXED, POINT])
@given(x=X, y=st.floats(0.2, 0.7), yaw=YAW)
@settings(max_examples=8)
def test_pairs_are_of_feet_across_with_time_between(body: rg.Robot, x: float, y: float, yaw: float) -> None:
    for scenario in in_pairs(body, x, y, yaw, 3.0):
        together: dict[tuple[float, float], set[str]] = {}
        for name, *when in swings(scenario):
            together.setdefault((when[0], when[1]), set()).add(name)
        assert {2} <= {len(names) for names in together.values()} <= {1, 2}
        for names in together.values():
            assert len(names) == 1 or names in ({"FL", "HR"}, {"FR", "HL"})
        for (_, end), (begin, _) in pairwise(sorted(together)):
            assert begin > end


def test_pairs_come_after_single_feet_and_only_where_feet_are_quick() -> None:
    asked = to(POINT, 0.8, 0.0, 30.0, bounds=quick(3.0))
    names = [candidate.name for candidate in stepping(asked)]
    first = next(k for k, name in enumerate(names) if "diagonal pairs" in name)
    assert first >= 3
    assert all("diagonal pairs" in name for name in names[first:])
    assert not in_pairs(POINT, 0.8, 0.0, 30.0, 0.2)


def test_pairs_take_less_time_than_single_feet() -> None:
    asked = to(POINT, 0.8, 0.0, 30.0, bounds=quick(3.0))
    pairs = min(scenario.horizon for scenario in in_pairs(POINT, 0.8, 0.0, 30.0, 3.0))
    assert pairs < 0.75 * greedy_gait(asked).horizon


def test_where_there_is_no_time_for_single_feet_pairs_are_certified() -> None:
    pairs = min(in_pairs(POINT, 0.4, 0.0, 30.0, 3.0), key=lambda scenario: scenario.horizon)
    gait = {"kind": "discover", "search": {"seconds": 600.0}}
    bounds = quick(3.0)
    plan = rg.plan(to(POINT, 0.4, 0.0, 30.0, gait=gait, bounds=bounds, horizon=pairs.horizon + 0.1))
    assert plan.certificate().passed
    assert all("diagonal pairs" in tried.name for tried in plan.statistics.discovery)
