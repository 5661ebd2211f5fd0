"""Coming to a stand without a solver: wheels brake, feet in the air come down, the feet carry the weight."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.angles import turned
from rollgait.mpc.ground.level import UP
from rollgait.mpc.settings import MpcSettings
from rollgait.plant.control import Control
from rollgait.plant.state import RobotState
from rollgait.robot.robot import GRAVITY, Robot

Array = NDArray[np.float64]

STIFFNESS: Final = 25.0
"""Of height and tilt while standing, 1/s²."""
DAMPING: Final = 10.0
"""Of all motion, 1/s: critical."""
LEVEL_TIME: Final = 0.5
"""Time constant with which tilt and turning die out, s."""


class Standing:
    """Inputs that need nothing but the last control and the figures of the robot."""

    def __init__(self, robot: Robot, settings: MpcSettings) -> None:
        self._robot, self._settings = robot, settings

    def inputs(
        self,
        state: RobotState,
        contact: NDArray[np.bool_],
        previous: Control | None,
        tilt: tuple[float, float] = (0.0, 0.0),
        normals: Array = UP,
        contact_offset: Array | float = 0.0,
        pull: Array | None = None,
    ) -> tuple[Array, Array]:
        """Forces (4, 3) and motions (4, 2) of the next period: braking, and forces that carry the weight.

        Args:
            state: now.
            contact: which feet stand, (4,).
            previous: the control before, if there was one.
            tilt: pitch and roll that the ground asks of the base, rad.
            normals: of the ground under the feet, (4, 3).
            contact_offset: from the feet to where the forces act, (4, 3), m.
            pull: force, N, and torque about the CoM, N·m, from outside, world, (6,); none if not given.
        """
        before = previous.motion[:, 0] if previous is not None else np.zeros(4)
        slower = np.maximum(
            np.abs(before) - self._settings.period * self._settings.bounds.acceleration_max, 0.0
        )
        motion = np.zeros((4, 2))
        motion[:, 0] = np.sign(before) * slower
        heading = state.heading
        rolling = np.mean(motion[:, 0] * np.array([np.cos(heading), np.sin(heading)]), axis=1)
        touch = state.foot_position + contact_offset
        against = np.zeros(6) if pull is None else -pull
        return self._forces(state, contact, rolling, tilt, normals, touch, against), motion

    def _forces(
        self,
        state: RobotState,
        contact: NDArray[np.bool_],
        rolling: Array,
        tilt: tuple[float, float],
        normals: Array,
        touch: Array,
        against: Array,
    ) -> Array:
        """Forces of the feet that stand: they carry the robot, stop it over them and right it, (4, 3), N."""
        force, stands, robot = np.zeros((4, 3)), np.flatnonzero(contact), self._robot
        if not stands.size:
            return force
        lever = touch[stands] - state.com_position
        falling = np.append(state.com_velocity[:2] - rolling, state.com_velocity[2])
        low = float((state.com_position - state.foot_position[stands].mean(axis=0))[2]) - robot.height
        acceleration = -DAMPING * falling + np.array([0.0, 0.0, GRAVITY - STIFFNESS * low])
        yaw_rate, pitch_rate, roll_rate = state.euler_rate
        pitch, roll = state.euler[1] - tilt[0], state.euler[2] - tilt[1]
        turning = -STIFFNESS * np.array([roll, pitch, 0.0]) - DAMPING * np.array(
            [roll_rate, pitch_rate, yaw_rate]
        )
        torque = np.diag(robot.inertia_matrix) * turning
        wanted = np.concatenate([robot.mass * acceleration, turned(torque, state.euler[0])]) + against
        A = np.hstack([np.vstack([np.eye(3), _cross_matrix(arm)]) for arm in lever])
        found = (np.linalg.pinv(A, rcond=1e-6) @ wanted).reshape(-1, 3)
        force[stands] = within_cone(found, self._settings.bounds.friction, normals[stands])
        return force

    def settle(self, end: RobotState, period: float, tilt: tuple[float, float] = (0.0, 0.0)) -> RobotState:
        """The same end of a period with a base that moves as its feet do on average, and calms down.

        Args:
            end: of the period.
            period: s.
            tilt: pitch and roll that the ground asks of the base, rad.
        """
        keep, wanted = np.exp(-period / LEVEL_TIME), np.array(tilt)
        heading = end.heading
        velocity = np.zeros(3)
        velocity[:2] = np.mean(end.speed * np.array([np.cos(heading), np.sin(heading)]), axis=1)
        return replace(
            end,
            com_velocity=velocity,
            euler=np.append(end.euler[0], wanted + keep * (end.euler[1:] - wanted)),
            euler_rate=keep * end.euler_rate,
        )


def within_cone(force: Array, friction: float, normals: Array = UP) -> Array:
    """The nearest forces that press, and pull no more than friction allows, (n, 3), N.

    Args:
        force: (n, 3), N.
        friction: μ.
        normals: of the ground, (n, 3).
    """
    normal = np.maximum((force * normals).sum(axis=1), 0.0)
    along = force - (force * normals).sum(axis=1, keepdims=True) * normals
    size = np.maximum(np.linalg.norm(along, axis=1), 1e-9)
    share = np.minimum(1.0, friction * normal / size)
    return np.asarray(along * share[:, None] + normal[:, None] * normals)


def _cross_matrix(a: Array) -> Array:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])
