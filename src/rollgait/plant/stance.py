"""A robot that stands: the state it stands in, and the control that keeps it there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rollgait.angles import turned
from rollgait.plant.control import Control
from rollgait.plant.state import RobotState
from rollgait.robot.robot import LEG_NAMES, Robot

Array = NDArray[np.float64]


def standing_state(
    robot: Robot, time: float = 0.0, x: float = 0.0, y: float = 0.0, yaw: float = 0.0
) -> RobotState:
    """The nominal stance, level and at rest, on ground of height 0.

    Args:
        robot: whose stance.
        time: s.
        x, y: place of the CoM, m.
        yaw: of the base, and of the wheels that steer, rad.
    """
    r = np.array([x, y, robot.height])
    return RobotState(
        time=time,
        com_position=r,
        euler=np.array([yaw, 0.0, 0.0]),
        com_velocity=np.zeros(3),
        euler_rate=np.zeros(3),
        foot_position=r + turned(robot.stance, yaw),
        heading=yaw + np.array([leg.heading for leg in robot.leg_list]),
        speed=np.zeros(len(LEG_NAMES)),
    )


def standing_control(robot: Robot, state: RobotState, period: float) -> Control:
    """Holds a state for one period, at rest on all feet: forces balance the weight, none pulls sideways.

    Args:
        robot: whose weight.
        state: where to stand; its velocities are not used.
        period: s.
    """
    feet = len(LEG_NAMES)
    still = replace(state, com_velocity=np.zeros(3), euler_rate=np.zeros(3), speed=np.zeros(feet))
    force = np.zeros((feet, 3))
    force[:, 2] = robot.static_forces(state.foot_position - state.com_position)
    return Control(
        begin=still,
        end=still.at(state.time + period),
        force=force,
        motion=np.zeros((feet, 2)),
        contact=np.ones(feet, dtype=bool),
    )
