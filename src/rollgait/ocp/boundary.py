"""Constraints at the end. (x(0) = x0 is kept by the transcription: it makes the first state a constant.)"""

from __future__ import annotations

import casadi as ca
import numpy as np

from rollgait.ocp.context import PlanContext
from rollgait.ocp.instant import Foot, Instant
from rollgait.ocp.term import END, INPUT, Constraint, Data, FootConstraint, Limits, Mask, Place, Role


class RestAtEnd(Constraint):
    """ṙ(T) = 0."""

    name = "rest_at_end"
    role = Role.END
    sentence = "the body would not end at rest"
    keeps = True
    places = END
    lower = upper = 0.0
    unit = "m/s"

    def expression(self, x: Instant, d: Data) -> ca.SX:
        return x.dr


class WheelsRestAtEnd(FootConstraint):
    """v_i(T) = 0: v is constant in an interval, so the last one rolls at zero."""

    name = "wheels_rest_at_end"
    role = Role.END
    sentence = "the wheel would not end at rest"
    places = INPUT
    lower = upper = 0.0
    unit = "m/s"

    def applies(self, problem: PlanContext, leg: int) -> bool:
        return problem.robot.leg_list[leg].foot != "point"

    def holds(self, problem: PlanContext, place: Place, leg: int) -> Mask:
        count = problem.schedule.intervals
        return np.asarray(np.arange(count) == count - 1)

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.speed


class LevelAtEnd(Constraint):
    """θ̇(T) = 0 and pitch and roll as the ground asks for, 0 on flat ground (executable).

    The paper's plans end tumbling.
    """

    name = "level_at_end"
    keys = ("level_at_end",)
    role = Role.END
    sentence = "the base would not end level and at rest"
    places = END
    unit = "rad, rad/s"

    def limits(self, problem: PlanContext) -> Limits:
        end = problem.footing.end
        wanted = np.array([[end.pitch], [end.roll], [0.0], [0.0], [0.0]])
        return wanted, wanted

    def expression(self, x: Instant, d: Data) -> ca.SX:
        return ca.vertcat(x.theta[1:], x.dtheta)


class StanceAtEnd(FootConstraint):
    """Rzᵀ (p_i − r)(T) = p̄_i in x and y (in a tilted frame where the ground is not flat), for every foot that
    can get there.

    A foot that never swings cannot choose its place: a point foot stays where it is, a fixed wheel goes only
    along its heading, unless it may slip. Further rows for them would be redundant or contradict the goal.
    """

    name = "stance_at_end"
    role = Role.END
    sentence = "the foot would not end at its nominal place"
    keeps = True
    places = END
    unit = "m"

    def applies(self, problem: PlanContext, leg: int) -> bool:
        return self._swings(problem, leg) or problem.robot.leg_list[leg].foot != "point"

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        steers, slips = problem.robot.leg_list[leg].foot == "steerable", problem.scenario.slip_max(leg) > 0.0
        goes_sideways = self._swings(problem, leg) or steers or slips
        slack = np.array([[0.0], [0.0 if goes_sideways else np.inf]])
        return -slack, slack

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        offset = foot.p_body[:2] - x.body.stance[:2, foot.index]
        if foot.kind != "fixed":
            return offset
        along, across = ca.cos(foot.steering), ca.sin(foot.steering)
        return ca.vertcat(
            along * offset[0] + across * offset[1],
            along * offset[1] - across * offset[0],
        )

    def _swings(self, problem: PlanContext, leg: int) -> bool:
        return not problem.schedule.contact[leg].all()


class HeightAtEnd(Constraint):
    """The nominal height of the CoM above the ground at T, where that is not flat above the mean of the feet.

    The z rows of four feet on the ground are one unknown; it is demanded once.
    """

    name = "height_at_end"
    role = Role.END
    sentence = "the body would not end at its nominal height"
    keeps = True
    places = END
    lower = upper = 0.0
    unit = "m"

    def expression(self, x: Instant, d: Data) -> ca.SX:
        if x.body.terrain is None:
            return x.feet[0].p_body[2] - x.body.stance[2, 0]
        feet = len(x.feet)
        return ca.SX(sum(foot.p[2] - x.body.stance[2, foot.index] for foot in x.feet) / feet - x.r[2])
