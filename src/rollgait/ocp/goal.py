"""The goal as constraints at the end; the problem has it as a cost, which asks but cannot demand."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from rollgait.ocp.context import PlanContext
from rollgait.ocp.instant import Instant
from rollgait.ocp.term import END, Constraint, Data, Role


class GoalPlace(Constraint):
    """|r_x − goal| and |r_y − goal| ≤ tolerance at T."""

    name = "goal_distance"
    role = Role.GOAL
    sentence = "the goal would not be reached"
    places = END
    unit = "m"

    def __init__(self, tolerance: float) -> None:
        """`tolerance` in m."""
        self.lower, self.upper = -tolerance, tolerance

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        return {"place": problem.scenario.goal_at(np.array([problem.schedule.horizon]))[0, :2]}

    def expression(self, x: Instant, d: Data) -> ca.SX:
        miss: ca.SX = x.r[:2] - d.place
        return miss


class GoalYaw(Constraint):
    """|yaw − goal| ≤ tolerance at T."""

    name = "goal_yaw"
    role = Role.GOAL
    sentence = "the goal would not be reached"
    places = END
    unit = "rad"

    def __init__(self, tolerance: float) -> None:
        """`tolerance` in rad."""
        self.lower, self.upper = -tolerance, tolerance

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        return {"yaw": problem.scenario.goal_at(np.array([problem.schedule.horizon]))[0, 3:4]}

    def expression(self, x: Instant, d: Data) -> ca.SX:
        miss: ca.SX = x.theta[0] - d.yaw
        return miss
