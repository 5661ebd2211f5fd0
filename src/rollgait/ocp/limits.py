"""Limits of the feet's places, headings and speeds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from rollgait.ocp.instant import Foot, Instant
from rollgait.ocp.term import INPUT, Data, FootConstraint, Limits, Mask, Phase, Place

if TYPE_CHECKING:
    from rollgait.ocp.problem import Problem


class Box(FootConstraint):
    """|Rzᵀ (p_i − r) − p̄_i| ≤ b, componentwise; `full_rotation` uses R(θ) in place of Rz."""

    name = "box"
    unit = "m"
    curvature = 1.5  # beyond the tolerance of 1 mm: a wheel at full speed that steers while the base brakes

    def __init__(self, full_rotation: bool = False) -> None:
        self.full_rotation = full_rotation

    def limits(self, problem: Problem, leg: int) -> Limits:
        b = np.array(problem.scenario.bounds.box or problem.robot.box)[:, None]
        return -b, b

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        p_body = x.R_world_base.T @ (foot.p - x.r) if self.full_rotation else foot.p_body
        return p_body - x.body.stance[:, foot.index]


class Steering(FootConstraint):
    """σ_min ≤ σ_i − θz ≤ σ_max; headings are never reduced mod 2π."""

    name = "steering"
    unit = "rad"

    def applies(self, problem: Problem, leg: int) -> bool:
        return problem.robot.leg_list[leg].foot == "steerable"

    def limits(self, problem: Problem, leg: int) -> Limits:
        return problem.scenario.steering_range(leg)

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.steering


class SteeringRate(FootConstraint):
    """|σ̇_i| ≤ σ̇_max, in stance and in swing."""

    name = "steering_rate"
    places = INPUT
    unit = "rad/s"

    def applies(self, problem: Problem, leg: int) -> bool:
        return problem.robot.leg_list[leg].foot == "steerable"

    def limits(self, problem: Problem, leg: int) -> Limits:
        limit = problem.scenario.steering_rate_max(leg)
        return -limit, limit

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.heading_rate


class StanceSpeed(FootConstraint):
    """|v_i| ≤ v_max in stance."""

    name = "stance_speed"
    places = INPUT
    phase = Phase.STANCE
    unit = "m/s"

    def applies(self, problem: Problem, leg: int) -> bool:
        return problem.robot.leg_list[leg].foot != "point"

    def limits(self, problem: Problem, leg: int) -> Limits:
        limit = problem.scenario.speed_max(leg)
        return -limit, limit

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.speed


class SwingSpeed(FootConstraint):
    """|v_i| ≤ swing_speed_max in swing; of both components where the foot moves freely."""

    name = "swing_speed"
    places = INPUT
    phase = Phase.SWING
    unit = "m/s"

    def limits(self, problem: Problem, leg: int) -> Limits:
        limit = problem.scenario.value_of("bounds", "swing_speed_max")
        return -limit, limit

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.speed if foot.kind == "steerable" else foot.motion


class Acceleration(FootConstraint):
    """|v_k − v_{k−1}| ≤ a h (executable): wheel speeds do not jump, not even at t = 0, where v was 0.

    a is `acceleration_max` for a foot that stays on the ground and `swing_acceleration_max` for one that
    swings or has just landed (its wheel is free to spin up in the air). What moves freely in swing has a
    second component there, which stops when the foot lands.
    """

    name = "acceleration"
    places = INPUT
    unit = "m/s"

    def data(self, problem: Problem, leg: int) -> Mapping[str, ArrayLike]:
        return {"in_swing": ~problem.schedule.contact[leg : leg + 1]}

    def limits(self, problem: Problem, leg: int) -> Limits:
        contact = problem.schedule.contact[leg]
        stays = contact & np.concatenate([[True], contact[:-1]])
        value = problem.scenario.value_of
        stance, swing = (
            value("bounds", name) or np.inf for name in ("acceleration_max", "swing_acceleration_max")
        )
        a = np.where(stays, stance, swing)
        limit = a[None, :] * problem.schedule.interval
        return -limit, limit

    def holds(self, problem: Problem, place: Place, leg: int) -> Mask:
        contact = problem.schedule.contact[leg]
        # a point foot stops when it lands
        return ~contact if problem.robot.leg_list[leg].foot == "point" else np.ones_like(contact)

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        change = foot.motion - foot.previous_motion
        if foot.kind == "steerable":
            return change[0]
        return change if foot.kind == "point" else ca.vertcat(change[0], d.in_swing * change[1])
