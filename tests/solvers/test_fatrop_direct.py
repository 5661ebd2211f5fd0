"""The direct adapter of fatrop: it goes with its last user, and gives way where the library is another."""

from __future__ import annotations

import gc
import logging
import weakref

import numpy as np
import pytest

from rollgait.ocp.problem import make_problem
from rollgait.scenario.scenario import Scenario
from rollgait.solvers import fatrop_library
from rollgait.solvers.fatrop import Fatrop, make_solver
from rollgait.solvers.fatrop_direct import DirectFatrop
from rollgait.transcription import transcribe
from rollgait.transcription.base import Transcribed
from rollgait.transcription.guess import kinematic_guess


@pytest.fixture
def transcribed() -> Transcribed:
    scenario = Scenario.from_dict({"robot": "centauro", "goal": {"x": 0.1}, "horizon": 1.0})
    return transcribe("condensed", make_problem(scenario))


def test_it_is_freed_without_the_garbage_collector(transcribed: Transcribed) -> None:
    solver = make_solver(transcribed, kernels=False)
    assert isinstance(solver, DirectFatrop)
    assert solver.solve(transcribed.encode(kinematic_guess(transcribed.problem))).solved
    alive = weakref.ref(solver)
    gc.disable()
    try:
        del solver
        assert alive() is None
    finally:
        gc.enable()


def test_it_can_be_solved_again_from_another_guess(transcribed: Transcribed) -> None:
    solver = make_solver(transcribed, kernels=False)
    guess = transcribed.encode(kinematic_guess(transcribed.problem))
    first = solver.solve(guess)
    again = solver.solve(first.w, warm=True)
    third = solver.solve(guess)
    assert first.solved
    assert again.solved
    assert again.cost == pytest.approx(first.cost, rel=1e-4)
    assert third.cost == pytest.approx(first.cost, rel=1e-12)


def test_another_library_means_the_way_through_casadi(
    transcribed: Transcribed, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    # an interface whose sizes stand elsewhere, as in another version of the library
    fields = list(fatrop_library.Dims._fields_)
    other = type("Dims", (fatrop_library.Structure,), {"_fields_": [("new", fatrop_library.c_int), *fields]})
    loaded = fatrop_library.library()
    monkeypatch.setattr(loaded.fatrop_ocp_c_get_dims, "restype", fatrop_library.POINTER(other))
    with caplog.at_level(logging.INFO, logger="rollgait"):
        solver = make_solver(transcribed, kernels=False)
    assert isinstance(solver, Fatrop)
    assert [record.message for record in caplog.records] == [
        "fatrop's C interface is not the expected one: it reports other sizes: calling it through CasADi, "
        "which is slower"
    ]
    assert solver.solve(transcribed.encode(kinematic_guess(transcribed.problem))).solved


def test_fatrop_writes_only_the_last_rows_of_its_matrices(transcribed: Transcribed) -> None:
    """What is zero in all of them is made zero once: nobody else may have written there."""
    solver = make_solver(transcribed, kernels=False)
    assert isinstance(solver, DirectFatrop)
    guess = transcribed.encode(kinematic_guess(transcribed.problem))
    far = guess + 0.3 * np.random.default_rng(0).normal(size=guess.size)
    solver.solve(far)  # difficult: regularised again and again
    assert solver.solve(guess).solved
    engine = solver._engine.evaluation
    assert len(engine.hessians) > 1, "two sets of matrices take turns"
    left = [part for fill in engine.hessians.values() for part in fill.untouched()]
    left += [part for fill in engine.jacobians.values() for part in fill.untouched()]
    assert sum(part.size for part in left) > 10_000
    np.testing.assert_array_equal(np.concatenate(left), 0.0)
