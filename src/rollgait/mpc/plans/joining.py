"""Whether a plan can begin where a robot is, or where another plan ends."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import InputError
from rollgait.mpc.plans.path import PlanPath, Row
from rollgait.plant.state import RobotState
from rollgait.robot.robot import LEG_NAMES, Robot

PLACE_MAX: Final = 0.05
"""Farthest of the CoM, or of a foot, from where a plan begins, m: what a stand can make good."""
MOVING_MAX: Final = 0.03
"""The same of CoM and feet in motion, m: half of what makes a plan wait."""
MOVING_SPEED_MAX: Final = 0.15
"""And of the velocity of the CoM, m/s: what wheels make good in a tenth of a second."""
YAW_MAX: Final = np.radians(5.0)
"""The same of the yaw, rad."""


def check_robot(path: PlanPath, robot: Robot) -> None:
    """Raises `InputError` if a plan is of another kind of robot."""
    for own, planned in zip(robot.leg_list, path.robot.leg_list, strict=True):
        same = own.foot == planned.foot and np.allclose(own.stance, planned.stance, atol=1e-6)
        if not same or own.wheel_radius != planned.wheel_radius:
            raise InputError("plan", path.robot.name, f"must be of the robot {robot.name}")


def check_joins(path: PlanPath, before: RobotState | PlanPath, where: str) -> None:
    """Raises `InputError` if a plan begins too far from a state, or from the end of another plan.

    Args:
        path: the plan.
        before: where the robot is then.
        where: what that is, for the message.
    """
    begin = path.at(np.zeros(1))
    if isinstance(before, PlanPath):
        end = before.at(np.array([before.length]))
        place, yaw, feet = end.com_position[0], end.euler[0, 0], end.foot_position[0]
    else:
        place, yaw, feet = before.com_position, before.euler[0], before.foot_position
    away = float(np.hypot(*(place - begin.com_position[0])[:2]))
    turned = abs(float((yaw - begin.euler[0, 0] + np.pi) % (2.0 * np.pi) - np.pi))
    foot = float(np.linalg.norm((feet - begin.foot_position[0])[:, :2], axis=1).max())
    if away > PLACE_MAX or foot > PLACE_MAX or turned > YAW_MAX:
        gap = f"{1e3 * away:.0f} mm, {np.degrees(turned):.1f} degrees, feet up to {1e3 * foot:.0f} mm"
        rule = (
            f"must begin {where}, within {1e3 * PLACE_MAX:.0f} mm and {np.degrees(YAW_MAX):.0f} degrees: "
            f"it is {gap} away"
        )
        x, y, _ = begin.com_position[0]
        raise InputError("plan", f"from x = {x:.3g} m, y = {y:.3g} m", rule)


def check_continues(
    path: PlanPath, state: RobotState, stand: NDArray[np.bool_], shall_stand: NDArray[np.bool_]
) -> None:
    """Raises `InputError` if a plan does not begin as the robot moves.

    Args:
        path: the plan.
        state: of the robot.
        stand, shall_stand: which feet stand, and which do in the plan, (4,).
    """
    begin = path.at(np.zeros(1))
    differ = [name for name, a, b in zip(LEG_NAMES, stand, shall_stand, strict=True) if a != b]
    if differ:
        raise InputError(
            "plan", ", ".join(differ), "must stand or swing as the plan has it where that begins"
        )
    away = float(np.linalg.norm(state.com_position - begin.com_position[0]))
    foot = float(np.linalg.norm((state.foot_position - begin.foot_position[0])[:, :2], axis=1).max())
    speed = float(np.linalg.norm(state.com_velocity - begin.com_velocity[0]))
    turned = abs(float(state.euler[0] - begin.euler[0, 0]))
    if max(away, foot) > MOVING_MAX or speed > MOVING_SPEED_MAX or turned > YAW_MAX:
        gap = (
            f"{1e3 * away:.0f} mm, feet up to {1e3 * foot:.0f} mm, {speed:.2f} m/s, "
            f"{np.degrees(turned):.1f} degrees off"
        )
        rule = f"must begin within {1e3 * MOVING_MAX:.0f} mm and {MOVING_SPEED_MAX:g} m/s of the robot"
        raise InputError("plan", gap, rule)


def whole_turns(row: Row, yaw: float) -> float:
    """Whole turns, rad, by which a robot with a yaw has turned beyond a plan's."""
    return 2.0 * np.pi * round((yaw - float(row.euler[0, 0])) / (2.0 * np.pi))
