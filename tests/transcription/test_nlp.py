"""The nonlinear program: its derivatives, and what the presolve makes of it."""

from __future__ import annotations

from itertools import product

import casadi as ca
import numpy as np
import pytest
from numpy.typing import NDArray

from rollgait.ocp.instant import Foot, Instant
from rollgait.ocp.problem import make_problem
from rollgait.ocp.term import INPUT, Constraint, Data, FootConstraint, Limits, Mask, Place
from rollgait.scenario import ContactSchedule, Mesh
from rollgait.transcription import TRANSCRIPTION_NAMES
from rollgait.transcription import transcribe as transcribe_by
from rollgait.transcription.base import Transcribed
from rollgait.transcription.collocation import transcribe
from rollgait.transcription.nlp import Nlp
from tests.transcription.problems import (
    CASES,
    KINDS,
    UNEVEN,
    about_the_guess,
    problem_of,
    small_problem,
)

Array = NDArray[np.float64]

STEP = 1e-5
"""Of central differences, in the scaling of the solver."""


@pytest.fixture(scope="module", params=product(TRANSCRIPTION_NAMES, CASES), ids="-".join)
def transcribed(request: pytest.FixtureRequest) -> Transcribed:
    name, case = request.param
    return transcribe_by(name, problem_of(case))


def values(nlp: Nlp, name: str, *arguments: object) -> list[Array]:
    result = nlp.functions[name](*arguments)
    parts = result if isinstance(result, tuple) else (result,)
    return [np.asarray(part.full() if isinstance(part, ca.DM) else part).squeeze() for part in parts]


def direction(nlp: Nlp, seed: int) -> Array:
    return np.random.default_rng(seed).normal(size=nlp.size)


def assert_close(exact: Array, difference: Array) -> None:
    scale = max(1.0, float(np.abs(exact).max()))
    np.testing.assert_allclose(exact / scale, difference / scale, atol=2e-7)


# -- derivatives ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(3))
def test_gradient_against_finite_differences(transcribed: Transcribed, seed: int) -> None:
    nlp, w = transcribed.nlp, about_the_guess(transcribed, seed)
    d = direction(nlp, seed)
    (after,), (before,) = (values(nlp, "nlp_f", w + sign * STEP * d, nlp.parameters) for sign in (1, -1))
    f, gradient = values(nlp, "nlp_grad_f", w, nlp.parameters)
    assert_close(gradient @ d, (after - before) / (2 * STEP))
    assert f == values(nlp, "nlp_f", w, nlp.parameters)[0] == values(nlp, "nlp", w, nlp.parameters)[0]


@pytest.mark.parametrize("seed", range(3))
def test_jacobian_against_finite_differences(transcribed: Transcribed, seed: int) -> None:
    nlp, w = transcribed.nlp, about_the_guess(transcribed, seed)
    d = direction(nlp, seed)
    (after,), (before,) = (values(nlp, "nlp_g", w + sign * STEP * d, nlp.parameters) for sign in (1, -1))
    g, jacobian = values(nlp, "nlp_jac_g", w, nlp.parameters)
    assert_close(jacobian @ d, (after - before) / (2 * STEP))
    np.testing.assert_array_equal(g, values(nlp, "nlp_g", w, nlp.parameters)[0])
    np.testing.assert_array_equal(g, values(nlp, "nlp", w, nlp.parameters)[1])


@pytest.mark.parametrize("seed", range(3))
def test_hessian_of_the_lagrangian_against_finite_differences(transcribed: Transcribed, seed: int) -> None:
    nlp, w = transcribed.nlp, about_the_guess(transcribed, seed)
    d, lam_f = direction(nlp, seed), 0.7
    lam_g = np.random.default_rng(seed).normal(size=nlp.rows)

    def lagrangian_gradient(at: Array) -> Array:
        gradient = values(nlp, "nlp_grad_f", at, nlp.parameters)[1]
        jacobian = values(nlp, "nlp_jac_g", at, nlp.parameters)[1]
        return lam_f * gradient + jacobian.T @ lam_g

    (upper,) = values(nlp, "nlp_hess_l", w, nlp.parameters, lam_f, lam_g)
    np.testing.assert_array_equal(upper, np.triu(upper))
    hessian = upper + np.triu(upper, 1).T
    difference = (lagrangian_gradient(w + STEP * d) - lagrangian_gradient(w - STEP * d)) / (2 * STEP)
    assert_close(hessian @ d, difference)


def test_cost_is_the_sum_of_the_terms(transcribed: Transcribed) -> None:
    nlp, w = transcribed.nlp, about_the_guess(transcribed)
    costs = nlp.costs(w)
    assert set(costs) == {cost.name for cost in transcribed.problem.costs}
    assert sum(costs.values()) == pytest.approx(float(values(nlp, "nlp_f", w, nlp.parameters)[0]))


# -- presolve ------------------------------------------------------------------------------------------------


def unreduced_violations(nlp: Nlp, w: Array) -> Array:
    """By how much every row of the problem as the terms state it is violated, sorted, zeros left out."""
    everything = np.append(nlp.all_variables(w), 0.0)
    found = []
    for block in nlp.blocks:
        stage = block.stage
        mapped = block.function.value.map(stage.count)
        rows = np.asarray(mapped(everything[block.variables], stage.parameters)[1])
        excess = np.maximum(stage.lower - rows, rows - stage.upper)
        found.append(excess[stage.holds])
    return significant(np.concatenate(found))


def significant(violations: Array) -> Array:
    assert not np.isnan(violations).any()
    return np.sort(violations[violations > 1e-9])


@pytest.mark.parametrize("seed", range(3))
def test_reduced_problem_says_what_the_unreduced_one_says(transcribed: Transcribed, seed: int) -> None:
    """Within the bounds the rows that are left are violated just as those of all terms are."""
    nlp, w = transcribed.nlp, about_the_guess(transcribed, seed)
    (g,) = values(nlp, "nlp_g", w, nlp.parameters)
    reduced = significant(nlp.violations(g, w))
    assert reduced.size > 0
    np.testing.assert_allclose(unreduced_violations(nlp, w), reduced, rtol=1e-6)


def test_what_violates_a_bound_violates_a_row(transcribed: Transcribed) -> None:
    nlp, w = transcribed.nlp, about_the_guess(transcribed)
    bounded = np.flatnonzero(np.isfinite(nlp.upper))
    assert bounded.size > 0
    for i in np.random.default_rng(0).choice(bounded, 20):
        beyond = w.copy()
        beyond[i] = nlp.upper[i] + 1e4
        assert unreduced_violations(nlp, beyond)[-1] > 1e3 > unreduced_violations(nlp, w)[-1]


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_known_is_no_variable(kind: str) -> None:
    problem = small_problem(kind)
    transcribed = transcribe(problem)
    trajectory = transcribed.decode(about_the_guess(transcribed))
    np.testing.assert_array_equal(trajectory.base[0, 0], problem.start.base)
    np.testing.assert_array_equal(trajectory.base_rate[0, 0], problem.start.base_rate)
    np.testing.assert_array_equal(trajectory.foot_xy[0, 0], problem.start.p_foot[:, :2])
    in_air = ~problem.schedule.contact.T
    np.testing.assert_array_equal(trajectory.force[in_air], 0.0)
    np.testing.assert_allclose(np.moveaxis(trajectory.foot_z, 1, 2)[~in_air], 0.0, atol=1e-12)


def test_every_row_that_is_left_has_a_free_variable(transcribed: Transcribed) -> None:
    rows = transcribed.nlp.jacobian_sparsity.get_triplet()[0]
    assert np.unique(rows).size == transcribed.nlp.rows == len(transcribed.nlp.origins)
    assert not transcribed.nlp.contradictions


# -- numbers are parameters ----------------------------------------------------------------------------------


@pytest.mark.parametrize("lengths", [None, 0.84 / 0.9 * np.array(UNEVEN)], ids=["even", "uneven"])
def test_another_robot_goal_and_mesh_need_no_new_functions(lengths: Array | None) -> None:
    first = transcribe(small_problem()).nlp
    scenario = small_problem().scenario.with_values(
        {"robot.mass": 70.0, "robot.inertia.xx": 12.0, "goal.x": 0.1, "ground.friction": 0.7}
        | {"weights.feet": 3.0, "interval": 0.14, "horizon": 0.84}
    )
    schedule = scenario.schedule
    if lengths is not None:
        schedule = ContactSchedule(schedule.contact, Mesh(lengths))
    other = transcribe(make_problem(scenario, schedule=schedule))
    w = about_the_guess(other)
    assert first.size == other.nlp.size
    for name in ("nlp_f", "nlp_g", "nlp_grad_f"):
        here, there = (values(nlp, name, w, other.nlp.parameters) for nlp in (first, other.nlp))
        for a, b in zip(here, there, strict=True):
            np.testing.assert_array_equal(a, b)


# -- rows of the user ----------------------------------------------------------------------------------------


class _Lean(Constraint):
    """r_x · slope_k ≤ 0.02, with a slope that is 0 in some intervals."""

    name = "lean"
    upper = 0.02
    places = INPUT

    def data(self, problem: object) -> dict[str, Array]:
        return {"slope": np.array([[0.0, 1.0, 0.0, -2.0, 1.0, 0.5]])}

    def expression(self, x: Instant, d: Data) -> ca.SX:
        return d.slope * x.r[0]


def test_a_row_that_vanishes_in_some_intervals_bounds_nothing_there() -> None:
    problem = small_problem()
    with_row = transcribe(make_problem(problem.scenario, [_Lean()]))
    free = transcribe(problem)
    assert not with_row.nlp.contradictions
    w = np.clip(about_the_guess(free), with_row.nlp.lower, with_row.nlp.upper)

    def excess(interval: int, x: float) -> float:
        nlp = with_row.nlp
        bounds = nlp.violations(np.zeros(nlp.rows), _with_x(free, w, interval, x))[nlp.rows :]
        return float(bounds.max())

    assert [excess(2, x) for x in (-9.0, 9.0)] == [0.0, 0.0], "slope 0"
    assert [excess(4, x) for x in (-9.0, 9.0)] == pytest.approx([0.0, 9.0 - 0.02]), "slope 1"
    assert [excess(5, x) for x in (-9.0, 9.0)] == pytest.approx([0.0, 9.0 - 0.04]), "slope 0.5"
    assert [excess(3, x) for x in (-9.0, 9.0)] == pytest.approx([9.0 - 0.01, 0.0]), "slope −2"


def _with_x(transcribed: Transcribed, w: Array, interval: int, x: float) -> Array:
    """The free variables with the CoM's x at a node changed: the one in which `decode` then differs."""
    reference = transcribed.decode(w).base[interval, 0, 0]
    for i in np.flatnonzero(np.isclose(w, reference, atol=1e-12)):
        moved = w.copy()
        moved[i] = x
        if transcribed.decode(moved).base[interval, 0, 0] == x:
            return moved
    raise AssertionError("no variable is the CoM's x at this node")


class _Elsewhere(FootConstraint):
    """Asks the front left foot to begin where it does not stand."""

    name = "elsewhere"
    places = INPUT
    unit = "m"

    def applies(self, problem: object, leg: int) -> bool:
        return leg == 0

    def limits(self, problem: object, leg: int) -> Limits:
        return 5.0, 6.0

    def holds(self, problem: object, place: Place, leg: int) -> Mask:
        return np.arange(6) == 0

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.p[0]


def test_a_row_that_contradicts_what_is_fixed_is_named() -> None:
    nlp = transcribe(make_problem(small_problem().scenario, [_Elsewhere()])).nlp
    ((origin, excess),) = nlp.contradictions
    assert (origin.label.describe(), origin.interval) == ("elsewhere of FL", 0)
    assert excess == pytest.approx(5.0 - 0.245)


@pytest.mark.parametrize("height", [-3.0, 0.1, 1234.567, 1e6])
def test_round_off_is_no_contradiction(height: float) -> None:
    assert not transcribe(small_problem(ground={"height": height})).nlp.contradictions
