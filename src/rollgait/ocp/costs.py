"""The costs. Paper: the first six; the others belong to the profile `executable`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from rollgait.ocp.instant import Instant
from rollgait.ocp.term import Cost, Data

if TYPE_CHECKING:
    from rollgait.ocp.problem import Problem

FORCE_INTERVAL_REF = 0.1
"""h_ref, s: the interval at which the force cost is the paper's Σ‖f_k − f_{k−1}‖² (formulation, Cost)."""


class Acceleration(Cost):
    """L_acc = ‖r̈‖²."""

    name = "acc"

    def expression(self, x: Instant, d: Data) -> ca.SX:
        return ca.sumsqr(x.ddr)


class Goal(Cost):
    """L_goal = ‖r − r_goal‖² + ‖θ − θ_goal‖²; the goal may change over time."""

    name = "goal"

    def data(self, problem: Problem) -> Mapping[str, ArrayLike]:
        return {"pose": problem.goals}

    def expression(self, x: Instant, d: Data) -> ca.SX:
        square: ca.SX = ca.sumsqr(ca.vertcat(x.r, x.theta) - d.pose)
        return square


class ForceChange(Cost):
    """L_force = h_ref² Σ‖(f_k − f_{k−1}) / h‖², forces in N, swing force counted as zero, none at k = 0."""

    name = "force"

    def data(self, problem: Problem) -> Mapping[str, ArrayLike]:
        has_previous = np.arange(problem.schedule.intervals)[None, :] > 0
        return {"has_previous": has_previous.astype(float)}

    def expression(self, x: Instant, d: Data) -> ca.SX:
        change = ca.vertcat(*(foot.force - foot.previous_force for foot in x.feet))
        square: ca.SX = d.has_previous * FORCE_INTERVAL_REF**2 * ca.sumsqr(change / x.body.interval)
        return square


class Feet(Cost):
    """L_feet = Σ‖Rzᵀ (p_i − r) − p̄_i‖²."""

    name = "feet"

    def expression(self, x: Instant, d: Data) -> ca.SX:
        return sum((ca.sumsqr(foot.p_body - x.body.stance[:, foot.index]) for foot in x.feet), start=ca.SX(0))


class Speed(Cost):
    """L_speed = Σ v_i² of the wheels; in contact only, if the scenario asks for that."""

    name = "speed"

    def data(self, problem: Problem) -> Mapping[str, ArrayLike]:
        contact_only = problem.scenario.weights.speed_in_contact_only
        return {"counts": (problem.schedule.contact | (not contact_only)).astype(float)}

    def expression(self, x: Instant, d: Data) -> ca.SX:
        return sum((d.counts[foot.index] * foot.speed**2 for foot in x.feet), start=ca.SX(0))


class HeadingRate(Cost):
    """L_yaw = Σ σ̇_i² of the steerable wheels."""

    name = "yaw"

    def expression(self, x: Instant, d: Data) -> ca.SX:
        return sum((foot.heading_rate**2 for foot in x.feet if foot.kind == "steerable"), start=ca.SX(0))


class Tilt(Cost):
    """pitch² + roll². Without it the base drifts by 6 to 10 degrees."""

    name = "tilt"

    def expression(self, x: Instant, d: Data) -> ca.SX:
        return ca.sumsqr(x.theta[1:])


class TerminalGoal(Cost):
    """‖(x, y, yaw) − goal‖² at the end. The running cost alone misses the goal by up to 11 cm."""

    name = "terminal_goal"
    terminal = True

    def data(self, problem: Problem) -> Mapping[str, ArrayLike]:
        return {"pose": problem.goals}

    def expression(self, x: Instant, d: Data) -> ca.SX:
        square: ca.SX = ca.sumsqr(x.r[:2] - d.pose[:2]) + (x.theta[0] - d.pose[3]) ** 2
        return square


class Lift(Cost):
    """Σ (ṗz − ṗz_ref)² of the feet in swing, against a smooth lift (`lift.py`).

    ṗz is linear in an interval, so its two height points say it all. The paper leaves it without a cost,
    and its feet spike in the middle of the swing.
    """

    name = "lift"

    def data(self, problem: Problem) -> Mapping[str, ArrayLike]:
        rate, swing = problem.lift_rate, ~problem.schedule.contact
        return {"rate": rate.reshape(-1, rate.shape[-1]), "counts": swing.astype(float)}

    def expression(self, x: Instant, d: Data) -> ca.SX:
        total = ca.SX(0)
        for foot in x.feet:
            reference = d.rate[foot.index :: len(x.feet)]
            total += d.counts[foot.index] * ca.sumsqr(foot.lift_rate - reference) / reference.numel()
        return total


class SwingMotion(Cost):
    """Σ‖ṗ_xy‖² of the feet in swing that no other cost touches: point feet, and fixed wheels sideways."""

    name = "swing"

    def expression(self, x: Instant, d: Data) -> ca.SX:
        free = [foot.motion for foot in x.feet if foot.kind == "point"]
        free += [foot.motion[1] for foot in x.feet if foot.kind == "fixed"]
        return ca.sumsqr(ca.vertcat(*free)) if free else ca.SX(0)
