"""The costs. Paper: the first six; the others belong to the profile `executable`."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from rollgait.dynamics.step import POINTS
from rollgait.ocp.context import PlanContext
from rollgait.ocp.instant import Instant
from rollgait.ocp.term import Cost, Data
from rollgait.scenario.mesh import Mesh

FORCE_INTERVAL_REF = 0.1
"""h_ref, s: the interval at which the force cost is the paper's Σ‖f_k − f_{k−1}‖² (formulation, Cost)."""

EFFORT_ACCELERATION = 3.0
"""m/s²: about the largest vertical acceleration of CENTAURO's foot in a swing of 0.8 s."""


class Acceleration(Cost):
    """L_acc = ‖r̈‖²."""

    name = "acc"

    def residual(self, x: Instant, d: Data) -> ca.SX:
        return x.ddr


class Goal(Cost):
    """L_goal = ‖r − r_goal‖² + ‖θ − θ_goal‖²; the goal may change over time."""

    name = "goal"

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        return {"pose": problem.goals}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        error: ca.SX = ca.vertcat(x.r, x.theta) - d.pose
        return error


class ForceChange(Cost):
    """L_force = h_ref² Σ‖(f_k − f_{k−1}) / h‖², forces in N, swing force counted as zero; at k = 0
    none, but where the robot is in motion at the start and its forces are known.

    A force is constant in an interval, its value at the middle: it changes within the time h between the
    middles of both, over which the square counts. (Where a contact changes it jumps, on any mesh: the shorter
    the intervals there, the more that costs, though it can hardly be avoided.)
    """

    name = "force"

    def __init__(self, weight: float = 1.0, jumps_as_on: Mesh | None = None) -> None:
        """With `jumps_as_on`, jumps where a contact changes cost what they do on that mesh, as finely cut."""
        super().__init__(weight)
        self.jumps_as_on = jumps_as_on

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        mesh = problem.schedule.mesh
        between = mesh.between_middles
        if self.jumps_as_on is not None:
            jumps = problem.schedule.changes
            between = np.where(jumps, self.jumps_as_on.between_middles, between)
        # the square is taken over the time between the middles, the integral over the interval alone
        factor = FORCE_INTERVAL_REF / between * np.sqrt(between / mesh.lengths)
        motion = problem.scenario.start.motion
        if motion is None or motion.force is None:
            factor[0] = 0.0  # nothing is known of a force before
        return {"factor": factor[None, :]}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        change = ca.vertcat(*(foot.force - foot.previous_force for foot in x.feet))
        rate: ca.SX = d.factor * change
        return rate


class Feet(Cost):
    """L_feet = Σ‖Rzᵀ (p_i − r) − p̄_i‖², in a tilted frame where the ground is not flat."""

    name = "feet"

    def residual(self, x: Instant, d: Data) -> ca.SX:
        return ca.SX(ca.vertcat(*(foot.p_body - x.body.stance[:, foot.index] for foot in x.feet)))


class Speed(Cost):
    """L_speed = Σ v_i² of the wheels; in contact only, if the scenario asks for that."""

    name = "speed"

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        contact_only = problem.scenario.weights.speed_in_contact_only
        return {"counts": (problem.schedule.contact | (not contact_only)).astype(float)}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        return ca.SX(ca.vertcat(*(d.counts[foot.index] * foot.speed for foot in x.feet)))


class HeadingRate(Cost):
    """L_yaw = Σ σ̇_i² of the steerable wheels."""

    name = "yaw"

    def residual(self, x: Instant, d: Data) -> ca.SX:
        return ca.SX(ca.vertcat(*(foot.heading_rate for foot in x.feet if foot.kind == "steerable")))


class Tilt(Cost):
    """pitch² + roll², from what the ground asks for. Without it the base drifts by 6 to 10 degrees."""

    name = "tilt"

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        return {"reference": problem.goals[4:]}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        return ca.SX(x.theta[1:] - d.reference)


class TerminalGoal(Cost):
    """‖(x, y, yaw) − goal‖² at the end. The running cost alone misses the goal by up to 11 cm."""

    name = "terminal_goal"
    terminal = True

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        return {"pose": problem.goals}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        return ca.SX(ca.vertcat(x.r[:2] - d.pose[:2], x.theta[0] - d.pose[3]))


class Lift(Cost):
    """Σ (ṗz − ṗz_ref)² of the feet in swing, against a smooth lift (`lift.py`).

    ṗz is linear in an interval, so its two height points say it all. The paper leaves it without a cost,
    and its feet spike in the middle of the swing.
    """

    name = "lift"

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        rate, swing = problem.lift_rate, ~problem.schedule.contact
        return {"rate": rate.reshape(-1, rate.shape[-1]), "counts": swing.astype(float)}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        parts = []
        for foot in x.feet:
            reference = d.rate[foot.index :: len(x.feet)]
            mean = np.sqrt(1.0 / reference.numel())
            parts.append(mean * d.counts[foot.index] * (foot.lift_rate - reference))
        return ca.SX(ca.vertcat(*parts))


class SwingMotion(Cost):
    """Σ‖ṗ_xy‖² of the feet in swing that no other cost touches: point feet, and fixed wheels sideways."""

    name = "swing"

    def residual(self, x: Instant, d: Data) -> ca.SX:
        free = [foot.motion for foot in x.feet if foot.kind == "point"]
        free += [foot.motion[1] for foot in x.feet if foot.kind == "fixed"]
        return ca.SX(ca.vertcat(*free))


class Effort(Cost):
    """Σ (p̈_z / 3 m/s²)² of the feet in swing: the shorter a swing, the more, with the third power.

    Nothing else resists short swings, where timing is free.
    """

    name = "effort"

    def data(self, problem: PlanContext) -> Mapping[str, ArrayLike]:
        return {"counts": (~problem.schedule.contact).astype(float)}

    def residual(self, x: Instant, d: Data) -> ca.SX:
        over = (POINTS[1] - POINTS[0]) * x.body.interval * EFFORT_ACCELERATION
        return ca.SX(
            ca.vertcat(
                *(d.counts[foot.index] * (foot.lift_rate[1] - foot.lift_rate[0]) / over for foot in x.feet)
            )
        )
