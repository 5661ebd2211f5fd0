"""Every solver ends when it is told to, and hands over what it has."""

from __future__ import annotations

import time
from typing import Any

import pytest

from rollgait.ocp.problem import make_problem
from rollgait.scenario.scenario import Scenario
from rollgait.solvers import Iteration, Solver, make_solver
from rollgait.solvers.fatrop import Fatrop
from rollgait.transcription import transcribe
from rollgait.transcription.guess import kinematic_guess

ASKED = {"robot": "centauro", "goal": {"x": 0.3}, "horizon": 2.0, "interval": 0.2}
ENOUGH = 500


@pytest.fixture(scope="module")
def transcribed() -> Any:
    return transcribe("condensed", make_problem(Scenario.from_dict(ASKED)), None)


@pytest.fixture(params=["fatrop", "ipopt", "fatrop by nlpsol"])
def solver(request: pytest.FixtureRequest, transcribed: Any) -> Solver:
    if request.param == "fatrop by nlpsol":
        return Fatrop(transcribed.nlp, transcribed.structure)
    return make_solver(request.param, transcribed, kernels=False)


def test_no_more_iterations_than_told(solver: Solver, transcribed: Any) -> None:
    guess, heard = transcribed.encode(kinematic_guess(transcribed.problem)), list[Iteration]()
    solution = solver.solve(guess, heard.append, iterations=3)
    assert not solution.solved
    assert solution.iterations <= 4
    assert len(heard) <= 4
    assert solution.w.shape == guess.shape
    again = solver.solve(guess, iterations=ENOUGH)
    assert again.solved
    assert again.iterations > 4


def test_none_after_its_time(solver: Solver, transcribed: Any) -> None:
    if isinstance(solver, Fatrop):
        pytest.skip("called through CasADi it reports at the end")
    guess, heard = transcribed.encode(kinematic_guess(transcribed.problem)), list[Iteration]()
    solution = solver.solve(guess, heard.append, until=time.perf_counter())
    assert not solution.solved
    assert len(heard) <= 1
    assert solver.solve(guess).solved
