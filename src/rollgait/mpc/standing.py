"""Coming to a stand without a solver: wheels brake, feet in the air come down, the feet carry the weight."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.mpc.settings import MpcSettings
from rollgait.mpc.state import Control, RobotState
from rollgait.robot.robot import Robot

Array = NDArray[np.float64]

LEVEL_TIME: Final = 0.5
"""Time constant with which tilt and turning die out, s."""


class Standing:
    """Inputs that need nothing but the last control and the figures of the robot."""

    def __init__(self, robot: Robot, settings: MpcSettings) -> None:
        self._robot, self._settings = robot, settings

    def inputs(
        self, state: RobotState, contact: NDArray[np.bool_], previous: Control | None
    ) -> tuple[Array, Array]:
        """Forces (4, 3) and motions (4, 2) of the next period: braking, and forces that carry the weight."""
        before = previous.motion[:, 0] if previous is not None else np.zeros(4)
        slower = np.maximum(
            np.abs(before) - self._settings.period * self._settings.bounds.acceleration_max, 0.0
        )
        motion = np.zeros((4, 2))
        motion[:, 0] = np.sign(before) * slower
        force = np.zeros((4, 3))
        lever = state.foot_position[:, :2] - state.com_position[:2]
        stands = np.flatnonzero(contact)
        if stands.size:
            A = np.vstack([np.ones(stands.size), lever[stands].T])
            share = np.maximum(np.linalg.pinv(A) @ np.array([1.0, 0.0, 0.0]), 0.0)
            force[stands, 2] = self._robot.weight * share / max(float(share.sum()), 1e-6)
        return force, motion

    def settle(self, end: RobotState, period: float) -> RobotState:
        """The same end of a period with a base that moves as its feet do on average, and calms down."""
        keep = np.exp(-period / LEVEL_TIME)
        heading = end.heading
        velocity = np.zeros(3)
        velocity[:2] = np.mean(end.speed * np.array([np.cos(heading), np.sin(heading)]), axis=1)
        return replace(
            end,
            com_velocity=velocity,
            euler=np.array([end.euler[0], keep * end.euler[1], keep * end.euler[2]]),
            euler_rate=keep * end.euler_rate,
        )
