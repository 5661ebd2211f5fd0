"""A robot that stands: the state it stands in, and the control that keeps it there."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rollgait.angles import turned
from rollgait.plant.control import Control
from rollgait.plant.state import RobotState
from rollgait.robot.robot import LEG_NAMES, Robot

if TYPE_CHECKING:
    from rollgait.terrain.terrain import Terrain

Array = NDArray[np.float64]


def standing_state(
    robot: Robot,
    time: float = 0.0,
    x: float = 0.0,
    y: float = 0.0,
    yaw: float = 0.0,
    terrain: Terrain | None = None,
) -> RobotState:
    """The nominal stance at rest: level on ground of height 0, or after a terrain.

    Args:
        robot: whose stance.
        time: s.
        x, y: place of the CoM, m.
        yaw: of the base, and of the wheels that steer, rad.
        terrain: the ground.
    """
    r = np.array([x, y, robot.height])
    euler, feet = np.array([yaw, 0.0, 0.0]), r + turned(robot.stance, yaw)
    if terrain is not None:
        from rollgait.terrain.references import base_reference
        from rollgait.terrain.wheel_surface import WheelSurface  # loads SciPy, which level ground needs not

        for leg, foot in zip(robot.leg_list, feet, strict=True):
            foot[2] = WheelSurface(terrain, leg.wheel_radius or 0.0).height(foot[0], foot[1])
        wanted = base_reference(feet, yaw)
        euler[1:], r[2] = (wanted.pitch, wanted.roll), wanted.ground + robot.height
    return RobotState(
        time=time,
        com_position=r,
        euler=euler,
        com_velocity=np.zeros(3),
        euler_rate=np.zeros(3),
        foot_position=feet,
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
