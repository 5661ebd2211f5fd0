"""Constraints at the start and at the end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from rollgait.ocp.instant import Foot, Instant
from rollgait.ocp.term import END, INPUT, Constraint, Data, FootConstraint, Limits, Mask, Place

if TYPE_CHECKING:
    from rollgait.ocp.problem import Problem


class _AtStart:
    """Holds at the first node only."""

    def first(self, problem: Problem) -> Mask:
        return np.arange(problem.schedule.intervals) == 0


class Start(Constraint, _AtStart):
    """x(0) = x0, the base: r, θ, ṙ, θ̇."""

    name = "start"
    places = INPUT

    def limits(self, problem: Problem) -> Limits:
        state = np.concatenate([problem.start.base, problem.start.base_rate])[:, None]
        return state, state

    def holds(self, problem: Problem, place: Place) -> Mask:
        return self.first(problem)

    def expression(self, x: Instant, d: Data) -> ca.SX:
        return ca.vertcat(x.r, x.theta, x.dr, x.dtheta)


class FootStart(FootConstraint, _AtStart):
    """x(0) = x0, the feet: p_i and, of a steerable wheel, σ_i."""

    name = "foot_start"
    places = INPUT

    def limits(self, problem: Problem, leg: int) -> Limits:
        state = [*problem.start.p_foot[leg]]
        if problem.robot.leg_list[leg].foot == "steerable":
            state.append(problem.start.heading[leg])
        return np.array(state)[:, None], np.array(state)[:, None]

    def holds(self, problem: Problem, place: Place, leg: int) -> Mask:
        return self.first(problem)

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return ca.vertcat(foot.p, foot.heading) if foot.kind == "steerable" else foot.p


class RestAtEnd(Constraint):
    """ṙ(T) = 0."""

    name = "rest_at_end"
    places = END
    lower = upper = 0.0
    unit = "m/s"

    def expression(self, x: Instant, d: Data) -> ca.SX:
        return x.dr


class WheelsRestAtEnd(FootConstraint):
    """v_i(T) = 0: v is constant in an interval, so the last one rolls at zero."""

    name = "wheels_rest_at_end"
    places = INPUT
    lower = upper = 0.0
    unit = "m/s"

    def applies(self, problem: Problem, leg: int) -> bool:
        return problem.robot.leg_list[leg].foot != "point"

    def holds(self, problem: Problem, place: Place, leg: int) -> Mask:
        count = problem.schedule.intervals
        return np.arange(count) == count - 1

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.speed


class LevelAtEnd(Constraint):
    """θ̇(T) = 0 and pitch(T) = roll(T) = 0 (executable): the paper's plans end tumbling."""

    name = "level_at_end"
    places = END
    lower = upper = 0.0
    unit = "rad, rad/s"

    def expression(self, x: Instant, d: Data) -> ca.SX:
        return ca.vertcat(x.theta[1:], x.dtheta)


class StanceAtEnd(FootConstraint):
    """Rzᵀ (p_i − r)(T) = p̄_i in x and y, for every foot that can get there.

    A point foot that never swings cannot move: a row for it would only be redundant or contradict the goal.
    """

    name = "stance_at_end"
    places = END
    lower = upper = 0.0
    unit = "m"

    def applies(self, problem: Problem, leg: int) -> bool:
        moves = not problem.schedule.contact[leg].all()
        return moves or problem.robot.leg_list[leg].foot != "point"

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.p_body[:2] - x.body.stance[:2, foot.index]


class HeightAtEnd(Constraint):
    """The nominal height of the CoM above the ground at T.

    The z rows of four feet on the ground are one unknown; it is demanded once.
    """

    name = "height_at_end"
    places = END
    lower = upper = 0.0
    unit = "m"

    def expression(self, x: Instant, d: Data) -> ca.SX:
        return x.feet[0].p_body[2] - x.body.stance[2, 0]
