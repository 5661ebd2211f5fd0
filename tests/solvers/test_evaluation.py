"""What fatrop asks for, by NumPy and in C: the same numbers in the same places, and the same solution."""

from __future__ import annotations

import shutil
import time

import numpy as np
import pytest

import rollgait as rg
from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.mpc import REPAIR, Mpc
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.mpc.settings import MpcSettings
from rollgait.ocp.problem import make_problem
from rollgait.scenario.scenario import Scenario
from rollgait.solvers import compiled_evaluation, fatrop_direct
from rollgait.solvers.fatrop import OPTIONS, REPAIR_OPTIONS, WARM_OPTIONS
from rollgait.solvers.fatrop_direct import DirectFatrop
from rollgait.solvers.fatrop_evaluation import Evaluation
from rollgait.transcription import transcribe
from rollgait.transcription.base import Transcribed
from rollgait.transcription.guess import kinematic_guess

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="needs a compiler")


@pytest.fixture(scope="module")
def planned() -> Transcribed:
    """With bounds of variables, equations and inequalities."""
    values = {"robot": "centauro", "goal": {"x": 0.1}, "horizon": 1.0, "profile": "executable"}
    return transcribe("condensed", make_problem(Scenario.from_dict(values)))


def solvers(planned: Transcribed) -> tuple[DirectFatrop, DirectFatrop]:
    """By NumPy and in C."""
    structure = planned.structure
    assert structure is not None
    by_numpy, in_c = (
        DirectFatrop(planned.nlp, structure, OPTIONS, WARM_OPTIONS, REPAIR_OPTIONS, kernels)
        for kernels in (False, True)
    )
    assert type(by_numpy._engine.evaluation) is Evaluation
    assert isinstance(in_c._engine.evaluation, compiled_evaluation.CompiledEvaluation)
    return by_numpy, in_c


def test_values_and_slopes_are_the_same_anywhere(planned: Transcribed) -> None:
    nlp, guess = planned.nlp, planned.encode(kinematic_guess(planned.problem))
    evaluations = [solver._engine.evaluation for solver in solvers(planned)]
    total = nlp.rows + int((np.isfinite(nlp.lower) | np.isfinite(nlp.upper)).sum())
    random = np.random.default_rng(0)
    for scale in (0.0, 0.1, 1.0):
        x = guess + scale * random.normal(size=guess.size)
        address, results = x.ctypes.data, []
        for evaluation in evaluations:
            evaluation.begin()
            cost, violation, gradient = np.zeros(1), np.zeros(total), np.zeros(nlp.size)
            evaluation.put_cost(0.7, address, cost.ctypes.data)
            evaluation.put_violation(address, violation.ctypes.data)
            evaluation.put_gradient(0.7, address, gradient.ctypes.data)
            w = evaluation.variables(address)
            worst = [evaluation.worst(address), evaluation.cost(address)]
            results.append(np.concatenate([cost, violation, gradient, w, worst, evaluation.values(w)[1]]))
        size = np.abs(results[0]).max()
        np.testing.assert_allclose(results[1], results[0], rtol=1e-12, atol=1e-12 * size)


def test_the_solution_is_the_same_and_so_is_all_that_was_put_on_the_way(planned: Transcribed) -> None:
    guess = planned.encode(kinematic_guess(planned.problem))
    by_numpy, in_c = solvers(planned)
    one, other = by_numpy.solve(guess), in_c.solve(guess)
    assert one.solved
    assert other.solved
    assert one.iterations == other.iterations
    np.testing.assert_allclose(other.w, one.w, atol=1e-9)
    np.testing.assert_allclose(other.g, one.g, atol=1e-9)
    assert one.multipliers is not None
    assert other.multipliers is not None
    for a, b in zip(one.multipliers, other.multipliers, strict=True):
        np.testing.assert_allclose(b, a, atol=1e-6 * max(1.0, float(np.abs(a).max(initial=0.0))))


def test_limits_and_parameters_may_change_between_solves(planned: Transcribed) -> None:
    guess, nlp = planned.encode(kinematic_guess(planned.problem)), planned.nlp
    by_numpy, in_c = solvers(planned)
    parameters = nlp.blocks[0].stage.parameters
    before = parameters.copy()
    costs = []
    try:
        for factor in (1.0, 1.1):
            parameters *= factor
            costs.append([by_numpy._engine.values(guess)[0], in_c._engine.values(guess)[0]])
    finally:
        parameters[:] = before
    assert costs[0][0] == pytest.approx(costs[0][1], rel=1e-12)
    assert costs[1][0] == pytest.approx(costs[1][1], rel=1e-12)
    assert costs[0][0] != costs[1][0]


@pytest.mark.parametrize("which", [0, 1], ids=["by NumPy", "in C"])
def test_numbers_that_are_none_end_a_solve(
    which: int, planned: Transcribed, monkeypatch: pytest.MonkeyPatch
) -> None:
    guess, solver = planned.encode(kinematic_guess(planned.problem)), solvers(planned)[which]
    monkeypatch.setattr(fatrop_direct, "refuse_unsolvable", lambda nlp, guess: None)
    parameters = planned.nlp.blocks[0].stage.parameters
    before = parameters.copy()
    parameters[:] = np.nan
    try:
        assert solver.solve(guess).status == "Invalid_Number_Detected"
    finally:
        parameters[:] = before


def test_a_step_of_the_controller_needs_no_estimate_of_multipliers() -> None:
    """In one's own thread none is made, in another one it is: its Hessians know nothing of multipliers."""
    mpc = Mpc("centauro", MpcSettings(deadline=60.0), gait="trot")
    plant = RigidPlant(rg.find_robot("centauro"))
    for _ in range(75):  # feet are in the air
        control, _ = mpc.step(plant.state, VelocityCommand(forward=0.3))
        plant.step(control)
    guess, solver = mpc._iterate.variables().copy(), mpc._solver
    assert isinstance(solver, DirectFatrop)
    guess += 1e-3 * np.random.default_rng(0).normal(size=guess.size)
    here, beside = (
        solver.solve(guess, warm=True, until=time.perf_counter() + s, iterations=1, repair=REPAIR)
        for s in (0.9, 60.0)
    )
    assert here.iterations == beside.iterations
    np.testing.assert_allclose(here.w, beside.w, atol=1e-9)
    assert np.abs(here.w - guess).max() > 1e-4
