"""A solver ends when it is told, forgets how it was asked before, and comes back whatever it is given."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import FrameType

import numpy as np
import pytest

from rollgait.errors import NotSolvedError
from rollgait.solvers import Iteration, Repair, Solver, make_solver
from rollgait.solvers.budget import Budget
from rollgait.solvers.fatrop import Fatrop
from rollgait.solvers.refusal import LARGEST
from rollgait.solvers.watched import NoAnswerError, call_watched
from rollgait.transcription import transcribe
from rollgait.transcription.base import Transcribed
from rollgait.transcription.guess import kinematic_guess
from tests.transcription.problems import small_problem

ROOT = Path(__file__).parents[2]
WAYS = ("fatrop", "fatrop by nlpsol", "ipopt")
GOAL = {"x": 0.1, "yaw_deg": 10}


def solver_of(way: str, transcribed: Transcribed) -> Solver:
    if way == "fatrop by nlpsol":
        assert transcribed.structure is not None
        return Fatrop(transcribed.nlp, transcribed.structure)
    return make_solver(way, transcribed, kernels=False)


@pytest.fixture
def transcribed() -> Transcribed:
    """A problem of its own for each test: its numbers are changed."""
    return transcribe("condensed", small_problem(goal=GOAL))


@pytest.fixture
def guess(transcribed: Transcribed) -> np.ndarray:
    return transcribed.encode(kinematic_guess(transcribed.problem))


# -- what was asked before -----------------------------------------------------------------------------------


@pytest.mark.parametrize("way", WAYS)
def test_a_warm_solve_leaves_nothing_to_a_cold_one(
    way: str, transcribed: Transcribed, guess: np.ndarray
) -> None:
    solver = solver_of(way, transcribed)
    first = solver.solve(guess)
    warm = solver.solve(first.w, warm=True)
    again = solver.solve(guess)
    assert first.solved
    assert warm.solved
    assert again.iterations == first.iterations
    np.testing.assert_array_equal(again.w, first.w)


def test_one_warm_iteration_from_a_solution_keeps_what_it_has_right(
    transcribed: Transcribed, guess: np.ndarray
) -> None:
    """Forces of a solution lie at their limits: a start that is moved away from those breaks the dynamics."""
    solver = solver_of("fatrop", transcribed)
    solution = solver.solve(guess)
    next_one = solver.solve(solution.w, warm=True, iterations=1)
    assert next_one.iterations == 1
    assert solver.violation(next_one.w) < 1e-4


@pytest.mark.parametrize("way", WAYS)
def test_a_limited_solve_leaves_nothing_to_the_next(
    way: str, transcribed: Transcribed, guess: np.ndarray
) -> None:
    solver = solver_of(way, transcribed)
    first = solver.solve(guess)
    assert not solver.solve(guess, iterations=2).solved
    np.testing.assert_array_equal(solver.solve(guess).w, first.w)


@pytest.mark.parametrize("way", WAYS)
def test_numbers_are_those_of_now(way: str, transcribed: Transcribed, guess: np.ndarray) -> None:
    solver, nlp = solver_of(way, transcribed), transcribed.nlp
    before = solver.solve(guess)
    block = nlp.blocks[0]
    begin = 0
    for name, size in block.function.parameters:
        if name == "mass":
            block.stage.parameters[begin : begin + size] *= 1.001
        begin += size
    heavier, violation = solver.solve(guess), solver.violation(before.w)
    f, g = (np.asarray(v).ravel() for v in nlp.functions["nlp"](heavier.w, nlp.parameters))
    assert abs(heavier.cost - before.cost) > 1e-9
    assert heavier.cost == pytest.approx(float(f[0]), abs=1e-9)
    np.testing.assert_allclose(heavier.g, g, atol=1e-9)
    g = np.asarray(nlp.functions["nlp_g"](before.w, nlp.parameters)).ravel()
    assert violation == pytest.approx(nlp.violations(g, before.w).max(), abs=1e-12)


# -- when to end ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("most", [2, 3, 5])
def test_no_more_iterations_than_asked_for(
    way: str, most: int, transcribed: Transcribed, guess: np.ndarray
) -> None:
    solution = solver_of(way, transcribed).solve(guess, iterations=most)
    assert not solution.solved
    assert solution.iterations == most
    assert not np.array_equal(solution.w, guess)


@pytest.mark.parametrize("way", ["fatrop", "ipopt"])
def test_no_iteration_begins_that_would_end_too_late(
    way: str, transcribed: Transcribed, guess: np.ndarray
) -> None:
    def slow(iteration: Iteration) -> None:
        time.sleep(0.1)

    solver = solver_of(way, transcribed)
    assert solver.solve(guess).iterations > 5
    begin = time.perf_counter()
    solution = solver.solve(guess, slow, until=begin + 0.35)
    assert not solution.solved
    assert 1 <= solution.iterations <= 3


# -- more iterations where they are needed -------------------------------------------------------------------


@pytest.mark.parametrize("asked", [1, 2])
def test_a_repair_is_what_more_iterations_would_have_been(
    asked: int, transcribed: Transcribed, guess: np.ndarray
) -> None:
    solver = make_solver("fatrop", transcribed, kernels=False)

    def solve(above: float) -> np.ndarray:
        return solver.solve(guess, iterations=asked, repair=Repair(above, 4)).w

    few, many = solver.solve(guess, iterations=asked), solver.solve(guess, iterations=4)
    assert solver.violation(few.w) > solver.violation(many.w) > 0.0
    np.testing.assert_array_equal(solve(np.inf), few.w)
    np.testing.assert_array_equal(solve(0.0), many.w)
    np.testing.assert_array_equal(solve(solver.violation(few.w)), few.w)  # as much as that needs none
    assert solver.violation(solve(0.999 * solver.violation(few.w))) < solver.violation(few.w)


def test_repairs_end_as_soon_as_they_may() -> None:
    repair = Repair(above=0.02, iterations=4)

    def made(violations: list[float], iterations: int | None = 1) -> int:
        budget = Budget(iterations=iterations, repair=repair)
        return next(n for n, v in enumerate(violations, 1) if not budget.allows_another(n, v))

    assert made([0.02]) == 1
    assert made([0.021, 0.01]) == 2
    assert made([1.0, np.nan, 0.03, 0.03]) == 4
    assert made([0.0, 0.0, 1.0, 1.0], iterations=2) == 2
    assert made([1.0] * 6, iterations=6) == 6
    assert not Budget(until=0.0, iterations=3, repair=repair).allows_another(1, 1.0)  # it is late already


# -- in whose thread -----------------------------------------------------------------------------------------

SOON = 0.9
"""s: who waits for no longer has the solve in his own thread, if there is a compiler."""
needs_product = pytest.mark.skipif(
    not sys.platform.startswith("linux") or shutil.which("cc") is None, reason="needs Linux and a compiler"
)


@needs_product
def test_a_solve_in_the_own_thread_and_one_beside_it_are_the_same(
    transcribed: Transcribed, guess: np.ndarray
) -> None:
    solver, threads = make_solver("fatrop", transcribed), set()

    def who(iteration: Iteration) -> None:
        threads.add(threading.get_ident())

    here = solver.solve(guess, who, until=time.perf_counter() + SOON, iterations=8)
    if solver.linear_algebra != "BLASFEO":  # (somebody may have loaded BLASFEO before in this process)
        assert threads == {threading.get_ident()}
    beside = solver.solve(guess, who, iterations=here.iterations)
    assert threads - {threading.get_ident()}
    np.testing.assert_array_equal(here.w, beside.w)


@pytest.mark.skipif(not hasattr(signal, "SIGUSR1"), reason="no such signal")
def test_what_a_signal_raises_comes_out_of_a_solve_that_is_waited_for(
    transcribed: Transcribed, guess: np.ndarray
) -> None:
    class ToldError(Exception):
        pass

    def handle(number: int, frame: FrameType | None) -> None:
        raise ToldError

    solver = make_solver("fatrop", transcribed)
    wanted = solver.solve(guess)
    before = signal.signal(signal.SIGUSR1, handle)
    try:
        with pytest.raises(ToldError):
            solver.solve(
                guess,
                lambda iteration: signal.raise_signal(signal.SIGUSR1),
                until=time.perf_counter() + SOON,
            )
        assert signal.getsignal(signal.SIGUSR1) is handle
    finally:
        signal.signal(signal.SIGUSR1, before)
    np.testing.assert_array_equal(solver.solve(guess).w, wanted.w)


# -- what it is not asked ------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", WAYS)
def test_limits_that_cross_are_refused_by_name(way: str, transcribed: Transcribed, guess: np.ndarray) -> None:
    solver, nlp = solver_of(way, transcribed), transcribed.nlp
    row = int(np.flatnonzero(nlp.g_lower != nlp.g_upper)[0])
    name = nlp.origins[row].label.describe()
    nlp.g_lower[row], nlp.g_upper[row] = 1.0, -1.0
    with pytest.raises(
        NotSolvedError, match=f"^no solution exists: {name} would have to lie between 1 and -1$"
    ):
        solver.solve(guess)


def test_bounds_that_cross_are_refused_by_the_name_of_their_constraint(
    transcribed: Transcribed, guess: np.ndarray
) -> None:
    nlp = transcribed.nlp
    variable = next(i for i, origin in enumerate(nlp.bound_origins[0]) if origin is not None)
    origin = nlp.bound_origins[0][variable]
    assert origin is not None
    nlp.upper[variable] = nlp.lower[variable] - 1.0
    with pytest.raises(NotSolvedError, match=f"^no solution exists: {origin.label.describe()} would have to"):
        make_solver("fatrop", transcribed, kernels=False).solve(guess)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 2.0 * LARGEST])
@pytest.mark.parametrize("where", ["guess", "parameter", "limit"])
def test_numbers_of_no_use_are_refused(
    wrong: float, where: str, transcribed: Transcribed, guess: np.ndarray
) -> None:
    nlp, solver = transcribed.nlp, make_solver("fatrop", transcribed, kernels=False)
    if where == "guess":
        guess[3] = wrong
    elif where == "parameter":
        nlp.fixed_values[0] = wrong
    else:
        row = int(np.flatnonzero((nlp.g_lower != nlp.g_upper) & np.isfinite(nlp.g_lower))[0])
        (nlp.g_upper if wrong == -np.inf else nlp.g_lower)[row] = wrong
    with pytest.raises(NotSolvedError, match=r"^no solver was asked: a |^no solution exists: ") as caught:
        solver.solve(guess)
    assert f"{wrong:.6g}" in str(caught.value)


# -- coming back ---------------------------------------------------------------------------------------------

STUCK = """
import sys, time
sys.path.insert(0, {root!r})
import numpy as np
from rollgait.solvers import make_solver
from rollgait.solvers.fatrop import Fatrop
from rollgait.transcription import transcribe
from rollgait.transcription.guess import kinematic_guess
from tests.transcription.problems import small_problem

transcribed = transcribe("condensed", small_problem(goal={goal!r}))
solver = {solver}
good = transcribed.encode(kinematic_guess(transcribed.problem))
far = {scale} * np.random.default_rng(0).normal(size=good.size)
lost = solver.solve(far, until=time.perf_counter() + {seconds})
print(lost.solved, lost.status, np.array_equal(lost.w, far))
print(solver.solve(good, until=time.perf_counter() + 100.0 * {seconds}).solved)
"""
"""From a guess so far off, fatrop looks for a factorisation without end."""
DIRECT = 'make_solver("fatrop", transcribed, kernels=False)'
BY_NLPSOL = "Fatrop(transcribed.nlp, transcribed.structure)"


HERE = 'make_solver("fatrop", transcribed)'


@pytest.mark.parametrize(
    ("solver", "seconds"),
    [(DIRECT, 1.0), (BY_NLPSOL, 1.0), pytest.param(HERE, 0.3, marks=needs_product)],
    ids=["fatrop", "fatrop by nlpsol", "fatrop in this thread"],
)
@pytest.mark.parametrize("scale", [1e2, 1e6])
def test_who_asks_a_solver_that_gets_lost_goes_on(solver: str, scale: float, seconds: float) -> None:
    script = STUCK.format(root=str(ROOT), goal=GOAL, solver=solver, scale=scale, seconds=seconds)
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    solved, status, unchanged, goes_on = done.stdout.split()
    assert (solved, unchanged, goes_on) == ("False", "True", "True")
    assert status in ("No_Answer", "Invalid_Number_Detected")  # whether it gets lost depends on the problem
    assert ("it is left behind" in done.stderr) == (status == "No_Answer")


@needs_product
def test_a_solve_in_the_own_thread_that_gets_lost_leaves_nothing_running() -> None:
    script = STUCK.format(root=str(ROOT), goal=GOAL, solver=HERE, scale=1e2, seconds=0.3)
    script += "import threading\nfrom rollgait.solvers.watched import _idle\n"
    script += "print(solver.linear_algebra, threading.active_count() - len(_idle), sep='; ')\n"
    script = "import rollgait.solvers.fatrop_engine as engine; engine.SHORT = 1000.0\n" + script
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    first, _, last = done.stdout.splitlines()
    assert first == "False No_Answer True"
    assert last == "BLASFEO, product compiled for this processor; 1"


def test_derivatives_that_are_no_numbers_end_a_solve(transcribed: Transcribed, guess: np.ndarray) -> None:
    solver = make_solver("fatrop", transcribed, kernels=False)
    stage = solver._engine.evaluation.stages[0]  # type: ignore[attr-defined]
    for name in ("jacobian", "hessian"):
        original = getattr(stage, name)

        def broken(*arguments: object, original: object = original) -> object:
            values = original(*arguments)  # type: ignore[operator]
            (values[0] if isinstance(values, tuple) else values)[0] = np.nan
            return values

        setattr(stage, name, broken)
        solution = solver.solve(guess)
        setattr(stage, name, original)
        assert solution.status == "Invalid_Number_Detected", name
        assert solver.solve(guess).solved, name


def test_a_call_that_is_silent_is_left_and_one_that_works_is_not() -> None:
    over, beats = threading.Event(), [0]

    def spin(signs: bool) -> str:
        end = time.thread_time() + 0.6
        while not over.is_set() and (not signs or time.thread_time() < end):
            beats[0] += signs
        return "done"

    assert call_watched(lambda: spin(True), lambda: beats[0], 0.2) == "done"
    with pytest.raises(NoAnswerError, match=r"^no sign of life for 0\.2 s$"):
        call_watched(lambda: spin(False), lambda: beats[0], 0.2)
    over.set()
    with pytest.raises(ZeroDivisionError):
        call_watched(lambda: 1 // 0, lambda: 0, 0.2)  # what it raises is raised here


def test_a_call_has_the_numerical_settings_of_its_caller() -> None:
    with np.errstate(over="raise"), pytest.raises(FloatingPointError):
        call_watched(lambda: np.float64(1e300) * np.float64(1e300), lambda: 0, 1.0)
