"""Rotations as pictures need them. Quaternions are (w, x, y, z) unless said otherwise."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from rollgait.plan.samples import Array


def matrix_from_axis(axis: Array, angle: Array) -> Array:
    """R (n, 3, 3) of turns by angles (n,) about one axis (3,), or each about its own, (n, 3)."""
    length = np.linalg.norm(axis, axis=-1, keepdims=True)
    return np.asarray(Rotation.from_rotvec(angle[:, None] * axis / length).as_matrix())


def matrix_from_quaternion(xyzw: Array) -> Array:
    """R (n, 3, 3) of quaternions (x, y, z, w), (n, 4)."""
    return np.asarray(Rotation.from_quat(xyzw).as_matrix())


def matrix_from_euler(euler: Array) -> Array:
    """R_world_base (n, 3, 3) of (yaw, pitch, roll), (n, 3): Rz Ry Rx."""
    return np.asarray(Rotation.from_euler("ZYX", euler).as_matrix())


def wxyz(R: Array) -> Array:
    """Quaternions (w, x, y, z) of matrices (…, 3, 3), (…, 4)."""
    flat = Rotation.from_matrix(R.reshape(-1, 3, 3)).as_quat(scalar_first=True)
    return np.asarray(flat.reshape(*R.shape[:-2], 4))


def turn_z(angle: Array) -> Array:
    """R (…, 3, 3) of turns about the vertical."""
    angle = np.asarray(angle, dtype=float)
    R = Rotation.from_euler("z", angle.ravel()[:, None]).as_matrix()
    return np.asarray(R.reshape(*angle.shape, 3, 3))


def from_z_to(direction: Array) -> Array:
    """R (n, 3, 3) that turn z into each direction (n, 3), not zero."""
    z = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    helper = np.where(np.abs(z[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    x = np.cross(helper, z)
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=-1)
