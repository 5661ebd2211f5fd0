"""Gauss-Legendre points and Lagrange polynomials on [0, 1]: the base of transcriptions and trajectories."""

from __future__ import annotations

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

Array = NDArray[np.float64]

STATE_POINTS = 3
"""Gauss-Legendre points per interval of all states but the foot heights (paper)."""
HEIGHT_POINTS = 2
"""Gauss-Legendre points per interval of the foot heights (paper)."""


def gauss_points(count: int) -> Array:
    """Gauss-Legendre points on [0, 1], shape (count,)."""
    return np.asarray(0.5 * (leggauss(count)[0] + 1.0))


def lagrange(support: Array, tau: Array) -> tuple[Array, Array]:
    """Values and derivatives of the Lagrange polynomials on `support` (m,) at `tau` (n,): both (n, m)."""
    value = np.ones((tau.size, support.size))
    slope = np.zeros((tau.size, support.size))
    for j, sj in enumerate(support):
        for i, si in enumerate(support):
            if i == j:
                continue
            factor = (tau - si) / (sj - si)
            slope[:, j] = slope[:, j] * factor + value[:, j] / (sj - si)
            value[:, j] *= factor
    return value, slope
