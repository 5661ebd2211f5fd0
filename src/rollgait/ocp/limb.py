"""Limits of the joints behind a steerable foot, in closed form (profile `executable`).

With (X, Y) the contact point from the hip_yaw axis in the base-yaw frame, the leg's plane stands at the angle
α with Rz(α) (direction √(X² + Y² − d²), d) = (X, Y), and hip_yaw = −α. The wheel's heading is
σ − θz = −(hip_yaw + ankle_yaw). All this is seen from a base that is tilted as the ground asks for, a few
degrees from how it is. The wheel stays upright in the leg's plane: on a slope the ankle does not stand above
it as the base sees it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Self

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from rollgait.ocp.context import PlanContext
from rollgait.ocp.instant import Foot, Instant
from rollgait.ocp.over import between_nodes_over
from rollgait.ocp.term import Data, FootConstraint, Limits
from rollgait.robot.robot import Limb
from rollgait.scenario.scenario import Scenario

_SQUARE_MIN = 1e-4
"""m²: smooths √(ρ² − d²) where the foot is under the hip (infeasible, but a solver may try it)."""


def limb_of(problem: PlanContext, leg: int) -> Limb | None:
    """The figures of the leg's joints, where the foot is a steerable wheel and the robot knows them."""
    data = problem.robot.leg_list[leg]
    return data.limb if data.foot == "steerable" else None


def knows_joints(scenario: Scenario) -> bool:
    """Whether the robot has figures of the joints behind each of its steerable feet."""
    return all(leg.limb is not None for leg in scenario.body.leg_list if leg.foot == "steerable")


class JointSteering(FootConstraint):
    """hip_yaw and the steering joint stay within their limits, less a margin.

    A fixed range of σ − θz is not the hardware's: hip_yaw moves with the foot, about 3 rad per metre.
    """

    name = "joint_steering"
    sentence = "hip_yaw or the steering joint would have to leave its range"
    left_out_at_first = True
    unit = "rad"

    @classmethod
    def asked_for(cls, scenario: Scenario) -> Sequence[Self]:
        return (cls(),) if scenario.value_of("bounds", cls.name) and knows_joints(scenario) else ()

    def applies(self, problem: PlanContext, leg: int) -> bool:
        return limb_of(problem, leg) is not None

    def data(self, problem: PlanContext, leg: int) -> Mapping[str, ArrayLike]:
        limb = _known(limb_of(problem, leg))
        return {"hip": limb.hip, "offset": [limb.plane_offset], "direction": [limb.direction]}

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        limb = _known(limb_of(problem, leg))
        ranges = np.array([limb.hip_yaw, limb.steering_joint])
        margin = np.radians(problem.bound("joint_margin_deg") or 0.0)
        return ranges[:, :1] + margin, ranges[:, 1:] - margin

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        X, Y = foot.p_body[0] - d.hip[0], foot.p_body[1] - d.hip[1]
        along = _along(X, Y, _forward(X**2 + Y**2 - d.offset**2, d), d)
        hip_yaw = -ca.atan2(along[1], along[0])
        angles: ca.SX = ca.vertcat(hip_yaw, -foot.steering - hip_yaw)
        return angles


class Reach(FootConstraint):
    """The leg is neither stretched nor folded too far, nor the foot under the hip: limits of e² and of ρ²."""

    name = "reach"
    sentence = "the leg would have to be stretched or folded further"
    keeps = True
    left_out_at_first = True
    unit = "m²"
    curvature = 1.2  # 2 ‖ṗ‖² of a foot that passes its hip at 0.77 m/s

    @classmethod
    def asked_for(cls, scenario: Scenario) -> Sequence[Self]:
        return (cls(),) if scenario.value_of("bounds", cls.name) and knows_joints(scenario) else ()

    def applies(self, problem: PlanContext, leg: int) -> bool:
        return problem.robot.leg_list[leg].limb is not None  # a locked wheel hangs on the same joints

    def data(self, problem: PlanContext, leg: int) -> Mapping[str, ArrayLike]:
        limb = _known(problem.robot.leg_list[leg].limb)
        return {
            "hip": limb.hip,
            "offset": [limb.plane_offset],
            "direction": [limb.direction],
            "ankle_height": [limb.ankle_height],
        }

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        limb = _known(problem.robot.leg_list[leg].limb)
        margin = problem.bound("reach_margin") or 0.0
        lower = np.square([limb.extension[0] + margin, limb.radius_min])[:, None]
        upper = np.array([[(limb.extension[1] - margin) ** 2], [np.inf]])
        return lower, upper

    def expression(self, x: Instant, foot: Foot, d: Data) -> ca.SX:
        from_hip = foot.p_body - d.hip
        rho_square = ca.sumsqr(from_hip[:2])
        forward = _forward(rho_square - d.offset**2, d)
        along = _along(from_hip[0], from_hip[1], forward, d)
        lean = (along[0] * foot.up_body[0] + along[1] * foot.up_body[1]) / rho_square
        ankle = d.ankle_height * lean  # how far it stands before the wheel, along the leg's plane
        v = -(from_hip[2] + d.ankle_height * foot.up_body[2])
        e_square = rho_square - d.offset**2 + ankle * (2.0 * forward + ankle) + v**2
        squares: ca.SX = ca.vertcat(e_square, rho_square)
        return squares


class PlannedReach(Reach):
    """`Reach` with a reserve between nodes where a foot goes over something: it has to turn in the air."""

    curvature_over = 1.2  # m²/s² more

    def limits(self, problem: PlanContext, leg: int) -> Limits:
        lower, upper = (np.asarray(limit) for limit in super().limits(problem, leg))
        if not problem.footing.swings:
            return lower, upper
        over = np.outer([1.0, 0.0], between_nodes_over(problem, leg, self.curvature_over))
        return lower + over, upper - over


def _forward(square: ca.SX, d: Data) -> ca.SX:
    """direction √square, smooth where the foot is under the hip."""
    return ca.SX(d.direction * ca.sqrt(0.5 * (square + ca.sqrt(square**2 + _SQUARE_MIN**2))))


def _along(X: ca.SX, Y: ca.SX, forward: ca.SX, d: Data) -> tuple[ca.SX, ca.SX]:
    """ρ² Rz(α) e_x: along the leg's plane, away from its hip if the leg extends forward."""
    return forward * X + d.offset * Y, forward * Y - d.offset * X


def _known(limb: Limb | None) -> Limb:
    assert limb is not None, "asked only for legs to which the term applies"
    return limb
