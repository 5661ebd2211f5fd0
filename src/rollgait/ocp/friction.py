"""Constraints of the contact forces."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.ocp.context import PlanContext
from rollgait.ocp.instant import Foot, Instant
from rollgait.ocp.term import ENDS, INPUT, Data, FootConstraint, Limits, Phase

Array = NDArray[np.float64]

LARGEST_TURN = 1.0
"""rad: beyond this turn in one interval the interval is too long to say anything about what lies between."""


def pyramid(problem: PlanContext, leg: int) -> Array:
    """μ of the pyramid in each interval, (N,): along the heading and across it."""
    mu = np.broadcast_to(problem.friction_at(leg), problem.schedule.intervals)
    return np.asarray(mu / np.sqrt(2.0) if problem.bound("inscribed") else mu)


class Friction(FootConstraint):
    """|f^x| ≤ μ f^z and |f^y| ≤ μ f^z in the contact frame; μ/√2 for the pyramid inside the cone (inscribed).

    In an interval the force is constant while the wheel may turn by up to Δσ = σ̇_max h. What holds at both
    ends for μ cos(Δσ / 2) then holds in between for μ: no point inside is needed.
    """

    name = "friction"
    sentence = "the contact force would have to leave the friction cone"
    places = ENDS
    phase = Phase.STANCE
    lower = 0.0
    unit = "N"
    by_weight = True

    def data(self, problem: PlanContext, leg: int) -> Mapping[str, ArrayLike]:
        mu = pyramid(problem, leg)
        turn = np.zeros(problem.schedule.intervals)
        if problem.robot.leg_list[leg].foot != "point":
            turn = problem.steering_rate_max(leg) * self.lengths(problem)
        return {"mu": (mu * np.cos(0.5 * np.minimum(turn, LARGEST_TURN)))[None, :]}

    def lengths(self, problem: PlanContext) -> Array:
        """h of each interval, (N,), s."""
        return problem.schedule.lengths

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        tangential, normal = foot.force_contact[:2], foot.force_contact[2]
        room: ca.SX = ca.vertcat(d.mu * normal - tangential, d.mu * normal + tangential)
        return room


class ForceLimits(FootConstraint):
    """force_min ≤ n · f ≤ force_max in stance, n the normal of the ground; force_min is 0 in the paper."""

    name = "force_limits"
    sentence = "the normal force would have to leave its limits"
    places = INPUT
    phase = Phase.STANCE
    unit = "N"
    by_weight = True

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        own = problem.bound("force_max") or np.inf
        low = problem.bound("force_min") or 0.0
        return low, min(own, problem.robot.leg_list[leg].force_max)

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.force_contact[2]
