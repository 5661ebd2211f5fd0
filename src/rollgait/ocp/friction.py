"""Constraints of the contact forces."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from rollgait.ocp.instant import Foot, Instant
from rollgait.ocp.limits import SteeringRate
from rollgait.ocp.term import INPUT, STATE_AND_INPUT, Data, FootConstraint, Limits, Phase

if TYPE_CHECKING:
    from rollgait.ocp.problem import Problem


class Friction(FootConstraint):
    """|f^x| ≤ μ f^z and |f^y| ≤ μ f^z in the contact frame; μ/√2 for the pyramid inside the cone (inscribed).

    The force is constant in an interval but the contact frame of a steered wheel turns: between two places where this
    holds, an angle δ apart, f^y reaches up to μ f^z / cos(δ/2). So that it holds between them too, μ is taken times
    cos(δ/2) with the largest δ = σ̇_max h: 0.995 at 2 rad/s and 0.1 s.
    """

    name = "friction"
    places = STATE_AND_INPUT
    phase = Phase.STANCE
    lower = 0.0
    unit = "N"

    def data(self, problem: Problem, leg: int) -> Mapping[str, ArrayLike]:
        mu = problem.scenario.ground.friction * np.cos(0.5 * _turn(problem, leg))
        return {"mu": [mu / np.sqrt(2.0) if problem.scenario.bounds.inscribed else mu]}

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        tangential, normal = foot.force_contact[:2], foot.force_contact[2]
        return ca.vertcat(d.mu * normal - tangential, d.mu * normal + tangential)


def _turn(problem: Problem, leg: int) -> float:
    """δ: the largest angle by which a wheel is steered in an interval, at most a right one, rad."""
    if problem.robot.leg_list[leg].foot != "steerable":
        return 0.0
    _, rate_max = SteeringRate().limits(problem, leg)
    return float(min(np.asarray(rate_max) * problem.schedule.interval, 0.5 * np.pi))


class ForceLimits(FootConstraint):
    """force_min ≤ f^z ≤ force_max in stance; force_min is 0 in the paper."""

    name = "force_limits"
    places = INPUT
    phase = Phase.STANCE
    unit = "N"

    def limits(self, problem: Problem, leg: int) -> Limits:
        own = problem.scenario.value_of("bounds", "force_max") or np.inf
        low = problem.scenario.value_of("bounds", "force_min") or 0.0
        return low, min(own, problem.robot.leg_list[leg].force_max)

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.force[2]
