"""The ground near a place as a few numbers: what a problem takes in place of the ground itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from rollgait.terrain.polygons import Array
from rollgait.terrain.terrain import normal_of

SIGMA: Final = 0.012
"""Width of the weights of moving least squares, m: within ±2 cm, so far a wheel rolls about the middle of an
interval, a kink is met best. Half of it follows the kink in its middle and leaves it beside."""
SIGMA_CELLS: Final = 0.6
"""And in cells of a map, if that is more: between its values a map is bilinear, which is not the ground."""
SUPPORT: Final = 3.0
"""So many σ around a place count."""
SPACING: Final = 0.5
"""Distance of neighbouring samples in σ."""
CURVED: Final = 1.0e-6
"""Curvature from which a model is called curved, 1/m: less is rounding of a plane."""


@dataclass(frozen=True, eq=False)
class LocalModel:
    """z = h0 + g · d + ½ dᵀ H d with d = (x, y) − ref.

    Attributes:
        ref: where it is exact or best, (2,), m.
        height: h0, m.
        slope: g, (2,).
        curvature: H, symmetric, (2, 2), 1/m.
        beside_bend: whether the ground bends near by, though not here.
    """

    ref: Array
    height: float
    slope: Array
    curvature: Array
    beside_bend: bool = False

    @classmethod
    def plane(cls, ref: Array, height: float, slope: Array, beside_bend: bool = False) -> LocalModel:
        """The model of a plane."""
        return cls(ref, height, slope, np.zeros((2, 2)), beside_bend)

    @property
    def curved(self) -> bool:
        """Whether another place would have another slope: only then a problem needs another round."""
        return self.beside_bend or bool(np.abs(self.curvature).max() > CURVED)

    def z(self, points: Array) -> Array:
        """Heights at points (…, 2), (…,), m."""
        d = points - self.ref
        return np.asarray(
            self.height + d @ self.slope + 0.5 * np.einsum("...i,ij,...j", d, self.curvature, d)
        )

    def slope_at(self, points: Array) -> Array:
        """Gradients at points (…, 2), (…, 2)."""
        return np.asarray(self.slope + (points - self.ref) @ self.curvature)

    def normal(self, points: Array) -> Array:
        """Unit normals at points (…, 2), upwards, (…, 3)."""
        return normal_of(self.slope_at(points))

    def numbers(self) -> Array:
        """All of it as one vector for a problem's parameters: ref, h0, g, Hxx, Hxy, Hyy, shape (8,)."""
        H = self.curvature
        return np.array([*self.ref, self.height, *self.slope, H[0, 0], H[0, 1], H[1, 1]])


def pattern(heading: float = 0.0, sigma: float = SIGMA) -> Array:
    """Where samples are taken about a place, (n, 2), m; turned by a heading, to turn with the world."""
    steps = np.arange(-SUPPORT, SUPPORT + 0.5 * SPACING, SPACING) * sigma
    x, y = np.meshgrid(steps, steps, indexing="ij")
    grid = np.column_stack([x.ravel(), y.ravel()])
    grid = grid[np.linalg.norm(grid, axis=1) <= SUPPORT * sigma * (1.0 + 1e-9)]
    c, s = np.cos(heading), np.sin(heading)
    return np.asarray(grid @ np.array([[c, s], [-s, c]]))


def fit(ref: Array, points: Array, heights: Array, sigma: float = SIGMA) -> LocalModel:
    """The quadratic that fits samples best, weighted by exp(−|d|² / 2 σ²).

    With samples too few for a quadratic it is a plane, with fewer than three a level one: of all that fit
    equally well the flattest.

    Args:
        ref: place (2,) of the model, m.
        points: places of the samples, (n, 2) with n ≥ 1, m.
        heights: at the samples, (n,), m.
        sigma: σ, m.
    """
    d = (points - ref) / sigma  # in σ all columns are of one size
    columns = [np.ones(len(d)), d[:, 0], d[:, 1]]
    if len(d) >= 10:  # six numbers, and something to average
        columns += [0.5 * d[:, 0] ** 2, d[:, 0] * d[:, 1], 0.5 * d[:, 1] ** 2]
    weight = np.exp(-0.25 * np.einsum("nk,nk->n", d, d))  # its square is the weight of a squared residual
    matrix = np.column_stack(columns)
    level = float(heights.mean())  # the flattest is meant about the samples, not about z = 0
    found, *_ = np.linalg.lstsq(weight[:, None] * matrix, weight * (heights - level), rcond=1e-9)
    numbers = np.zeros(6)
    numbers[: len(found)] = found
    h, gx, gy, xx, xy, yy = numbers
    return LocalModel(
        np.asarray(ref, dtype=float),
        level + float(h),
        np.array([gx, gy]) / sigma,
        np.array([[xx, xy], [xy, yy]]) / sigma**2,
    )
