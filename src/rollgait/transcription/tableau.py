"""Collocation schemes as data."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rollgait.polynomials import gauss_points, lagrange

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Tableau:
    """A polynomial given by its values at 0 and at n points of [0, 1].

    Attributes:
        points: c, (n,).
        weights: b, quadrature weights, (n,): ∫₀¹ g ≈ Σ b_j g(c_j).
        support: 0 and c, (n + 1,).
        slope: derivative at c_j of the polynomial with value 1 at support i, (n, n + 1).
        slope_begin: its derivative at 0, (n + 1,).
        slope_end: its derivative at 1, (n + 1,).
        end: its value at 1, (n + 1,).
    """

    points: Array
    weights: Array
    support: Array
    slope: Array
    slope_begin: Array
    slope_end: Array
    end: Array

    def __post_init__(self) -> None:
        n = self.points.size
        exact = 1.0 / np.arange(1, n + 1)
        if not np.allclose(self.weights @ self.points[:, None] ** np.arange(n), exact, atol=1e-12):
            raise ValueError("the weights must integrate polynomials up to degree n − 1")
        if not np.allclose(self.slope.sum(axis=1), 0.0, atol=1e-12) or not np.isclose(self.end.sum(), 1.0):
            raise ValueError("a constant must have slope 0 and keep its value to the end")

    def values_at(self, tau: Array) -> Array:
        """Values at τ of the polynomials with value 1 at one support, (len(τ), n + 1)."""
        return lagrange(self.support, tau)[0]


@lru_cache
def gauss_legendre(count: int) -> Tableau:
    """The Gauss-Legendre scheme with `count` points; its points exclude both ends."""
    c = gauss_points(count)
    support = np.concatenate([[0.0], c])
    monomials = c[None, :] ** np.arange(count)[:, None]
    weights = np.linalg.solve(monomials, 1.0 / np.arange(1, count + 1))
    return Tableau(
        points=c,
        weights=np.asarray(weights, dtype=float),
        support=support,
        slope=lagrange(support, c)[1],
        slope_begin=lagrange(support, np.zeros(1))[1][0],
        slope_end=lagrange(support, np.ones(1))[1][0],
        end=lagrange(support, np.ones(1))[0][0],
    )
