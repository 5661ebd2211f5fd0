"""Ground as triangles, looked at by code of its own."""

from __future__ import annotations

import numpy as np

from rollgait.terrain import Terrain
from tests.terrain.worlds import Array


def seen_from_above(corners: Array, points: Array, shear: tuple[float, float] = (0.0, 0.0)) -> Array:
    """Height of the highest of triangles (m, 3, 3) over each point that looks up, (n,), m; NaN if none.

    With a shear, what is seen by rays that go by so much to the side on their way down by 1 m.
    """
    z = corners[..., 2]
    a, b, c = np.moveaxis(corners[..., :2] + z[..., None] * np.array(shear), 1, 0)
    double = across(b - a, c - a)
    up = double > 1e-12
    a, b, c, z, double = (v[up] for v in (a, b, c, z, double))
    result = np.full(len(points), np.nan)
    for k, p in enumerate(points):
        u, v = across(p - a, c - a) / double, across(b - a, p - a) / double
        over = (np.minimum(u, v) >= -1e-7) & (u + v <= 1.0 + 1e-7)
        if over.any():
            u, v, (first, second, third) = u[over], v[over], z[over].T
            result[k] = (first + u * (second - first) + v * (third - first)).max()
    return result


def across(a: Array, b: Array) -> Array:
    """The z component of the cross product of vectors in the plane."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def away_from_edges(terrain: Terrain, points: Array) -> Array:
    """The points at which the ground does not jump within a twentieth of a millimetre."""
    near = [
        terrain.height(*(points + shift).T) for shift in 5e-5 * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
    ]
    return points[np.ptp(near, axis=0) < 1e-4]
