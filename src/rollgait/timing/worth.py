"""What a tenth of a second is worth: dJ/dT of each phase, by the multipliers of a solution.

By the envelope theorem the optimal cost changes as the Lagrangian does at the solution itself, where only
numbers change that depend on lengths of intervals. So nothing is solved but the plan's own problem, once,
from it. (Where two limits meet in one point, the cost has a kink and multipliers say one of its slopes.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.attempts import Method, Ready
from rollgait.errors import NotSolvedError
from rollgait.ocp.costs import ForceChange
from rollgait.ocp.problem import Problem, make_problem
from rollgait.ocp.term import Term
from rollgait.plan.phase_worth import PhaseWorth
from rollgait.plan.plan import Plan
from rollgait.scenario.mesh import Mesh
from rollgait.scenario.schedule import ContactSchedule
from rollgait.solvers import Solution
from rollgait.starts import from_plan
from rollgait.timing.phases import Phases

Array = NDArray[np.float64]

STEP: Final = 1e-6
"""s, by which phases are stretched to see how numbers change with them."""


def timing_gradient(plan: Plan, terms: Sequence[Term] = ()) -> tuple[PhaseWorth, ...]:
    """dJ/dT of each phase of a plan.

    At the same horizon, time that goes from one phase to another is worth the difference. The jumps of forces
    where contacts change cost the same however long the intervals beside them: that is no matter of time.

    Args:
        plan: what was solved.
        terms: those of your own with which it was planned.

    Raises:
        NotSolvedError: its problem cannot be solved from it.
    """
    kept = make_problem(plan.scenario, terms, plan.schedule)
    problem = replace(kept, terms=tuple(_with_jumps(term, plan.schedule.mesh) for term in kept.terms))
    method = Method.of(None, None, kernels=True)
    ready = Ready(method, problem)
    solution = ready.solver.solve(ready.transcribed.encode(from_plan(problem, plan)), None, warm=True)
    if not solution.solved or solution.multipliers is None:
        raise NotSolvedError(
            f"the plan is no start of its own problem: {ready.solver.name}: {solution.status}"
        )
    phases = Phases.of(plan.scenario, plan.schedule)
    number = np.searchsorted(phases.borders, plan.schedule.mesh.middles) - 1
    result = []
    for phase in range(phases.count):
        ends = []
        for step in (STEP, -STEP):  # margins go by the longer of two intervals: there is a kink
            stretch = np.where(number == phase, 1.0 + step / phases.lengths[phase], 1.0)
            ends.append(_lagrangian(method, problem, plan.schedule.lengths * stretch, solution))
        slope = (ends[0] - ends[1]) / (2.0 * STEP)
        begin, end = phases.borders[phase : phase + 2]
        swings = tuple(int(leg) for leg in np.flatnonzero(~phases.contact[:, phase]))
        result.append(PhaseWorth(float(begin), float(end), swings, float(slope)))
    return tuple(result)


def _with_jumps(term: Term, mesh: Mesh) -> Term:
    return ForceChange(term.weight, mesh) if type(term) is ForceChange else term


def _lagrangian(method: Method, problem: Problem, lengths: Array, solution: Solution) -> float:
    """Of the same problem with intervals of other lengths, at the variables and multipliers of a solution."""
    schedule = ContactSchedule(problem.schedule.contact, Mesh(lengths), problem.schedule.begun)
    nlp = Ready(method, replace(problem, schedule=schedule)).transcribed.nlp
    assert solution.multipliers is not None
    rows, bounds = solution.multipliers
    f, g = nlp.values(solution.w)
    return f + _beyond(g, nlp.g_lower, nlp.g_upper, rows) + _beyond(solution.w, nlp.lower, nlp.upper, bounds)


def _beyond(values: Array, lower: Array, upper: Array, multipliers: Array) -> float:
    """Multipliers times by how much limits are passed: of the upper ones where they are positive."""
    limit = np.where(multipliers > 0.0, upper, lower)
    counts = np.isfinite(limit)
    return float(multipliers[counts] @ (values - limit)[counts])
