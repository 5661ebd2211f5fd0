"""Feedback of the base pose: a correction twist of the base, carried out by the wheels.

The twist takes the base to its planned pose in the ground plane. A wheel i at p_i shall then move by
δ_i = v + ω × (p_i − p_base) on top of its planned velocity: along its heading it rolls faster, across it steers,
by δ⊥ v / (v² + ε²), as it must roll to get aside.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.simulation.world import World
from rollgait.tracking.joints import JointTrajectory

Array = NDArray[np.float64]

PERIOD: Final = 0.005
"""Time between two corrections, s."""

GAIN: Final = 3.0
"""Share of the error that is taken back per second, 1/s."""

SPEED_MAX: Final = 0.2
"""Largest linear part of the twist, m/s."""

TURN_MAX: Final = 0.4
"""Largest angular part of the twist, rad/s."""

STEERING_MAX: Final = 0.25
"""Largest correction of a heading, rad."""

STEERING_RATE: Final = 1.5
"""Largest rate of that correction, rad/s."""

SLOW: Final = 0.1
"""ε: a wheel that rolls more slowly steers less, m/s."""


class BaseFeedback:
    """Turns errors of the base pose into shifts of the joints.

    Args:
        world: where the wheels are.
        joints: what is planned.
    """

    def __init__(self, world: World, joints: JointTrajectory) -> None:
        self._world, self._joints = world, joints
        self._rolled = np.zeros(4)
        self._steered = np.zeros(4)
        self._rolling = np.zeros(4)

    def update(self, time: float, p_base: Array, yaw: float, axes: Array) -> tuple[Array, Array]:
        """Δq (n_j,), rad, and Δq̇ (n_j,), rad/s, to hold for the next period.

        Args:
            time: s.
            p_base: measured origin of the base link, (3,), m.
            yaw: measured yaw of the base link, rad.
            axes: axes of the joints in the world, (n_j, 3).
        """
        plan = self._joints
        k = min(int(np.searchsorted(plan.time, time)), len(plan.time) - 1)
        moving = time <= plan.time[-1]
        away = plan.base_position[k, :2] - p_base[:2]
        turned = wrapped(yaw_of(plan.base_quaternion[k]) - yaw)
        velocity = bounded(GAIN * away, SPEED_MAX)
        rate = float(np.clip(GAIN * turned, -TURN_MAX, TURN_MAX))
        samples = plan.reference
        lever = samples.foot_position[k, :, :2] - plan.base_position[k, :2]
        wanted = velocity + rate * np.stack([-lever[:, 1], lever[:, 0]], axis=1)
        heading, speed = samples.heading[k], samples.speed[k] * moving
        c, s = np.cos(heading), np.sin(heading)
        along = wanted[:, 0] * c + wanted[:, 1] * s
        across = wanted[:, 1] * c - wanted[:, 0] * s
        steering = turned + across * speed / (speed**2 + SLOW**2)
        steering = np.clip(steering, -STEERING_MAX, STEERING_MAX)
        stance = samples.contact[k]
        change = np.clip(steering - self._steered, -STEERING_RATE * PERIOD, STEERING_RATE * PERIOD)
        self._steered = self._steered + change
        self._rolling = np.where(stance, along, 0.0) / np.where(self._world.radius > 0.0, self._world.radius, 1.0)
        self._rolled = self._rolled + self._rolling * PERIOD
        return self._as_joints(axes, heading, change / PERIOD)

    def _as_joints(self, axes: Array, heading: Array, steering_rate: Array) -> tuple[Array, Array]:
        shift, rate = np.zeros(len(axes)), np.zeros(len(axes))
        for leg in range(4):
            wheel, steering = self._world.wheels[leg], self._world.steering[leg]
            if wheel is not None:
                left = np.array([-np.sin(heading[leg]), np.cos(heading[leg]), 0.0])
                sign = np.sign(axes[wheel] @ left)
                shift[wheel], rate[wheel] = sign * self._rolled[leg], sign * self._rolling[leg]
            if steering is not None:
                sign = np.sign(axes[steering, 2])
                shift[steering] = sign * self._steered[leg]
                rate[steering] = sign * steering_rate[leg]
        return shift, rate


def yaw_of(quaternion: Array) -> float:
    """Yaw of a quaternion (x, y, z, w), rad."""
    x, y, z, w = quaternion
    return float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


def wrapped(angle: float) -> float:
    """The same angle in [−π, π), rad."""
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)


def bounded(vector: Array, largest: float) -> Array:
    """The vector, shortened to a length of at most `largest`."""
    length = float(np.linalg.norm(vector))
    return np.asarray(vector * (largest / length if length > largest else 1.0))
