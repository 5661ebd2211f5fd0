"""Feedback of the base pose: a correction twist of the base, carried out by the wheels, and by the legs.

The twist takes the base to its planned pose in the ground plane. A wheel i at p_i shall then move by
δ_i = v + ω × (p_i − p_base) on top of its planned velocity: along its heading it rolls faster, across it
steers, by δ⊥ v / (v² + ε²), as it must roll to get aside. After the last step, as far as the wheels stand
still, the legs shift the base over the feet: sideways, or all ways where there are no wheels.
"""

from __future__ import annotations

from typing import Any, Final

import mujoco
import numpy as np
from numpy.typing import NDArray

from rollgait.simulation.world import World
from rollgait.tracking.joints import JointTrajectory

Array = NDArray[np.float64]

PERIOD: Final = 0.005
"""Time between two corrections, s."""

GAIN: Final = 1.0
"""Share of the error that is taken back per second, 1/s."""

SPEED_MAX: Final = 0.2
"""Largest linear part of the twist, m/s."""

TURN_MAX: Final = 0.4
"""Largest angular part of the twist, rad/s."""

STEERING_MAX: Final = 0.25
"""Largest correction of a heading, rad."""

STEERING_TIME: Final = 0.1
"""Time constant with which a heading is corrected, s."""

STEERING_RATE: Final = 1.5
"""Largest rate of that correction, rad/s."""

SLOW: Final = 0.1
"""ε: a wheel that rolls more slowly steers less, m/s."""

SHIFT_MAX: Final = 0.04
"""Farthest that the legs shift the base over the feet, m."""

SHIFT_SPEED: Final = 0.05
"""Largest speed of that, m/s."""

SHIFT_GAIN: Final = 4.0
"""Share of the error that the legs take back per second, 1/s."""

AFTER_STEP: Final = 0.1
"""From how long after the last step on the legs shift the base, s."""

POSITION_WEIGHT: Final = 1e4
"""Of a foot's place over its orientation where a leg cannot keep both, 1/m² per 1/rad²."""


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
        self._shifted = np.zeros(2)
        steps = joints.time[~joints.reference.contact.all(axis=1)]
        self._stands_from = float(steps[-1]) + AFTER_STEP if len(steps) else 0.0
        self._legs = [np.zeros(len(leg)) for leg in world.legs]

    def update(self, time: float, data: Any) -> tuple[Array, Array]:
        """Δq (n_j,), rad, and Δq̇ (n_j,), rad/s, to hold for the next period.

        Args:
            time: s.
            data: MuJoCo's data: the base pose is taken from it as it is, without noise.
        """
        plan = self._joints
        k = min(int(np.searchsorted(plan.time, time)), len(plan.time) - 1)
        moving = time <= plan.time[-1]
        yaw = yaw_of(np.roll(data.qpos[3:7], -1))
        away = plan.base_position[k, :2] - data.qpos[:2]
        turned = wrapped(yaw_of(plan.base_quaternion[k]) - yaw)
        velocity = bounded(GAIN * away, SPEED_MAX)
        rate = float(np.clip(GAIN * turned, -TURN_MAX, TURN_MAX))
        samples = plan.reference
        lever = samples.foot_position[k, :, :2] - plan.base_position[k, :2]
        wanted = velocity + rate * np.stack([-lever[:, 1], lever[:, 0]], axis=1)
        heading, speed = samples.heading[k], samples.speed[k] * moving
        stance = samples.contact[k]
        c, s = np.cos(heading), np.sin(heading)
        along = wanted[:, 0] * c + wanted[:, 1] * s
        across = wanted[:, 1] * c - wanted[:, 0] * s
        rolling = np.where(stance, along, 0.0) / np.where(self._world.radius > 0.0, self._world.radius, 1.0)
        self._rolled += rolling * PERIOD
        steering = turned + across * speed / (speed**2 + SLOW**2)
        steering = np.clip(steering, -STEERING_MAX, STEERING_MAX)
        change = (steering - self._steered) * PERIOD / STEERING_TIME
        change = np.clip(change, -STEERING_RATE * PERIOD, STEERING_RATE * PERIOD)
        self._steered += change
        standing = SLOW**2 / (float(np.max(speed**2)) + SLOW**2)
        if time >= self._stands_from:
            step = bounded(standing * SHIFT_GAIN * self._left_to_legs(away, yaw), SHIFT_SPEED) * PERIOD
            shifted = bounded(self._shifted + step, SHIFT_MAX)
            self._shift_legs(data, np.append(shifted - self._shifted, 0.0))
            self._shifted = shifted
        return self._as_joints(data.xaxis[self._world.joints], heading, rolling, change / PERIOD)

    def _left_to_legs(self, away: Array, yaw: float) -> Array:
        """The part of an error in the ground plane that no wheel can take back, (2,), m."""
        if all(wheel is None for wheel in self._world.wheels):
            return away
        left = np.array([-np.sin(yaw), np.cos(yaw)])
        return np.asarray((away @ left) * left)

    def _shift_legs(self, data: Any, step: Array) -> None:
        """Moves the base over the feet by `step` in the world, (3,), m."""
        world = self._world
        J_p, J_r = np.zeros((3, world.model.nv)), np.zeros((3, world.model.nv))
        for leg, places in enumerate(world.legs):
            mujoco.mj_jacGeom(world.model, data, J_p, J_r, world.feet[leg])
            columns = world.velocity[places]
            J = np.concatenate([np.sqrt(POSITION_WEIGHT) * J_p[:, columns], J_r[:, columns]])
            wanted = np.concatenate([-np.sqrt(POSITION_WEIGHT) * step, np.zeros(3)])
            self._legs[leg] += np.linalg.lstsq(J, wanted, rcond=1e-3)[0]

    def _as_joints(
        self, axes: Array, heading: Array, rolling: Array, steering_rate: Array
    ) -> tuple[Array, Array]:
        shift, rate = np.zeros(len(axes)), np.zeros(len(axes))
        for leg, places in enumerate(self._world.legs):
            shift[places] += self._legs[leg]
            wheel, steering = self._world.wheels[leg], self._world.steering[leg]
            if wheel is not None:
                left = np.array([-np.sin(heading[leg]), np.cos(heading[leg]), 0.0])
                sign = np.sign(axes[wheel] @ left)
                shift[wheel], rate[wheel] = sign * self._rolled[leg], sign * rolling[leg]
            if steering is not None:
                sign = np.sign(axes[steering, 2])
                shift[steering] += sign * self._steered[leg]
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
