"""Initial guesses: the kinematic one, its variants, an easier problem's solution, an earlier plan."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import InputError
from rollgait.ocp.lift import minimum_jerk
from rollgait.ocp.problem import Problem
from rollgait.plan.plan import Plan
from rollgait.plan.rest import Rest
from rollgait.plan.samples import Samples
from rollgait.transcription.guess import MotionGuess, kinematic_guess

Array = NDArray[np.float64]

SWAY = 0.05
"""m, standard deviation of the detour that a random start makes in x and y."""
SWAY_YAW = 0.1
"""rad, standard deviation of its detour in yaw."""
BACK = 0.5
"""s, within which a motion is drawn back from a start in motion to its own way."""

Solve = Callable[[Problem, MotionGuess], MotionGuess | None]
"""Solves a problem from a motion; the solution, or None."""


@dataclass(frozen=True)
class InitialGuess:
    """An initial guess: its name, whether it is near a solution, and how it is made."""

    name: str
    motion: Callable[[], MotionGuess | None]
    warm: bool = False


def starts(
    problem: Problem, solve: Solve, warm_start: Plan | Rest | None, seed: int
) -> Iterator[InitialGuess]:
    """Guesses in the order in which they are worth trying, without end; the same ones for the same seed.

    Args:
        problem: what is to be solved.
        solve: solves an easier problem for the homotopy.
        warm_start: a plan to start from, or what is left of one.
        seed: of the random variants.
    """
    if warm_start is not None:
        motion = partial(_warm, problem, warm_start)
        yield InitialGuess("warm start", motion, warm=True)
        if isinstance(warm_start, Rest):  # a start far from the plan's own motion is no warm one
            yield InitialGuess("rest of the plan", motion)
    yield InitialGuess("kinematic", lambda: _kinematic(problem))
    yield InitialGuess("homotopy", lambda: _homotopy(problem, solve))
    yield InitialGuess("kinematic, wheels reversed", lambda: _kinematic(problem, reverse=True))
    number = 0
    while True:
        number += 1
        generator = np.random.default_rng([seed, number])
        detour = np.concatenate([generator.normal(0.0, SWAY, 2), generator.normal(0.0, SWAY_YAW, 1)])
        yield InitialGuess(f"detour {number}", partial(_kinematic, problem, detour=detour))


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
    return solve(simple, _kinematic(simple))


def _kinematic(problem: Problem, reverse: bool = False, detour: Array | None = None) -> MotionGuess:
    return from_start(problem, kinematic_guess(problem, reverse, detour))


def _warm(problem: Problem, earlier: Plan | Rest) -> MotionGuess:
    return from_start(problem, earlier.motion if isinstance(earlier, Rest) else from_plan(problem, earlier))


def from_start(problem: Problem, motion: MotionGuess) -> MotionGuess:
    """A motion drawn to the start of a problem that begins in motion; it is on its own way `BACK` later.

    A foot that stands and cannot roll is so at the end of its next swing.
    """
    if problem.scenario.start.motion is None:
        return motion
    start, at = problem.start, motion(np.zeros(1)).at(0)
    base, turned = start.base[:3] - at.com_position, start.base[3:] - at.euler
    feet, heading = start.p_foot - at.foot_position, start.heading - at.heading
    begin, end = np.array([_back_at(problem, leg) for leg in range(len(feet))]).T

    def drawn(times: Array) -> Samples:
        s = motion(times)
        share = 1.0 - minimum_jerk(times / BACK)[0]
        of_feet = 1.0 - minimum_jerk((times[:, None] - begin) / (end - begin))[0]
        return replace(
            s,
            com_position=s.com_position + share[:, None] * base,
            euler=s.euler + share[:, None] * turned,
            foot_position=s.foot_position + of_feet[..., None] * feet,
            heading=s.heading + share[:, None] * heading,
        )

    return drawn


def _back_at(problem: Problem, leg: int) -> tuple[float, float]:
    """From when to when a foot is drawn back to its own way, s."""
    schedule = problem.schedule
    own = [swing for swing in schedule.swings() if swing.leg == leg]
    if not own or (problem.robot.leg_list[leg].foot == "steerable" and own[0].lift_off > 0):
        return 0.0, BACK
    begin, end = schedule.node_times[[own[0].lift_off, own[0].touch_down]]
    return float(begin), float(end)
