"""Taking the noise of a sensor out of heights, and keeping their edges.

Planes are fitted to square windows of several sizes, everywhere. Each node takes the mean of all planes whose
windows hold it, weighted by the risk of each: the variance of the plane there, and the square of what cannot
be noise any more, in the window as a whole and at the node itself. In the middle of a plane all windows
agree and hundreds of heights count; beside an edge those windows count that do not reach over it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from rollgait.terrain.polygons import Array

WINDOWS: Final = (3, 5, 7, 9)
"""Sides of the windows in nodes. On 4 cm cells the largest is as wide as a wheel is high."""
FEWEST: Final = 5
"""Known heights that a plane is fitted to at least: two more than it has numbers."""
SCATTER: Final = 2.0
"""By so many of its own standard deviations the scatter in a window may exceed σ² by chance alone."""
GATE: Final = 3.0
"""A height further than so many σ from a plane is not on it."""
SHARPNESS: Final = 2.0
"""Power of 1 / risk by which planes are weighted; 1 would be best if their errors were independent."""
TILE: Final = 256
"""Side of the pieces into which a large map is cut, in nodes: a few MB for each."""
FLATTEST: Final = 1.0e-3
"""Known heights nearly on a line have no plane: determinant over the cube of their number."""


def without_noise(heights: Array, sigma: float) -> Array:
    """Heights whose noise is taken out; what is not known stays so.

    Args:
        heights: (nx, ny), m; NaN where not known.
        sigma: standard deviation of the noise of each height, m; 0 changes nothing.
    """
    if sigma <= 0.0:
        return heights
    result = np.empty_like(heights)
    reach = max(WINDOWS) - 1  # a window about a neighbour, and all that it holds
    for i in range(0, heights.shape[0], TILE):
        for j in range(0, heights.shape[1], TILE):
            low = max(i - reach, 0), max(j - reach, 0)
            piece = _smoothed(heights[low[0] : i + TILE + reach, low[1] : j + TILE + reach], sigma)
            kept = piece[i - low[0] :, j - low[1] :][:TILE, :TILE]
            result[i : i + TILE, j : j + TILE] = kept
    return result


def noise_of(heights: Array) -> float:
    """σ of the noise in heights (nx, ny), estimated, m; 0 where too few neighbours are known.

    From second differences along both axes, which leave nothing of a plane; their median leaves out edges.
    """
    bent = np.diff(np.diff(heights, n=2, axis=0), n=2, axis=1)
    known = np.abs(bent[~np.isnan(bent)])
    gain = 6.0  # root of the sum of the squares of 1 −2 1 times 1 −2 1
    normal = 0.6744897501960817  # median of |x| of a normal distribution
    return float(np.median(known)) / (gain * normal) if known.size else 0.0


@dataclass(frozen=True)
class _Planes:
    """Planes fitted to the windows about all nodes.

    Attributes:
        reach: of the window to each side of its node, in nodes.
        plane: height at the node and slopes per node, (nx, ny, 3).
        covariance: of these over σ², (nx, ny, 3, 3).
        excess: by how much the scatter about the plane exceeds what noise explains, over σ², (nx, ny).
        found: where there is a plane, (nx, ny).
    """

    reach: int
    plane: Array
    covariance: Array
    excess: Array
    found: NDArray[np.bool_]


def _smoothed(heights: Array, sigma: float) -> Array:
    known = ~np.isnan(heights)
    if not known.any():
        return heights
    middle = float(np.median(heights[known]))  # near 0 the sums of squares keep their digits
    z = np.where(known, heights - middle, 0.0) / sigma
    total, weights = np.zeros_like(z), np.zeros_like(z)
    for side in WINDOWS:
        for value, variance, excess, found in _seen_from_nodes(_planes(z, known, side)):
            beyond = np.where(known, np.maximum(np.abs(z - value) - GATE, 0.0), 0.0)
            risk = np.where(found, variance + excess + beyond**2, np.inf)
            weight = risk**-SHARPNESS
            total += weight * np.where(found, value, 0.0)
            weights += weight
    mean = np.divide(total, weights, out=z.copy(), where=weights > 0.0)
    return np.where(known, middle + sigma * mean, np.nan)


def _planes(z: Array, known: NDArray[np.bool_], side: int) -> _Planes:
    reach = side // 2
    step = np.arange(-reach, reach + 1.0)

    def moment(values: Array, i: int, j: int) -> Array:
        """Σ values x^i y^j over the window about each node."""
        along = ndimage.correlate1d(values, step**i, axis=0, mode="constant")
        return np.asarray(ndimage.correlate1d(along, step**j, axis=1, mode="constant"))

    mask = known.astype(float)
    powers = ((0, 0), (1, 0), (0, 1))
    matrix = np.stack(
        [np.stack([moment(mask, a[0] + b[0], a[1] + b[1]) for b in powers], axis=-1) for a in powers], axis=-2
    )
    right = np.stack([moment(z, *a) for a in powers], axis=-1)
    count = matrix[..., 0, 0]
    found = (count >= FEWEST) & (np.linalg.det(matrix) > FLATTEST * np.maximum(count, 1.0) ** 3)
    covariance = np.linalg.inv(np.where(found[..., None, None], matrix, np.eye(3)))
    plane = np.einsum("...ij,...j", covariance, right)
    freedom = np.maximum(count - 3.0, 1.0)
    scatter = (moment(z * z, 0, 0) - np.einsum("...i,...i", plane, right)) / freedom
    excess = np.where(scatter > 1.0 + SCATTER * np.sqrt(2.0 / freedom), scatter - 1.0, 0.0)
    return _Planes(reach, plane, covariance, excess, np.asarray(found))


def _seen_from_nodes(planes: _Planes) -> Iterator[tuple[Array, Array, Array, NDArray[np.bool_]]]:
    """For each place that a node may have in a window: value and variance there, excess, and if it is one."""
    r = planes.reach
    shape = planes.found.shape

    def padded(values: Array) -> Array:
        return np.pad(values, r)

    h, gx, gy = (padded(planes.plane[..., k]) for k in range(3))
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    hh, xx, yy, hx, hy, xy = (padded(planes.covariance[..., i, j]) for i, j in pairs)
    excess, found = padded(planes.excess), np.pad(planes.found, r)
    for x in range(-r, r + 1):
        for y in range(-r, r + 1):
            at = slice(r - x, r - x + shape[0]), slice(r - y, r - y + shape[1])
            value = h[at] + x * gx[at] + y * gy[at]
            mixed = x * hx[at] + y * hy[at] + x * y * xy[at]
            yield value, hh[at] + x * x * xx[at] + y * y * yy[at] + 2.0 * mixed, excess[at], found[at]
