"""Whether a changed scenario can be solved: by solving it, with bounded effort."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from rollgait.diagnosis.budget import Budget
from rollgait.diagnosis.elastic import is_goal_promised
from rollgait.errors import RollgaitError
from rollgait.ocp.problem import Problem, make_problem
from rollgait.ocp.term import Term
from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.samples import Samples
from rollgait.plan.trajectory import Trajectory
from rollgait.scenario.scenario import Scenario
from rollgait.solvers import Iteration, Progress, make_solver
from rollgait.solvers.code_store import store_for
from rollgait.transcription import transcribe
from rollgait.transcription.base import Transcribed
from rollgait.transcription.guess import MotionGuess, kinematic_guess

MAX_ITERATIONS = 80
"""Of one attempt: what is solvable is solved in some dozen."""
SMALL_VIOLATION = 1e-4
"""Scaled violation below which it is the cost that takes time."""
PATIENCE = 25
"""Iterations without a tenth less violation after which an attempt is given up."""


class _GaveUpError(Exception):
    """An attempt took too many iterations."""


def is_solvable(
    scenario: Scenario,
    terms: Sequence[Term],
    kernels: bool,
    progress: Progress,
    budget: Budget,
    near: Trajectory | MotionGuess | None = None,
    to_goal: bool = False,
) -> bool:
    """Whether the scenario is solved within the budget, and reaches its goal if it promises that.

    Args:
        scenario: what is asked.
        terms: further terms of the problem.
        kernels: whether to use compiled stage functions.
        progress: is called after each iteration.
        budget: what may be spent.
        near: a motion to start from, e.g. one that nearly keeps the constraints; the kinematic guess if not
            given.
        to_goal: whether it must reach its goal even if it does not promise that.
    """
    try:
        problem = make_problem(scenario, terms)
    except RollgaitError:
        return False
    transcribed = transcribe("condensed", problem, store_for(kernels))
    if transcribed.nlp.contradictions:
        return False
    solver = make_solver("fatrop", transcribed, kernels)

    least, least_at = np.inf, 0

    def report(iteration: Iteration) -> None:
        nonlocal least, least_at
        if iteration.violation < 0.9 * least:
            least, least_at = iteration.violation, iteration.number
        stagnates = least > SMALL_VIOLATION and iteration.number > least_at + PATIENCE
        if stagnates or iteration.number > MAX_ITERATIONS:
            raise _GaveUpError
        progress(iteration)

    start: MotionGuess = kinematic_guess(problem)
    if near is not None:
        start = partial(_sampled, near, problem) if isinstance(near, Trajectory) else near
    try:
        solution = solver.solve(transcribed.encode(start), report, **budget.limits)
    except _GaveUpError:
        return False
    if not solution.solved:
        return False
    return not (to_goal or is_goal_promised(scenario)) or _reaches_goal(transcribed, solution.w)


def _sampled(motion: Trajectory, problem: Problem, times: np.ndarray) -> Samples:
    return motion.sample(times, problem.robot)


def _reaches_goal(transcribed: Transcribed, w: np.ndarray) -> bool:
    """Whether the end is as near the goal as a certificate wants it."""
    problem = transcribed.problem
    times = np.array([problem.schedule.horizon])
    end = transcribed.decode(w).sample(times, problem.robot)
    goal = problem.scenario.goal_at(times)[0]
    legged = any(leg.foot == "point" for leg in problem.robot.leg_list)
    near = float(np.linalg.norm(end.com_position[0, :2] - goal[:2]))
    turned = float(np.degrees(abs(end.euler[0, 0] - goal[3])))
    return turned <= tol.GOAL_YAW and near <= (tol.GOAL_DISTANCE_LEGGED if legged else tol.GOAL_DISTANCE)
