"""All ways to solve a problem find the same solution; what cannot be combined is refused."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest

import rollgait as rg
from rollgait.errors import UnknownNameError
from rollgait.solvers import SOLVER_NAMES, Iteration, Solution, Solver, make_solver
from rollgait.solvers.fatrop import Fatrop
from rollgait.transcription import transcribe
from rollgait.transcription.base import Transcribed
from rollgait.transcription.guess import kinematic_guess
from tests.transcription.problems import KINDS, small_problem

WAYS = ("fatrop", "fatrop by nlpsol", "ipopt")


def solver_of(way: str, transcribed: Transcribed) -> Solver:
    """A solver by name, and fatrop's by CasADi, which stands in where the direct one does not fit."""
    if way == "fatrop by nlpsol":
        assert transcribed.structure is not None
        return Fatrop(transcribed.nlp, transcribed.structure)
    return make_solver(way, transcribed)


def solved(transcribed: Transcribed, way: str) -> Solution:
    solution = solver_of(way, transcribed).solve(transcribed.encode(kinematic_guess(transcribed.problem)))
    assert solution.solved, solution.status
    return solution


@pytest.fixture(scope="module", params=KINDS)
def transcribed(request: pytest.FixtureRequest) -> Transcribed:
    return transcribe("condensed", small_problem(request.param, goal={"x": 0.03, "yaw_deg": 2}))


@pytest.fixture(scope="module")
def solutions(transcribed: Transcribed) -> dict[str, Solution]:
    return {way: solved(transcribed, way) for way in WAYS}


def test_all_solvers_find_the_same_solution(transcribed: Transcribed, solutions: dict[str, Solution]) -> None:
    reference = solutions["ipopt"]
    problem = transcribed.problem
    times, robot = np.linspace(0.0, problem.schedule.horizon, 50), problem.robot
    for way, solution in solutions.items():
        assert solution.cost == pytest.approx(reference.cost, rel=1e-4), way
        found, expected = (transcribed.decode(w).sample(times, robot) for w in (solution.w, reference.w))
        np.testing.assert_allclose(found.com_position, expected.com_position, atol=2e-4, err_msg=way)


def test_a_solution_is_what_it_says(transcribed: Transcribed, solutions: dict[str, Solution]) -> None:
    """Feasible, with the cost and the constraints of its variables, and no worse than its surroundings."""
    nlp = transcribed.nlp
    for way, solution in solutions.items():
        assert nlp.violations(solution.g, solution.w).max() < 1e-5, way
        f, g = (np.asarray(v).squeeze() for v in nlp.functions["nlp"](solution.w, nlp.parameters))
        assert solution.cost == pytest.approx(float(f))
        np.testing.assert_allclose(solution.g, g, atol=1e-12)


@pytest.mark.parametrize("way", ["fatrop", "ipopt"])
def test_from_its_own_solution_a_solver_is_soon_done(transcribed: Transcribed, way: str) -> None:
    solver = solver_of(way, transcribed)
    cold = solver.solve(transcribed.encode(kinematic_guess(transcribed.problem)))
    warm = solver.solve(cold.w, warm=True)
    assert warm.solved
    assert warm.cost == pytest.approx(cold.cost, rel=5e-5)  # both stop at a tolerance of 1e-5, from two sides
    assert warm.iterations <= cold.iterations


@pytest.mark.parametrize("way", ["fatrop", "ipopt"])
def test_a_solver_can_be_used_again(transcribed: Transcribed, way: str) -> None:
    solver, guess = solver_of(way, transcribed), transcribed.encode(kinematic_guess(transcribed.problem))
    first, second = solver.solve(guess), solver.solve(guess)
    np.testing.assert_array_equal(first.w, second.w)
    assert first.iterations == second.iterations


@pytest.mark.parametrize("way", ["fatrop", "ipopt"])
def test_progress_hears_of_every_iteration(transcribed: Transcribed, way: str) -> None:
    seen: list[Iteration] = []
    guess = transcribed.encode(kinematic_guess(transcribed.problem))
    solution = solver_of(way, transcribed).solve(guess, seen.append)
    numbers = [iteration.number for iteration in seen]
    assert numbers == list(range(numbers[0], numbers[0] + len(seen)))
    assert abs(len(seen) - solution.iterations) <= 1
    assert seen[-1].cost == pytest.approx(solution.cost, rel=1e-3)


@pytest.mark.parametrize(("way", "at"), list(product(["fatrop", "ipopt"], [1, 3])))
def test_what_progress_raises_ends_the_solver(transcribed: Transcribed, way: str, at: int) -> None:
    def stop(iteration: Iteration) -> None:
        if iteration.number == at:
            raise RuntimeError("enough")

    solver, guess = solver_of(way, transcribed), transcribed.encode(kinematic_guess(transcribed.problem))
    with pytest.raises(RuntimeError, match="enough"):
        solver.solve(guess, stop)
    assert solver.solve(guess).solved  # and leaves it as it was


def test_a_solver_without_stages_is_named_where_there_are_none() -> None:
    transcribed = transcribe("collocation", small_problem())
    with pytest.raises(rg.InputError, match=r"solver: 'fatrop' cannot solve .*'collocation'; valid: ipopt"):
        make_solver("fatrop", transcribed)
    asked: dict[str, Any] = {"transcription": "collocation", "solver": "fatrop"}
    with pytest.raises(rg.InputError, match="valid: ipopt"):
        rg.plan(transcribed.problem.scenario, **asked)


def test_an_unknown_solver_lists_the_known() -> None:
    with pytest.raises(UnknownNameError) as caught:
        make_solver("snopt", transcribe("condensed", small_problem()))
    assert set(caught.value.choices) == set(SOLVER_NAMES)
