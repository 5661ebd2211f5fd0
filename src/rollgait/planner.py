"""From a scenario to a plan."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rollgait.diagnosis.entry import Investigation
from rollgait.errors import InputError, NotSolvedError, UnknownNameError
from rollgait.ocp.problem import Problem, make_problem
from rollgait.ocp.term import Term
from rollgait.plan.plan import Plan, StartResult, Statistics
from rollgait.scenario.library import find_scenario
from rollgait.scenario.scenario import Scenario
from rollgait.solvers import SOLVER_NAMES, Iteration, Progress, Solution, Solver, make_solver
from rollgait.solvers.ipopt import Ipopt
from rollgait.solvers.kernels import compiled
from rollgait.starts import Start, starts
from rollgait.transcription import TRANSCRIPTION_NAMES, transcribe
from rollgait.transcription.base import Transcribed
from rollgait.transcription.guess import Motion
from rollgait.transcription.nlp import Nlp

Array = NDArray[np.float64]

VIOLATION_TOLERANCE = 1e-6
"""Scaled violation of a constraint above which it is named in the statistics."""
FALLBACKS = 4
"""Starts that are tried before a problem is given up."""


def plan(
    scenario: str | Path | Scenario,
    *,
    profile: str | None = None,
    transcription: str | None = None,
    solver: str | None = None,
    terms: Sequence[Term] = (),
    warm_start: Plan | str | Path | None = None,
    multistart: int = 1,
    seed: int = 0,
    kernels: bool = True,
    diagnose: bool = True,
    progress: Progress | None = None,
) -> Plan:
    """Plans a motion.

    Args:
        scenario: a scenario, the name of one in the library, or the path of a YAML file.
        profile: `paper` or `executable`, in place of the scenario's own.
        transcription: how the problem becomes a nonlinear program, one of `TRANSCRIPTION_NAMES`. Default:
            `condensed`.
        solver: what solves that, one of `SOLVER_NAMES`. Default: what suits the transcription, `fatrop` for
            condensed, `ipopt` for collocation.
        terms: further costs and constraints of your own.
        warm_start: a plan to start from (or its file), also for another goal or horizon.
        multistart: how many initial guesses are solved to take the cheapest result. With 1, further ones are
            tried only where the first fails.
        seed: of the random ones among the initial guesses.
        kernels: whether to use compiled stage functions where there is a compiler.
        diagnose: whether to look for the reason if no start converges.
        progress: is called after each iteration of the solver.

    Returns:
        The plan. The solver converged, but whether the plan is good its `certificate()` says.

    Raises:
        InputError: something in the input is wrong.
        NotSolvedError: no start converged; the last iterate is the error's `plan`, marked as not solved, and
            the reason its `diagnosis`.
    """
    begin = time.perf_counter()
    transcription, solver = _methods(transcription, solver)
    if multistart < 1:
        raise InputError("multistart", multistart, "must be at least 1")
    if seed < 0:
        raise InputError("seed", seed, "must be at least 0")
    asked = scenario if isinstance(scenario, Scenario) else find_scenario(str(scenario))
    if profile is not None:
        asked = asked.with_values({"profile": profile})
    earlier = Plan.load(warm_start) if isinstance(warm_start, str | Path) else warm_start
    method = _Method(transcription, solver, kernels)
    problem = make_problem(asked, terms)
    try:
        ready = _Ready(method, problem)
    except NotSolvedError as error:
        if diagnose:
            error.diagnosis = Investigation(asked, terms, kernels, progress).diagnosis()
        raise
    build_time = time.perf_counter() - begin
    guesses = starts(problem, method.solve, earlier, seed)
    attempts = list(_attempts(ready, guesses, multistart, progress))
    why = None
    if diagnose and not any(attempt.solution.solved for attempt in attempts):
        why = Investigation(asked, terms, kernels, progress)
        attempts += _elastic_attempts(ready, why.motion, progress)
    solved = [attempt for attempt in attempts if attempt.solution.solved]
    best = min(solved, key=lambda a: a.solution.cost) if solved else min(attempts, key=lambda a: a.violation)
    result = _as_plan(ready, best, attempts, method, build_time)
    if not solved:
        diagnosis = None if why is None else why.diagnosis()
        raise NotSolvedError(_failure(result, len(attempts)), result, diagnosis)
    return result


def _elastic_attempts(ready: _Ready, motion: Motion | None, progress: Progress | None) -> Iterator[_Attempt]:
    """Solves from a motion that keeps all constraints, if there is one after all; with IPOPT if need be."""
    if motion is None:
        return
    guess = ready.transcribed.encode(motion)
    attempt = _attempt(ready, ready.solver, Start("elastic", lambda: motion, warm=True), guess, progress)
    yield attempt
    if not attempt.solution.solved and not isinstance(ready.solver, Ipopt):
        start = Start("elastic, by ipopt", lambda: motion)
        yield _attempt(ready, Ipopt(ready.transcribed.nlp), start, guess, progress)


@dataclass(frozen=True)
class _Method:
    """How a problem is solved."""

    transcription: str
    solver: str
    kernels: bool

    def solve(self, problem: Problem, motion: Motion) -> Motion | None:
        """The solution of another problem from a motion, by the same method; None if there is none."""
        ready = _Ready(self, problem)
        solution = ready.solver.solve(ready.transcribed.encode(motion))
        if not solution.solved:
            return None
        trajectory = ready.transcribed.decode(solution.w)
        return lambda times: trajectory.sample(times, problem.robot)


class _Ready:
    """A problem, transcribed, with its solver."""

    def __init__(self, method: _Method, problem: Problem) -> None:
        self.problem = problem
        self.transcribed: Transcribed = transcribe(
            method.transcription, problem, compiled if method.kernels else None
        )
        _refuse_contradictions(self.transcribed.nlp, problem)
        self._method = method
        self.solver = self.another_solver()

    def another_solver(self) -> Solver:
        """A further solver for the same problem, for another thread."""
        return make_solver(self._method.solver, self.transcribed, self._method.kernels)


@dataclass(frozen=True)
class _Attempt:
    """What came of a start."""

    start: Start
    solution: Solution
    solve_time: float
    violation: float
    solver: str

    def result(self) -> StartResult:
        s = self.solution
        return StartResult(self.start.name, s.solved, s.cost, s.iterations, self.solve_time)


def _methods(transcription: str | None, solver: str | None) -> tuple[str, str]:
    if transcription is not None and transcription not in TRANSCRIPTION_NAMES:
        raise UnknownNameError("transcription", transcription, TRANSCRIPTION_NAMES)
    if solver is not None and solver not in SOLVER_NAMES:
        raise UnknownNameError("solver", solver, SOLVER_NAMES)
    if solver is None:
        solver = "ipopt" if transcription == "collocation" else "fatrop"
    return transcription or "condensed", solver


def _attempts(
    ready: _Ready, guesses: Iterator[Start], multistart: int, progress: Progress | None
) -> Iterator[_Attempt]:
    """Solves from `multistart` starts at once, then one by one until one is solved, FALLBACKS at the most."""
    first = list(_guesses_of(ready, islice(guesses, multistart)))
    attempts = _side_by_side(ready, first, progress) if len(first) > 1 else _in_turn(ready, first, progress)
    solved = False
    for attempt in attempts:
        solved = solved or attempt.solution.solved
        yield attempt
    for guess in _guesses_of(ready, islice(guesses, max(0, FALLBACKS - multistart))):
        if solved:
            return
        for attempt in _in_turn(ready, [guess], progress):
            solved = attempt.solution.solved
            yield attempt


def _guesses_of(ready: _Ready, some: Iterator[Start]) -> Iterator[tuple[Start, Array]]:
    """Starts with their guesses of the variables; those that do not apply are left out."""
    for start in some:
        motion = start.motion()
        if motion is not None:
            yield start, ready.transcribed.encode(motion)


def _in_turn(
    ready: _Ready, guesses: Sequence[tuple[Start, Array]], progress: Progress | None
) -> Iterator[_Attempt]:
    for start, guess in guesses:
        yield _attempt(ready, ready.solver, start, guess, progress)


def _side_by_side(
    ready: _Ready, guesses: Sequence[tuple[Start, Array]], progress: Progress | None
) -> Iterator[_Attempt]:
    """Solves on the cores there are, if the solver can run more than once at a time; Ctrl-C ends all."""
    cores = min(len(guesses), os.cpu_count() or 1)
    if cores < 2 or not getattr(ready.solver, "runs_side_by_side", False):
        yield from _in_turn(ready, guesses, progress)
        return
    solvers = [ready.solver, *(ready.another_solver() for _ in guesses[1:])]
    over = threading.Event()

    def watched(number: int) -> Progress:
        def report(iteration: Iteration) -> None:
            if over.is_set():
                raise KeyboardInterrupt
            if number == 0 and progress is not None:
                progress(iteration)

        return report

    with ThreadPoolExecutor(cores) as pool:
        try:
            futures = [
                pool.submit(_attempt, ready, solver, start, guess, watched(number))
                for number, (solver, (start, guess)) in enumerate(zip(solvers, guesses, strict=True))
            ]
            yield from [future.result() for future in futures]
        finally:
            over.set()


def _attempt(
    ready: _Ready, solver: Solver, start: Start, guess: Array, progress: Progress | None
) -> _Attempt:
    begin = time.perf_counter()
    solution = solver.solve(guess, progress, start.warm)
    violation = float(ready.transcribed.nlp.violations(solution.g, solution.w).max(initial=0.0))
    return _Attempt(start, solution, time.perf_counter() - begin, violation, solver.name)


def _as_plan(
    ready: _Ready, best: _Attempt, attempts: Sequence[_Attempt], method: _Method, build_time: float
) -> Plan:
    problem, nlp, solution = ready.problem, ready.transcribed.nlp, best.solution
    statistics = Statistics(
        transcription=method.transcription,
        solver=best.solver,
        solved=solution.solved,
        status=solution.status,
        iterations=solution.iterations,
        build_time=build_time,
        solve_time=sum(attempt.solve_time for attempt in attempts),
        cost=solution.cost,
        costs=nlp.costs(solution.w),
        variables=nlp.size,
        constraints=nlp.rows,
        violation=best.violation,
        worst=_describe_worst(nlp, problem, solution),
        start=best.start.name,
        starts=tuple(attempt.result() for attempt in attempts),
    )
    return Plan(
        robot=problem.robot,
        scenario=problem.scenario.self_contained(),
        schedule=problem.schedule,
        trajectory=ready.transcribed.decode(solution.w),
        statistics=statistics,
    )


def _failure(iterate: Plan, attempts: int) -> str:
    """Why there is no plan, as far as the solver knows."""
    statistics = iterate.statistics
    text = (
        f"no solution found from {attempts} initial guesses: {statistics.solver} stopped with "
        f"{statistics.status} after {statistics.iterations} iterations"
    )
    return text + (f"; worst: {statistics.worst}" if statistics.worst else "")


def _describe_worst(nlp: Nlp, problem: Problem, solution: Solution) -> str:
    """The most violated constraint in words: what, where, when, by how much; "" if none is violated."""
    violations = nlp.violations(solution.g, solution.w)[: nlp.rows]
    if violations.max(initial=0.0) <= VIOLATION_TOLERANCE:
        return ""
    number = int(np.argmax(violations))
    origin = nlp.origins[number]
    label = origin.label
    at = origin.interval * problem.schedule.interval
    amount = f"{violations[number] * label.scale:.3g} {label.unit}".rstrip()
    return f"{label.describe()} at t = {at:.2f} s by {amount}"


def _refuse_contradictions(nlp: Nlp, problem: Problem) -> None:
    if not nlp.contradictions:
        return
    # what contradicts the dynamics mostly follows from what contradicts itself
    origin, excess = max(nlp.contradictions, key=lambda item: (item[0].label.term != "dynamics", item[1]))
    at = origin.interval * problem.schedule.interval
    amount = f"{excess * origin.label.scale:.3g} {origin.label.unit}".rstrip()
    raise NotSolvedError(
        f"no solution exists: {origin.label.describe()} contradicts the fixed values "
        f"at t = {at:.2f} s by {amount}"
    )
