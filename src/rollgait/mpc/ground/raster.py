"""The ground about a robot on a fine raster: what is slow to reckon is reckoned once, then looked up.

Nodes lie at whole multiples of the cell, so that two rasters agree wherever both know the ground.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from rollgait.terrain.regions import Regions

Array = NDArray[np.float64]

CELL: Final = 0.02
"""Distance of neighbouring nodes, m: bilinear in between, a wheel of 0.12 m is off by less than 0.5 mm."""
HALF: Final = 3.2
"""Half the side of a raster, m."""
ROLL_STEEPEST: Final = 1.0
"""Steepest place of its surface that a wheel rolls over with the others' help, rise over run: an edge of 0.29
of its radius. Higher ones must be stepped over."""
ROLL_MARGIN: Final = 0.03
"""So far rolling wheels keep away from such places, m."""
FAR: Final = 1.0
"""Where nothing is to be kept away from, it counts as so far away, m."""

LEAST_UP: Final = 0.1
"""Of a normal, upwards: steeper ones are walls, which nothing stands on."""

KINDS: Final = 6
HEIGHT, STEP_ROOM, ROLL_ROOM, FRICTION = 0, 3, 4, 5
SLOPE = slice(1, 3)
"""Where each kind of what is known stands; see `Raster.look`."""


@dataclass(frozen=True, eq=False)
class Raster:
    """A square of ground for one radius of wheels.

    Attributes:
        values: six numbers of each node, (n, n, 6).
        nearest: indices of the nearest node where a foot may be set down, (2, n, n).
        first: whole numbers of cells from the origin to node [0, 0], (2,).
    """

    values: Array
    nearest: NDArray[np.intp]
    first: NDArray[np.intp]

    @classmethod
    def around(cls, regions: Regions, centre: Array, half: float = HALF) -> Raster:
        """The raster about a place.

        Args:
            regions: of the wheel.
            centre: (2,), m.
            half: half its side, m.
        """
        reach = round(half / CELL)
        first = np.round(np.asarray(centre) / CELL).astype(np.intp) - reach
        axis = np.arange(2 * reach + 1)
        x, y = np.meshgrid((first[0] + axis) * CELL, (first[1] + axis) * CELL, indexing="ij")
        nodes, shape = np.column_stack([x.ravel(), y.ravel()]), x.shape
        touch = regions.surface.touch(nodes)
        height = touch.height.reshape(shape)
        known = ~np.isnan(height)
        height = _filled(height, known)
        gx, gy = _slope(touch.normal).reshape(*shape, 2).transpose(2, 0, 1)
        friction = regions.terrain.friction_at(*nodes.T).reshape(shape)
        may_step = known & regions.free(nodes).reshape(shape)
        walls = _steepest(height) > ROLL_STEEPEST
        step_room, nearest = _room(may_step)
        roll_room, _ = _room(known & ~walls)
        values = np.stack([height, gx, gy, step_room, roll_room - ROLL_MARGIN, friction], axis=-1)
        return cls(values, nearest, first)

    def look(self, points: Array) -> Array:
        """What is known at places (…, 2), (…, 6), by bilinear interpolation.

        In this order: height of the lowest point of the rim (m), its gradient (2), how far inside of where
        feet may be set down it is (m, negative outside), the same for where wheels can roll, μ. Beyond its
        border the ground goes on as it ends.
        """
        place = np.clip(points / CELL - self.first, 0.0, self.values.shape[0] - 1.001)
        index = place.astype(np.intp)
        a, b = np.moveaxis(place - index, -1, 0)[..., None]
        i, j = np.moveaxis(index, -1, 0)
        v = self.values
        low = v[i, j] + a * (v[i + 1, j] - v[i, j])
        high = v[i, j + 1] + a * (v[i + 1, j + 1] - v[i, j + 1])
        return np.asarray(low + b * (high - low))

    def away(self, points: Array, kind: int) -> Array:
        """Gradient of one of the rooms at places (…, 2): the way to more of it, (…, 2)."""
        steps = CELL * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
        room = self.look(points[..., None, :] + steps)[..., kind]
        return np.stack([room[..., 0] - room[..., 1], room[..., 2] - room[..., 3]], axis=-1) / (2.0 * CELL)

    def nearest_foothold(self, point: Array) -> Array:
        """The nearest place to one (2,) where a foot may be set down, (2,), m."""
        place = np.round(point / CELL).astype(np.intp) - self.first
        i, j = np.clip(place, 0, self.values.shape[0] - 1)
        return np.asarray((self.nearest[:, i, j] + self.first) * CELL)

    def room_to_border(self, point: Array) -> float:
        """How far a place (2,) is from the border, m; negative outside."""
        place = point / CELL - self.first
        return float(CELL * np.minimum(place, self.values.shape[0] - 1 - place).min())


def _slope(normal: Array) -> Array:
    """Gradients of the surface with these normals, (n, 2); 0 where it is not known.

    Differences of heights would have a wheel beside a kerb feel it from a cell away.
    """
    known = np.asarray(~np.isnan(normal).any(axis=1))
    up = np.where(known, np.maximum(normal[:, 2], LEAST_UP), 1.0)
    return np.where(known[:, None], -normal[:, :2] / up[:, None], 0.0)


def _steepest(height: Array) -> Array:
    """Largest rise or fall from each node to a neighbour, over run: edges are steepest at their foot."""
    x, y = (np.abs(np.diff(height, axis=axis)) / CELL for axis in range(2))
    result = np.zeros_like(height)
    for part, steps in (
        (result[1:], x),
        (result[:-1], x),
        (result[:, 1:], y),
        (result[:, :-1], y),
    ):
        np.maximum(part, steps, out=part)
    return result


def _filled(height: Array, known: NDArray[np.bool_]) -> Array:
    """Heights that are not known are those of the nearest node that is."""
    if known.all():
        return height
    if not known.any():
        return np.zeros_like(height)
    i, j = ndimage.distance_transform_edt(~known, return_distances=False, return_indices=True)
    return np.asarray(height[i, j])


def _room(allowed: NDArray[np.bool_]) -> tuple[Array, NDArray[np.intp]]:
    """Distance to the border of what is allowed, negative outside, m; the nearest allowed node of each."""
    own = np.indices(allowed.shape).astype(np.intp)
    if allowed.all() or not allowed.any():
        return np.full(allowed.shape, FAR), own  # where all is forbidden nothing can be kept away from
    inside = ndimage.distance_transform_edt(allowed)
    outside, nearest = ndimage.distance_transform_edt(~allowed, return_indices=True)
    room = np.where(allowed, inside - 0.5, 0.5 - outside) * CELL
    return np.asarray(np.minimum(room, FAR)), np.asarray(nearest, dtype=np.intp)
