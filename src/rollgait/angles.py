"""Angles of a robot in numbers: Euler angles and their rates, turns about z, and turns that go on."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def euler_angles(R_world_base: Array) -> Array:
    """θ = (yaw, pitch, roll), rad, of R = Rz(yaw) Ry(pitch) Rx(roll)."""
    R = R_world_base
    return np.array(
        [
            np.arctan2(R[1, 0], R[0, 0]),
            np.arcsin(np.clip(-R[2, 0], -1.0, 1.0)),
            np.arctan2(R[2, 1], R[2, 2]),
        ]
    )


def euler_rates(euler: Array, omega_world: Array) -> Array:
    """θ̇, (3,), rad/s, of an angular velocity in world axes; none is defined at a pitch of 90°."""
    yaw, pitch, _ = euler
    c, s = np.cos(yaw), np.sin(yaw)
    roll_rate = (c * omega_world[0] + s * omega_world[1]) / max(np.cos(pitch), 1e-6)
    pitch_rate = c * omega_world[1] - s * omega_world[0]
    return np.array([omega_world[2] + np.sin(pitch) * roll_rate, pitch_rate, roll_rate])


def angular_velocity(euler: Array, euler_rate: Array) -> Array:
    """ω in world axes, (3, …), rad/s, of Euler angles and rates, (3, …): the inverse of `euler_rates`."""
    (c_yaw, c_pitch, _), (s_yaw, s_pitch, _) = np.cos(euler), np.sin(euler)
    yaw_rate, pitch_rate, roll_rate = euler_rate
    return np.array(
        [
            -s_yaw * pitch_rate + c_yaw * c_pitch * roll_rate,
            c_yaw * pitch_rate + s_yaw * c_pitch * roll_rate,
            yaw_rate - s_pitch * roll_rate,
        ]
    )


def near(angle: Any, reference: Any) -> Any:
    """The same angles, by whole turns as near to the reference as they can be, rad."""
    return angle - 2.0 * np.pi * np.round((angle - reference) / (2.0 * np.pi))


def turned(vector: Array, yaw: float) -> Array:
    """Vectors (…, 2 or 3) turned about z: Rz(yaw) vector, from base-yaw to world axes."""
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    size = np.shape(vector)[-1]
    return np.asarray(vector @ R[:size, :size])
