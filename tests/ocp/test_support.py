"""The CoM and its capture point stay over the feet that stand: laws of the rows."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import rollgait as rg
from rollgait.errors import InputError
from rollgait.ocp.problem import Problem, make_problem
from rollgait.ocp.support import AROUND, CaptureMargin, ComMargin, corners, one_swings
from rollgait.ocp.term import Constraint, Place
from rollgait.plan.certificate.support import depth_in_triangle
from rollgait.robot.robot import GRAVITY, Robot
from rollgait.scenario.scenario import Scenario
from tests.expressions import numbers, value
from tests.instants import Numbers, as_instant, data_of, random_numbers
from tests.plan.builders import robot as simple_robot

Array = NDArray[np.float64]

ROBOT: Robot = simple_robot()
SWINGS = {"FL": [[0.2, 0.8]], "FR": [[1.0, 1.6]], "HL": [[1.8, 2.4]], "HR": [[2.6, 3.2]]}
"""Each foot swings alone, in the order of the legs."""
legs = st.integers(0, 3)
seeds = st.integers(0, 1000)
some = settings(max_examples=20)
"""Each example evaluates expressions one by one."""


def problem(gait: dict[str, Any], foot: str = "steerable", **values: Any) -> Problem:
    data = {"robot": simple_robot(foot), "goal": {"x": 0.1}, "horizon": 4.0, "interval": 0.1, "gait": gait}
    return make_problem(Scenario.from_dict(data | values))


ONE_BY_ONE = problem({"kind": "schedule"} | SWINGS)


def swinging(leg: int) -> int:
    """An interval in which this foot swings."""
    return int(np.flatnonzero(~ONE_BY_ONE.schedule.contact[leg])[2])


def rows(term: Constraint, n: Numbers, leg: int) -> Array:
    """The rows while a foot swings."""
    return value(term.expression(as_instant(ROBOT, n), data_of(term, ONE_BY_ONE, swinging(leg))))


def in_place(seed: int) -> Numbers:
    """A robot in some disorder, its feet not so far away that they change sides, its CoM above them."""
    n, rng = random_numbers(seed, ROBOT), np.random.default_rng(seed)
    return replace(n, p=ROBOT.stance + rng.uniform(-0.15, 0.15, (4, 3)), r=0.2 * n.r)


def moved(n: Numbers, angle: float, shift: Array) -> Numbers:
    """The same robot elsewhere in the plane and turned: a world looked at from another side."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return replace(
        n,
        r=R @ n.r + shift,
        dr=R @ n.dr,
        p=n.p @ R.T + shift,
        theta=n.theta + np.array([angle, 0.0, 0.0]),
        sigma=n.sigma + angle,
    )


def common_velocity(n: Numbers, leg: int) -> Array:
    """Of the wheels that stand, (2,), m/s."""
    velocity = n.motion[:, :1] * np.column_stack([np.cos(n.sigma), np.sin(n.sigma)])
    return np.asarray(np.delete(velocity, leg, axis=0).mean(axis=0))


def fall_time(n: Numbers, leg: int) -> float:
    return float(np.sqrt((n.r[2] - np.delete(n.p[:, 2], leg).mean()) / GRAVITY))


@some
@given(seeds, legs)
def test_the_smallest_row_is_the_depth_in_the_triangle_as_the_judge_knows_it(seed: int, leg: int) -> None:
    n = in_place(seed)
    feet = np.delete(n.p, leg, axis=0)[:, :2]
    assert rows(ComMargin(), n, leg).min() == pytest.approx(depth_in_triangle(n.r[:2], feet), abs=1e-9)
    stop = n.r[:2] + fall_time(n, leg) * (n.dr[:2] - common_velocity(n, leg))
    assert rows(CaptureMargin(), n, leg).min() == pytest.approx(depth_in_triangle(stop, feet), abs=1e-4)


@some
@given(seeds, legs, numbers(4.0), numbers(3.0), numbers(3.0))
def test_a_world_turned_and_moved_has_the_same_margins(
    seed: int, leg: int, angle: float, x: float, y: float
) -> None:
    n = in_place(seed)
    for term in (ComMargin(), CaptureMargin()):
        there = rows(term, moved(n, angle, np.array([x, y, 0.0])), leg)
        np.testing.assert_allclose(there, rows(term, n, leg), atol=1e-9)


@some
@given(seeds, legs, st.integers(0, 2), st.floats(-0.5, 1.5), numbers(0.3))
def test_a_row_is_the_distance_from_its_edge(
    seed: int, leg: int, edge: int, along: float, inside: float
) -> None:
    """On the line through two feet it is zero, and it grows by what one goes to its left."""
    n = in_place(seed)
    standing = [foot for foot in AROUND if foot != leg]
    a, b = (n.p[standing[i % 3], :2] for i in (edge, edge + 1))
    normal = np.array([-(b - a)[1], (b - a)[0]]) / np.linalg.norm(b - a)
    r = np.append(a + along * (b - a) + inside * normal, n.r[2])
    assert rows(ComMargin(), replace(n, r=r), leg)[edge] == pytest.approx(inside, abs=1e-9)


@some
@given(seeds, legs)
def test_who_moves_as_the_wheels_do_falls_nowhere(seed: int, leg: int) -> None:
    n = in_place(seed)
    n = replace(n, dr=np.append(common_velocity(n, leg), n.dr[2]))
    np.testing.assert_allclose(rows(CaptureMargin(), n, leg), rows(ComMargin(), n, leg), atol=1e-9)


@some
@given(seeds, legs)
def test_the_foot_that_swings_does_not_matter(seed: int, leg: int) -> None:
    n, other = in_place(seed), random_numbers(seed + 1, ROBOT)
    p, motion, sigma = n.p.copy(), n.motion.copy(), n.sigma.copy()
    p[leg], motion[leg], sigma[leg] = other.p[leg], other.motion[leg], other.sigma[leg]
    for term in (ComMargin(), CaptureMargin()):
        changed = rows(term, replace(n, p=p, motion=motion, sigma=sigma), leg)
        np.testing.assert_array_equal(changed, rows(term, n, leg))


# -- where they hold -----------------------------------------------------------------------------------------


def test_the_corners_are_the_feet_that_stand_counterclockwise() -> None:
    schedule = ONE_BY_ONE.schedule
    which = corners(schedule).reshape(3, 4, -1)
    assert (which.sum(axis=1) == 1.0).all()
    alone = one_swings(schedule)
    np.testing.assert_array_equal(which.sum(axis=0)[:, alone], schedule.contact[:, alone])
    place = np.einsum("clk,lx->kcx", which, ROBOT.stance[:, :2])
    u, v = place[:, 1] - place[:, 0], place[:, 2] - place[:, 0]
    assert (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] > 0.0).all()


def terms(asked: Problem) -> list[Constraint]:
    kept = [term for term in asked.constraints if term.name in ("com_margin", "capture_margin")]
    assert all(isinstance(term, Constraint) for term in kept)
    return [term for term in kept if isinstance(term, Constraint)]


@pytest.mark.parametrize("kind", ["trot", "pace", "drive"])
def test_there_is_no_support_to_stay_in_with_two_feet_down(kind: str) -> None:
    asked = problem({"kind": kind}, interval=0.02)
    assert terms(asked)
    assert not any(term.holds(asked, place).any() for term in terms(asked) for place in term.places)


@pytest.mark.parametrize("foot", ["steerable", "fixed", "point"])
def test_every_node_of_a_swing_is_looked_at_and_none_twice(foot: str) -> None:
    """Where no wheel rolls, the end of an interval and the node after it are one and the same."""
    asked = problem({"kind": "schedule"} | SWINGS, foot)
    alone = one_swings(asked.schedule)
    for term in terms(asked):
        begins, ends = (term.holds(asked, place) for place in (Place.NODE, Place.INTERVAL_END))
        np.testing.assert_array_equal(begins, alone)
        last = alone & ~np.append(alone[1:], False)
        assert (ends[last]).all()
        rolls = foot != "point" and term.name == "capture_margin"
        np.testing.assert_array_equal(ends, alone if rolls else last)


def test_swings_without_a_pause_between_keep_both_supports() -> None:
    gait = {"kind": "schedule", "FL": [[0.5, 1.0]], "HR": [[1.0, 1.5]]}
    asked = problem(gait)
    (com,) = [term for term in terms(asked) if term.name == "com_margin"]
    assert com.holds(asked, Place.INTERVAL_END)[9]
    assert com.holds(asked, Place.NODE)[10]


# -- plans ---------------------------------------------------------------------------------------------------


def test_a_plan_keeps_its_margins_and_one_without_them_does_not() -> None:
    asked = rg.find_scenario("legged-forward")
    kept, loose = (
        rg.plan(asked.with_values({"bounds.without": names})).certificate()
        for names in ([], ["com_margin", "capture_margin"])
    )
    for name in ("com_margin", "capture_margin"):
        assert kept.row(name).verdict == "pass"
        assert kept.row(name).worst >= asked.value_of("bounds", name) - 1e-3
        assert loose.row(name).verdict == "not promised"
        assert loose.row(name).worst < asked.value_of("bounds", name) - 1e-2


def test_a_margin_beyond_a_metre_is_a_slip_of_the_pen() -> None:
    with pytest.raises(InputError, match=r"bounds\.com_margin"):
        problem({"kind": "drive"}, bounds={"com_margin": 5.0})
