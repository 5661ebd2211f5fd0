"""From a scenario to a plan."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from rollgait.errors import InputError, NotSolvedError, UnknownNameError
from rollgait.ocp.problem import Problem, make_problem
from rollgait.ocp.term import Term
from rollgait.plan.plan import Plan, StartResult, Statistics
from rollgait.scenario.library import find_scenario
from rollgait.scenario.scenario import Scenario
from rollgait.solvers import SOLVER_NAMES, Progress, Solution, Solver, make_solver
from rollgait.solvers.kernels import compiled
from rollgait.starts import Start, starts
from rollgait.transcription import TRANSCRIPTION_NAMES, transcribe
from rollgait.transcription.base import Transcribed
from rollgait.transcription.guess import Motion
from rollgait.transcription.nlp import Nlp

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
        progress: is called after each iteration of the solver.

    Returns:
        The plan. The solver converged, but whether the plan is good its `certificate()` says.

    Raises:
        InputError: something in the input is wrong.
        NotSolvedError: no start converged; the last iterate is the error's `plan`, marked as not solved.
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
    ready = _Ready(method, problem)
    build_time = time.perf_counter() - begin
    guesses = starts(problem, method.solve, earlier, seed)
    attempts = list(_attempts(ready, guesses, multistart, progress))
    solved = [attempt for attempt in attempts if attempt.solution.solved]
    best = min(solved, key=lambda a: a.solution.cost) if solved else min(attempts, key=lambda a: a.violation)
    result = _as_plan(ready, best, attempts, method, build_time)
    if not solved:
        raise NotSolvedError(_failure(result, len(attempts)), result)
    return result


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
        self.solver: Solver = make_solver(method.solver, self.transcribed, method.kernels)


@dataclass(frozen=True)
class _Attempt:
    """What came of a start."""

    start: Start
    solution: Solution
    solve_time: float
    violation: float

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
    """Solves from start after start: `multistart` of them, or until one is solved, FALLBACKS at the most."""
    solved = 0
    for number, start in enumerate(islice(guesses, max(multistart, FALLBACKS))):
        if number >= multistart and solved:
            return
        motion = start.motion()
        if motion is None:
            continue
        begin = time.perf_counter()
        solution = ready.solver.solve(ready.transcribed.encode(motion), progress, start.warm)
        violation = float(ready.transcribed.nlp.violations(solution.g, solution.w).max(initial=0.0))
        solved += solution.solved
        yield _Attempt(start, solution, time.perf_counter() - begin, violation)


def _as_plan(
    ready: _Ready, best: _Attempt, attempts: Sequence[_Attempt], method: _Method, build_time: float
) -> Plan:
    problem, nlp, solution = ready.problem, ready.transcribed.nlp, best.solution
    statistics = Statistics(
        transcription=method.transcription,
        solver=method.solver,
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
    origin, excess = max(nlp.contradictions, key=lambda item: item[1])
    at = origin.interval * problem.schedule.interval
    amount = f"{excess * origin.label.scale:.3g} {origin.label.unit}".rstrip()
    raise NotSolvedError(
        f"no solution exists: {origin.label.describe()} contradicts the fixed values "
        f"at t = {at:.2f} s by {amount}"
    )
