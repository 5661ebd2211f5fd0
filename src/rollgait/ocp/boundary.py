"""Constraints at the end. (x(0) = x0 is kept by the transcription: it makes the first state a constant.)"""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from rollgait.ocp.instant import Foot, Instant
from rollgait.ocp.term import END, INPUT, Constraint, Data, FootConstraint, Mask, Place

if TYPE_CHECKING:
    from rollgait.ocp.problem import Problem


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
        return np.asarray(np.arange(count) == count - 1)

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
