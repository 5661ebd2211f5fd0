"""Where the lowest point of a wheel's rim is when the wheel touches the ground: the ground dilated by it.

    h_c(x) = max over |u| ≤ R of h(x + u) + √(R² − |u|²) − R

This is the dilation by a ball of the wheel's radius. A wheel is a thin disc in the plane of its heading,
which it may turn while it stands: its own dilation takes only the u along the heading, so it is never higher.
The ball serves every heading with one surface, and errs to the safe side: beside a kerb it keeps the whole R
away where the disc could roll along it. On a slope across its heading an upright disc stands R (1/cos α − 1)
lower than the ball: 4 mm at 15° and R = 0.124 m.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from rollgait.errors import InputError
from rollgait.terrain.facet import Facet
from rollgait.terrain.height_map import MAX_CELLS, HeightMap
from rollgait.terrain.polygons import Array, contains, edges
from rollgait.terrain.terrain import Terrain, as_points, normal_of

CELL: Final = 0.01
"""Coarsest grid on which a map is dilated, m: at R = 0.124 m its error is 0.1 mm."""
CELLS_PER_RADIUS: Final = 6
"""And the fewest cells in a radius: a small foot on a coarse grid would be a square."""

BALLS: Final = 1000
"""So many are laid on a map at a time: each looks at hundreds of nodes."""


@dataclass(frozen=True)
class Touch:
    """How a wheel touches the ground at n places.

    Attributes:
        height: z of the lowest point of its rim, (n,), m; NaN where the ground is not known.
        contact: the true contact on its rim, (n, 3), m.
        normal: unit normal there, from the contact to the centre of the wheel, (n, 3).
        plane: number in `Terrain.planes` of what it touches, (n,); −1 where that is a map.
        face: whether it touches that plane in its inside, not at an edge, (n,).
    """

    height: Array
    contact: Array
    normal: Array
    plane: NDArray[np.intp]
    face: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class WheelSurface:
    """The surface of the lowest rim point of a wheel, or of a round point foot.

    Attributes:
        terrain: the raw ground.
        radius: R of the wheel or of the ball of the foot, m; 0 is the ground itself.
        window: smallest and largest (x, y) of the part of a map that is needed, m; all of it if None.
    """

    terrain: Terrain
    radius: float
    window: tuple[tuple[float, float], tuple[float, float]] | None = None

    def __post_init__(self) -> None:
        if not (np.isfinite(self.radius) and self.radius >= 0.0):
            raise InputError("radius", self.radius, "must be a finite number of metres, not negative")

    def height(self, x: ArrayLike, y: ArrayLike) -> Array:
        """z of the lowest rim point at places that broadcast together, their shape, m; NaN if not known."""
        points, shape = as_points(x, y)
        return self.touch(points).height.reshape(shape)

    def touch(self, points: Array) -> Touch:
        """How the wheel touches the ground with its lowest rim point over points (n, 2)."""
        best = _Best(points)
        if self.terrain.map is not None:
            self._touch_map(best)
        for number, index in self.terrain.seen.near(points, self.radius):
            _touch_facet(best, self.terrain.planes[number], number, index, self.radius)
        height = np.where(np.isfinite(best.height), best.height, np.nan)
        centre = np.column_stack([points, height + self.radius])
        return Touch(height, centre - self.radius * best.normal, best.normal, best.plane, best.face)

    @cached_property
    def raw_grid(self) -> HeightMap | None:
        """The map where no part lies over it, on a grid fine enough for the radius; None without a map."""
        raster = self.terrain.map
        if raster is None:
            return None
        raster = _cut(raster, self.window, self.radius)
        raster = raster.refined(_refinement(raster, self.radius))
        heights = raster.values + self.terrain.level
        nodes = raster.nodes().reshape(-1, 2)
        covered = np.zeros(len(nodes), dtype=bool)
        for _, index in self.terrain.seen.under(nodes):
            covered[index] = True
        if covered.all():  # parts cover all of it
            return None
        heights = np.where(covered.reshape(heights.shape), np.nan, heights)
        return None if np.isnan(heights).all() else raster.with_values(heights)

    @cached_property
    def grid(self) -> HeightMap | None:
        """The same dilated by the wheel."""
        raw = self.raw_grid
        if raw is None:
            return None
        return raw.with_values(_dilated(raw.values, self.radius / raw.resolution, raw.resolution))

    def _touch_map(self, best: _Best) -> None:
        grid = self.grid
        if grid is None:
            return
        height, slope = grid.height(best.points), grid.slope(best.points)
        known = ~np.isnan(height) & ~np.isnan(slope).any(axis=1)
        best.take(
            np.flatnonzero(known),
            height[known],
            normal_of(slope[known]),
            -1,
            np.ones(int(known.sum()), dtype=bool),
        )


class _Best:
    """The highest touch found so far at each point."""

    def __init__(self, points: Array) -> None:
        count = len(points)
        self.points = points
        self.height = np.full(count, -np.inf)
        self.normal = np.full((count, 3), np.nan)
        self.plane = np.full(count, -1, dtype=np.intp)
        self.face = np.zeros(count, dtype=bool)

    def take(
        self, index: NDArray[np.intp], height: Array, normal: Array, plane: int, face: NDArray[np.bool_]
    ) -> None:
        """Takes touches at the numbered points where they are higher than what was found before.

        A face wins over an edge of the same height: on a seam between two pieces of a plane both touch.
        """
        before = self.height[index]
        higher = (height > before + 1e-12) | (face & ~self.face[index] & (height >= before - 1e-12))
        index = index[higher]
        self.height[index], self.normal[index] = height[higher], normal[higher]
        self.plane[index], self.face[index] = plane, face[higher]


def _touch_facet(best: _Best, facet: Facet, number: int, index: NDArray[np.intp], radius: float) -> None:
    """The touch of a ball at some points with a planar polygon: with its inside, or its highest edge."""
    points = best.points[index]
    steepness = math.sqrt(1.0 + float(facet.slope @ facet.slope))
    offset = radius * facet.slope / steepness
    face = contains(facet.polygon, points + offset)
    height = np.where(face, facet.z(points) + radius * (steepness - 1.0), -np.inf)
    normal = np.broadcast_to(normal_of(facet.slope), (len(points), 3)).copy()
    if radius > 0.0:
        for begin, end in zip(*edges(facet.polygon), strict=True):
            _touch_edge(points, height, normal, ~face, facet, begin, end, radius)
    touched = np.isfinite(height)
    best.take(index[touched], height[touched], normal[touched], number, face[touched])


def _touch_edge(
    points: Array,
    height: Array,
    normal: Array,
    wanted: NDArray[np.bool_],
    facet: Facet,
    begin: Array,
    end: Array,
    radius: float,
) -> None:
    """Raises heights in place where the ball touches an edge: a concave function of the way along it."""
    length = float(np.linalg.norm(end - begin))
    along = (end - begin) / length
    rise = float(facet.slope @ along)
    relative = points - begin
    beside = relative @ np.array([-along[1], along[0]])
    reach = np.sqrt(np.maximum(radius**2 - beside**2, 0.0))  # of the ball along the edge
    middle = relative @ along
    place = np.clip(middle + reach * rise / math.sqrt(1.0 + rise**2), 0.0, length)
    under = radius**2 - beside**2 - (place - middle) ** 2
    touches = wanted & (under >= 0.0)
    if not touches.any():
        return
    contact = begin + place[touches, None] * along
    z = facet.z(contact)
    candidate = z + np.sqrt(under[touches]) - radius
    index = np.flatnonzero(touches)
    better = candidate > height[index]
    index = index[better]
    height[index] = candidate[better]
    arm = np.column_stack([points[index] - contact[better], candidate[better] + radius - z[better]])
    normal[index] = arm / radius


def ball_touch(raw: HeightMap, radius: float, points: Array) -> tuple[Array, Array]:
    """How a ball with its lowest point over places (n, 2) of a map touches its nodes.

    Exact for these nodes, where `WheelSurface.grid` is bilinear between places of the ball on the grid.

    Returns:
        z of its lowest point and how far from it, horizontally, the touched node is, (n,), m.
    """
    reach = math.ceil(radius / raw.resolution) + 1
    steps = np.arange(-reach, reach + 1)
    around = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    padded = np.pad(np.where(np.isnan(raw.values), -np.inf, raw.values), reach, constant_values=-np.inf)
    height, away = np.empty((2, len(points)))
    for k in range(0, len(points), BALLS):
        place = raw.to_local(points[k : k + BALLS]) / raw.resolution
        node = np.clip(np.round(place), 0, np.array(raw.values.shape) - 1).astype(np.intp)
        near = node[:, None] + around
        distance = raw.resolution * np.linalg.norm(near - place[:, None], axis=-1)
        rim = np.sqrt(np.maximum(radius**2 - distance**2, 0.0)) - radius
        z = padded[near[..., 0] + reach, near[..., 1] + reach]
        lowest = np.where(distance <= radius, z + rim, -np.inf)
        best = lowest.argmax(axis=1)[:, None]
        height[k : k + BALLS] = np.take_along_axis(lowest, best, axis=1)[:, 0]
        away[k : k + BALLS] = np.take_along_axis(distance, best, axis=1)[:, 0]
    return height, away


def _cut(
    raster: HeightMap, window: tuple[tuple[float, float], tuple[float, float]] | None, radius: float
) -> HeightMap:
    """The part of a map that a wheel anywhere in the window can touch."""
    if window is None:
        return raster
    (x0, y0), (x1, y1) = window
    corners = raster.to_local(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])) / raster.resolution
    reach = radius / raster.resolution + 2.0
    first = np.clip(np.floor(corners.min(axis=0) - reach), 0, np.array(raster.values.shape) - 2).astype(int)
    last = np.clip(np.ceil(corners.max(axis=0) + reach), first + 1, np.array(raster.values.shape) - 1)
    i, j = int(last[0]) + 1, int(last[1]) + 1
    values = raster.values[first[0] : i, first[1] : j]
    if np.isnan(values).all():
        raise InputError("window", window, "must hold ground that is known somewhere")
    return HeightMap(values, raster.resolution, raster.to_world(raster.resolution * first), raster.yaw)


def _refinement(raster: HeightMap, radius: float) -> int:
    """By how much a map is refined before it is dilated: as far as the radius asks and the memory allows."""
    if radius == 0.0:
        return 1
    wanted = math.ceil(raster.resolution / min(CELL, radius / CELLS_PER_RADIUS) - 1e-9)
    finest = math.floor(raster.resolution / 1.0e-3 + 1e-9)
    most = math.floor(math.sqrt(MAX_CELLS / raster.values.size))
    return max(1, min(wanted, most, finest))


def _dilated(heights: Array, cells: float, resolution: float) -> Array:
    """A raster dilated by a ball of a radius in cells; what no known node lifts stays unknown."""
    reach = math.floor(cells)
    if reach == 0:
        return heights
    i, j = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    square = cells**2 - i**2 - j**2
    ball = np.where(square >= 0.0, resolution * (np.sqrt(np.maximum(square, 0.0)) - cells), 0.0)
    known = np.where(np.isnan(heights), -np.inf, heights)
    result = ndimage.grey_dilation(
        known, footprint=square >= 0.0, structure=ball, mode="constant", cval=-np.inf
    )
    return np.where(np.isinf(result), np.nan, result)
