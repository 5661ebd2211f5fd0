"""Initial guesses: the kinematic one, its variants, an easier problem's solution, an earlier plan."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from rollgait.errors import InputError
from rollgait.ocp.problem import Problem
from rollgait.plan.plan import Plan
from rollgait.plan.samples import Samples
from rollgait.transcription.guess import MotionGuess, kinematic_guess

SWAY = 0.05
"""m, standard deviation of the detour that a random start makes in x and y."""
SWAY_YAW = 0.1
"""rad, standard deviation of its detour in yaw."""

Solve = Callable[[Problem, MotionGuess], MotionGuess | None]
"""Solves a problem from a motion; the solution, or None."""


@dataclass(frozen=True)
class InitialGuess:
    """An initial guess: its name, whether it is near a solution, and how it is made."""

    name: str
    motion: Callable[[], MotionGuess | None]
    warm: bool = False


def starts(problem: Problem, solve: Solve, warm_start: Plan | None, seed: int) -> Iterator[InitialGuess]:
    """Guesses in the order in which they are worth trying, without end; the same ones for the same seed.

    Args:
        problem: what is to be solved.
        solve: solves an easier problem for the homotopy.
        warm_start: a plan to start from.
        seed: of the random variants.
    """
    if warm_start is not None:
        yield InitialGuess("warm start", lambda: from_plan(problem, warm_start), warm=True)
    yield InitialGuess("kinematic", lambda: kinematic_guess(problem))
    yield InitialGuess("homotopy", lambda: _homotopy(problem, solve))
    yield InitialGuess("kinematic, wheels reversed", lambda: kinematic_guess(problem, reverse=True))
    number = 0
    while True:
        number += 1
        generator = np.random.default_rng([seed, number])
        detour = np.concatenate([generator.normal(0.0, SWAY, 2), generator.normal(0.0, SWAY_YAW, 1)])
        yield InitialGuess(f"detour {number}", partial(kinematic_guess, problem, detour=detour))


def from_plan(problem: Problem, plan: Plan) -> MotionGuess:
    """The motion of a plan, stretched to the horizon of the problem.

    Raises:
        InputError: the plan is for a robot with other kinds of feet.
    """
    kinds = [leg.foot for leg in problem.robot.leg_list]
    had = [leg.foot for leg in plan.robot.leg_list]
    if kinds != had:
        raise InputError("warm_start", had, f"must be a plan for the same kinds of feet: {kinds}")
    stretch = problem.schedule.horizon / plan.horizon

    def motion(times: np.ndarray) -> Samples:
        s = plan.sample(np.clip(times / stretch, 0.0, plan.horizon))
        return replace(
            s,
            time=times,
            com_velocity=s.com_velocity / stretch,
            euler_rate=s.euler_rate / stretch,
            foot_velocity=s.foot_velocity / stretch,
            heading_rate=s.heading_rate / stretch,
            speed=s.speed / stretch,
        )

    return motion


def _homotopy(problem: Problem, solve: Solve) -> MotionGuess | None:
    """The solution of the problem without its hardest terms; None if there is nothing to leave out."""
    harder = [term for term in problem.constraints if term.left_out_at_first]
    if not harder:
        return None
    simple = replace(problem, terms=tuple(term for term in problem.terms if term not in harder))
    return solve(simple, kinematic_guess(simple))
