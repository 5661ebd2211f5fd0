"""Gaits by name: the same feet in the same order for planner and controller."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import rollgait as rg
from rollgait.errors import InputError
from rollgait.mpc.clock import GaitClock
from rollgait.mpc.gaits import GAITS
from rollgait.robot import LEG_NAMES
from rollgait.scenario import Crawl, Pace, Schedule, Trot, Walk
from rollgait.scenario.gait import SteppingGait
from rollgait.scenario.patterns import PATTERNS
from rollgait.scenario.schedule import MIN_SWING_INTERVALS, put_on_mesh

KINDS: dict[str, type[SteppingGait]] = {"crawl": Crawl, "walk": Walk, "trot": Trot, "pace": Pace}
PAIRS = {"trot": {frozenset({"FL", "HR"}), frozenset({"FR", "HL"})}}
PAIRS["pace"] = {frozenset({"FL", "HL"}), frozenset({"FR", "HR"})}

names = st.sampled_from(sorted(KINDS))
horizons = st.floats(3.0, 30.0)
steps = st.integers(1, 40)
fractions = st.floats(0.3, 1.0)


def in_the_air(gait: SteppingGait, horizon: float) -> list[tuple[float, float, frozenset[str]]]:
    """Begin, end and feet of each step, in the order of time."""
    together: dict[tuple[float, float], set[str]] = {}
    for leg, swings in gait.swings(horizon).items():
        for swing in swings:
            together.setdefault(swing, set()).add(leg)
    return sorted((begin, end, frozenset(legs)) for (begin, end), legs in together.items())


def test_every_pattern_is_a_gait_of_both() -> None:
    assert set(KINDS) == set(PATTERNS) == {name for name, gait in GAITS.items() if gait.swing > 0.0}


@given(names, horizons, steps, fractions)
def test_steps_have_equal_slots_and_their_swings_in_the_middle(
    name: str, horizon: float, count: int, fraction: float
) -> None:
    gait = KINDS[name](steps=count, swing_fraction=fraction)
    slot = (horizon - 2.0) / count
    found = in_the_air(gait, horizon)
    assert len(found) == count
    for k, (begin, end, legs) in enumerate(found):
        assert legs == set(gait.groups[k % len(gait.groups)])
        assert end - begin == pytest.approx(fraction * slot)
        assert 0.5 * (begin + end) == pytest.approx(1.0 + (k + 0.5) * slot)


@pytest.mark.parametrize("name", sorted(PAIRS))
@given(horizons, steps)
def test_pairs_swing_in_turn_and_the_other_pair_stands(name: str, horizon: float, count: int) -> None:
    found = in_the_air(KINDS[name](steps=count), horizon)
    assert {legs for *_, legs in found} <= PAIRS[name]
    for (_, end, legs), (begin, _, others) in pairwise(found):
        assert end <= begin
        assert legs | others == set(LEG_NAMES)


@pytest.mark.parametrize("name", sorted(KINDS))
def test_the_controller_lifts_the_same_feet_in_the_same_order(name: str) -> None:
    gait, clock = KINDS[name](), GaitClock(name)
    begins: dict[float, set[str]] = {}
    for swing in clock.swings(0.0, 3.0 * GAITS[name].period):
        begins.setdefault(round(swing.lift_off, 6), set()).add(LEG_NAMES[swing.leg])
    order = [legs for _, legs in sorted(begins.items())]
    assert len(order) >= 2 * len(gait.groups)
    assert order == [set(gait.groups[k % len(gait.groups)]) for k in range(len(order))]
    assert gait.wheels == GAITS[name].wheels


@given(names, horizons, st.floats(0.02, 0.1), steps)
def test_spelling_a_gait_out_changes_nothing(name: str, horizon: float, interval: float, count: int) -> None:
    gait = KINDS[name](steps=count)
    assume((horizon - 2.0) / count * gait.swing_fraction > (MIN_SWING_INTERVALS + 1.5) * interval)
    schedule = put_on_mesh(gait, horizon, interval)
    again = put_on_mesh(Schedule(**gait.swings(horizon)), horizon, interval)
    np.testing.assert_array_equal(again.contact, schedule.contact)


@pytest.mark.parametrize("name", sorted(PAIRS))
def test_centauro_steps_in_pairs(name: str) -> None:
    """Two feet on the ground are no polygon to stand in: the plan must sway with them."""
    data = {"robot": "centauro", "goal": {"x": 0.3, "y": 0.05, "yaw_deg": 10}, "horizon": 4.0}
    plan = rg.plan(rg.Scenario.from_dict(data | {"gait": {"kind": name, "steps": 4}}))
    assert plan.solved
    assert plan.certificate().passed, plan.certificate().failures
    assert {int(n) for n in plan.schedule.contact.sum(axis=0)} == {2, 4}


def test_point_feet_that_take_no_step_get_nowhere_and_it_says_so() -> None:
    scenario = rg.Scenario(robot="strider", goal=rg.Goal(x=1.0), horizon=4.0, gait=rg.Drive())
    with pytest.raises(InputError, match="a foot that does not roll takes no step in the gait 'drive'"):
        scenario.check()


@given(side=st.sampled_from([-1.0, 1.0]), x=st.floats(0.26, 0.5))
def test_a_foot_that_stands_still_must_be_in_its_box_at_the_goal(side: float, x: float) -> None:
    def asked(**goal: float) -> rg.Scenario:
        gait = {"kind": "drive", "wheels": "locked"}
        return rg.Scenario.from_dict({"robot": "centauro", "goal": goal, "horizon": 4.0, "gait": gait})

    with pytest.raises(InputError, match=r"must leave \w\w in its box.*takes no step before"):
        asked(x=side * x)
    with pytest.raises(InputError, match=r"it would be 0\.\d\d m outside"):
        asked(x=0.0, yaw_deg=side * 90.0)
    assert asked(x=side * 0.3 * x, yaw_deg=side * 5.0).gait.kind == "drive"
