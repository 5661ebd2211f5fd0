"""Limits of the feet's places, headings and speeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final, Self

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.ocp.context import Context, PlanContext
from rollgait.ocp.instant import Foot, Instant
from rollgait.ocp.limb import JointSteering, Reach
from rollgait.ocp.over import between_nodes_over
from rollgait.ocp.term import INPUT, Data, FootConstraint, Limits, Mask, Phase, Place
from rollgait.scenario.scenario import Scenario

LIFT_OF_HEIGHT: Final = 0.24
"""How far a foot is lifted beyond its nominal place at most, in heights of the CoM, where the box says less:
CENTAURO's 0.18 m; its hip pitch meets its limit at 0.19 m."""

OVER_ACCELERATION = 5.0
"""m/s² beyond the tolerance of 1 mm, vertically, of a foot that has passed what it goes over and comes down:
HyQ's has 6 where it steps down by a quarter of its height, and rises by 6 mm between two nodes."""


class Box(FootConstraint):
    """−b_i ≤ Rzᵀ (p_i − r) − p̄_i ≤ b_i′, componentwise; `full_rotation` uses R(θ) in place of Rz.

    On ground that is not flat the frame is tilted as the ground asks for (`Body.R_world_feet`), and how low a
    foot may be says the reach of its leg where that is known, how high the hip: a box would forbid a step.
    """

    name = "box"
    sentence = "the foot would have to leave its box"
    unit = "m"
    curvature = 1.5  # beyond the tolerance of 1 mm: a wheel at full speed that steers while the base brakes

    def __init__(self, full_rotation: bool = False) -> None:
        self.full_rotation = full_rotation
        self.structure = (full_rotation,)

    @classmethod
    def asked_for(cls, scenario: Scenario) -> Sequence[Self]:
        return (cls(scenario.bounds.full_rotation),)

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        low, high = sides(problem, leg)
        if not problem.footing.is_flat and Reach().applies(problem, leg) and problem.bound(Reach.name):
            low[2], high[2] = -np.inf, max(high[2, 0], LIFT_OF_HEIGHT * problem.robot.height)
            return low, high  # the hip has a centimetre more
        if not problem.footing.swings:
            return low, high
        high = np.repeat(high, problem.footing.count, axis=1)
        high[2] -= between_nodes_over(problem, leg, OVER_ACCELERATION - self.curvature)
        return low, high

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        p_body = x.R_world_base.T @ (foot.p - x.r) if self.full_rotation else foot.p_body
        return p_body - x.body.stance[:, foot.index]


def sides(context: Context, leg: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Smallest and largest offset of a foot from its nominal place, two arrays (3, 1), m."""
    low, high = context.robot.foot_boxes(context.bound("box"))[leg][..., None]
    return low, high


class Steering(FootConstraint):
    """σ_min ≤ σ_i − θz ≤ σ_max; headings are never reduced mod 2π.

    Where the joints limit the steering, a fixed range holds beside them only if the scenario names one.
    """

    name = "steering"
    sentence = "the wheel would have to steer further"
    keeps = True
    unit = "rad"

    @classmethod
    def asked_for(cls, scenario: Scenario) -> Sequence[Self]:
        wanted = scenario.bounds.steering_deg is not None or not JointSteering.asked_for(scenario)
        return (cls(),) if wanted else ()

    def applies(self, problem: PlanContext, leg: int) -> bool:
        return problem.robot.leg_list[leg].foot == "steerable"

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        return problem.steering_range(leg)

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.steering


class SteeringRate(FootConstraint):
    """|σ̇_i| ≤ σ̇_max, in stance and in swing."""

    name = "steering_rate"
    sentence = "the wheel would have to steer faster"
    bound = ("steering_rate_max", "faster steering")
    places = INPUT
    unit = "rad/s"

    def applies(self, problem: PlanContext, leg: int) -> bool:
        return problem.robot.leg_list[leg].foot == "steerable"

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        limit = problem.steering_rate_max(leg)
        return -limit, limit

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.heading_rate


class StanceSpeed(FootConstraint):
    """|v_i| ≤ v_max in stance, along the ground."""

    name = "stance_speed"
    sentence = "the wheel would have to roll faster"
    bound = ("speed_max", "faster wheels")
    places = INPUT
    phase = Phase.STANCE
    unit = "m/s"

    def applies(self, problem: PlanContext, leg: int) -> bool:
        return problem.robot.leg_list[leg].foot != "point"

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        limit = problem.speed_max(leg)
        return -limit, limit

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.surface_speed


class SwingSpeed(FootConstraint):
    """|v_i| ≤ swing_speed_max in swing; of both components where the foot moves freely."""

    name = "swing_speed"
    sentence = "the foot would have to swing faster"
    bound = ("swing_speed_max", "faster swings")
    places = INPUT
    phase = Phase.SWING
    unit = "m/s"

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        limit = problem.bound("swing_speed_max")
        return -limit, limit

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        return foot.speed if foot.kind == "steerable" else foot.motion


class Acceleration(FootConstraint):
    """|v_k − v_{k−1}| ≤ a h (executable): wheel speeds do not jump, not even at t = 0, where v was 0.

    v is constant in an interval, its value at the middle: h is the time between the middles of both.

    a is `acceleration_max` for a foot that stays on the ground and `swing_acceleration_max` for one that
    swings or has just landed (its wheel is free to spin up in the air). What moves freely in swing has a
    second component there and until it has stopped on the ground: a foot that is set down while it flies
    drags the robot along. So has a wheel that may slip, while it stays.
    """

    name = "acceleration"
    keys = ("acceleration_max", "swing_acceleration_max")
    sentence = "the foot would have to change its speed faster"
    left_out_at_first = True
    places = INPUT
    unit = "m/s"

    def data(self, problem: PlanContext, leg: int) -> Mapping[str, ArrayLike]:
        stays = self._stays(problem, leg)[None, :]
        return {"sideways": ~stays | (problem.scenario.slip_max(leg) > 0.0)}

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        limit = self.largest(problem, leg) * problem.schedule.mesh.between_middles
        return -limit, limit

    def largest(self, problem: PlanContext, leg: int) -> NDArray[np.float64]:
        """a in each interval, (1, N), m/s²."""
        stays = self._stays(problem, leg)
        stance, swing = (
            problem.bound(name) or np.inf for name in ("acceleration_max", "swing_acceleration_max")
        )
        return np.asarray(np.where(stays, stance, swing)[None, :])

    def holds(self, problem: PlanContext, place: Place, leg: int) -> Mask:
        stays = self._stays(problem, leg)
        return ~stays if problem.robot.leg_list[leg].foot == "point" else np.ones_like(stays)

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        change = foot.motion - foot.previous_motion
        if foot.kind == "steerable":
            return change[0]
        return change if foot.kind == "point" else ca.vertcat(change[0], d.sideways * change[1])

    def _stays(self, problem: PlanContext, leg: int) -> NDArray[np.bool_]:
        contact = problem.schedule.contact[leg]
        return np.asarray(contact & np.concatenate([[True], contact[:-1]]))
