"""From a scenario to a plan."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rollgait.errors import NotSolvedError, UnknownNameError
from rollgait.ocp.problem import Problem, make_problem
from rollgait.ocp.term import Term
from rollgait.plan.plan import Plan, Statistics
from rollgait.scenario.library import find_scenario
from rollgait.scenario.scenario import Scenario
from rollgait.solvers import SOLVER_NAMES, Progress, Solution
from rollgait.transcription import TRANSCRIPTION_NAMES
from rollgait.transcription.collocation import Collocation, transcribe
from rollgait.transcription.guess import kinematic_guess
from rollgait.transcription.nlp import Nlp

VIOLATION_TOLERANCE = 1e-6
"""Scaled violation of a constraint above which it is named in the statistics."""


def plan(
    scenario: str | Path | Scenario,
    *,
    profile: str | None = None,
    transcription: str = "collocation",
    solver: str = "ipopt",
    terms: Sequence[Term] = (),
    progress: Progress | None = None,
) -> Plan:
    """Plans a motion.

    Args:
        scenario: a scenario, the name of one in the library, or the path of a YAML file.
        profile: `paper` or `executable`, in place of the scenario's own.
        transcription: how the problem becomes a nonlinear program: one of `TRANSCRIPTION_NAMES`.
        solver: what solves that: one of `SOLVER_NAMES`.
        terms: further costs and constraints of your own.
        progress: is called after each iteration of the solver.

    Returns:
        The plan. The solver converged, but whether the plan is good its `certificate()` says.

    Raises:
        InputError: something in the input is wrong.
        NotSolvedError: the solver did not converge; its last iterate is the error's `plan`, marked as not solved.
    """
    begin = time.perf_counter()
    if transcription not in TRANSCRIPTION_NAMES:
        raise UnknownNameError("transcription", transcription, TRANSCRIPTION_NAMES)
    if solver not in SOLVER_NAMES:
        raise UnknownNameError("solver", solver, SOLVER_NAMES)
    asked = scenario if isinstance(scenario, Scenario) else find_scenario(str(scenario))
    if profile is not None:
        asked = asked.with_values({"profile": profile})
    problem = make_problem(asked, terms)
    transcribed = transcribe(problem)
    _refuse_contradictions(transcribed.nlp, problem)
    from rollgait.solvers.ipopt import Ipopt

    ready = Ipopt(transcribed.nlp)
    guess = transcribed.encode(kinematic_guess(problem))
    built = time.perf_counter()
    solution = ready.solve(guess, progress)
    solved = time.perf_counter()
    result = _as_plan(problem, transcribed, solver, solution, built - begin, solved - built)
    if not solution.solved:
        worst = result.statistics.worst
        raise NotSolvedError(
            f"no solution found: {solver} stopped with {solution.status} after {solution.iterations} iterations"
            + (f"; worst: {worst}" if worst else ""),
            result,
        )
    return result


def _as_plan(
    problem: Problem,
    transcribed: Collocation,
    solver: str,
    solution: Solution,
    build_time: float,
    solve_time: float,
) -> Plan:
    nlp = transcribed.nlp
    violations = nlp.violations(solution.g, solution.w)
    worst = int(np.argmax(violations)) if violations.size else 0
    statistics = Statistics(
        transcription=transcribed.name,
        solver=solver,
        solved=solution.solved,
        status=solution.status,
        iterations=solution.iterations,
        build_time=build_time,
        solve_time=solve_time,
        cost=solution.cost,
        costs=nlp.costs(solution.w),
        variables=nlp.size,
        constraints=nlp.rows,
        violation=float(violations.max(initial=0.0)),
        worst=_describe_row(nlp, problem, worst, float(violations[worst])),
    )
    return Plan(
        robot=problem.robot,
        scenario=problem.scenario.self_contained(),
        schedule=problem.schedule,
        trajectory=transcribed.decode(solution.w),
        statistics=statistics,
    )


def _describe_row(nlp: Nlp, problem: Problem, number: int, violation: float) -> str:
    """A violated constraint in words: what, where, when, by how much; "" if it is not violated."""
    if violation <= VIOLATION_TOLERANCE or number >= nlp.rows:
        return ""
    origin = nlp.origins[number]
    label = origin.label
    at = origin.interval * problem.schedule.interval
    return f"{label.describe()} at t = {at:.2f} s by {violation * label.scale:.3g} {label.unit}".rstrip()


def _refuse_contradictions(nlp: Nlp, problem: Problem) -> None:
    if not nlp.contradictions:
        return
    origin, excess = max(nlp.contradictions, key=lambda item: item[1])
    at = origin.interval * problem.schedule.interval
    amount = f"{excess * origin.label.scale:.3g} {origin.label.unit}".rstrip()
    raise NotSolvedError(
        f"no solution exists: {origin.label.describe()} contradicts the fixed values at t = {at:.2f} s by {amount}"
    )
