"""Where a wheel can roll and stand: not too steep, one contact below it, away from edges.

There are two kinds of ground and one interface: `PlanarRegions` reckons exactly with the borders of planes,
`RasterRegions` marks the cells of a map. `regions_of` chooses.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

from rollgait.terrain.convex_region import EVERY, REACH, SIDES, ConvexRegion, Obstacles, grow
from rollgait.terrain.edges import Border, borders, components, hard_edges
from rollgait.terrain.height_map import HeightMap
from rollgait.terrain.local_model import SIGMA, SIGMA_CELLS, LocalModel, fit, pattern
from rollgait.terrain.places import Places
from rollgait.terrain.polygons import Array, nearest_on_segments
from rollgait.terrain.terrain import Terrain
from rollgait.terrain.wheel_surface import WheelSurface, ball_touch

FRICTION_SHARE: Final = 0.85
"""Steepest slope as a share of μ: what is left is for driving and for what was measured wrongly."""
MARGIN: Final = 0.03
"""Distance from edges, m: what a robot that executes a plan misses its footholds by, and a little more."""
LIFT_MAX: Final = 5.0e-3
"""By how much something else may lift a wheel off what is below it on a map, m: more is an edge."""

Window = tuple[tuple[float, float], tuple[float, float]]
"""Smallest and largest (x, y) of a part of a map, m."""
COARSER: Final = 0.25
"""Of what a map is coarser than the grid, this part is kept from edges as well."""
ROUNDING: Final = 1.0e-9
"""m; a distance that is short by less is long enough."""
NEAREST_STEP: Final = 2.0e-3
"""m, between the distances at which the nearest free place is looked for."""
NEAREST_WAYS: Final = 32
"""In so many directions."""
HALVINGS: Final = 6
"""How often the place between two nodes at which a wheel begins to touch something is halved: to 0.2 mm."""

Scalar = TypeVar("Scalar", bound=np.generic)


@dataclass(frozen=True, eq=False)
class Regions(ABC):
    """Where one wheel can be.

    Attributes:
        surface: of the lowest point of its rim.
        margin: distance from edges, m.
        rolls: whether the foot does; else a kink divides planes, so that each foothold lies in one of them.
    """

    surface: WheelSurface
    margin: float = MARGIN
    rolls: bool = True

    @property
    def terrain(self) -> Terrain:
        """The raw ground."""
        return self.surface.terrain

    @abstractmethod
    def label(self, points: Array) -> NDArray[np.intp]:
        """The region of each point (n, 2), −1 where no foot goes: equal where a wheel can roll between."""

    @abstractmethod
    def rollable(self, points: Array) -> NDArray[np.bool_]:
        """Which points (n, 2) a wheel can stand on, without the margin from edges."""

    @property
    @abstractmethod
    def obstacles(self) -> Obstacles:
        """What the lowest point of the rim keeps away from, clearances with the margin."""

    @property
    @abstractmethod
    def sigma(self) -> float:
        """Width of the weights of local models, m."""

    @abstractmethod
    def _same_side(self, ref: Array, points: Array) -> NDArray[np.bool_]:
        """Which points (n, 2) lie on the same side of all edges as `ref`."""

    def free(self, points: Array) -> NDArray[np.bool_]:
        """Which points (n, 2) a foot may go to."""
        return np.asarray(self.label(points) >= 0)

    def nearest_free(self, place: Array, most: float) -> Array | None:
        """The nearest place where a foot may go, from one (2,), m, on the same side of all edges.

        None if there is none within `most`, m, or if no foot can stand at the given place itself.
        """
        if not self.rollable(place[None])[0]:
            return None
        radius = np.arange(NEAREST_STEP, most + ROUNDING, NEAREST_STEP)
        angle = 2.0 * np.pi * np.arange(NEAREST_WAYS) / NEAREST_WAYS
        points = place + (radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)).reshape(
            -1, 2
        )
        good = np.flatnonzero(self.free(points) & self._same_side(place, points))
        return points[good[0]] if good.size else None

    def box(
        self, path: Array, heading: float = 0.0, reach: float = REACH, sides: int = SIDES
    ) -> ConvexRegion | None:
        """A convex region about the places of a stance; None if there is none with the margin.

        Args:
            path: places, (n, 2), m: all in one region.
            heading: direction of its window, rad.
            reach: how far it goes beyond the path, m.
            sides: most half-planes.
        """
        labels = self.label(path)
        if labels[0] < 0 or (labels != labels[0]).any():
            return None
        return grow(self.obstacles.of(int(labels[0])), path, heading, reach, sides)

    def boxes(
        self, path: Array, headings: Array, reach: float = REACH, sides: int = SIDES
    ) -> list[ConvexRegion | None]:
        """Convex regions for the intervals between n places: one for all where that goes, else one for each.

        Args:
            path: places at the ends of the intervals, (n, 2) with n ≥ 2, m.
            headings: direction of the window in each interval, (n − 1,), rad.
            reach: as in `box`.
            sides: as in `box`.

        Returns:
            n − 1 regions; None for an interval that none covers.
        """
        whole = self.box(path, float(headings[0]), reach, sides)
        if whole is not None:
            return [whole] * (len(path) - 1)
        return [self.box(path[k : k + 2], float(heading), reach, sides) for k, heading in enumerate(headings)]

    def local_model(self, ref: Array, heading: float = 0.0) -> LocalModel:
        """The surface of the lowest rim point about a place, from its own side of all edges.

        Exactly the plane where all around lies in one plane, else moving least squares.

        Args:
            ref: place, (2,), m; should be rollable.
            heading: turns the pattern of samples, rad.
        """
        place = np.asarray(ref, dtype=float)
        points = place + pattern(heading, self.sigma)
        used = self._same_side(place, points)
        touch = self.surface.touch(points[used])
        known = ~np.isnan(touch.height)
        if not known.any():
            return LocalModel.plane(place, float("nan"), np.full(2, np.nan))
        numbers = np.unique(np.where(touch.face, touch.plane, -1)[known])
        if numbers[0] >= 0:
            planes = [self.terrain.planes[number] for number in numbers]
            if all(planes[0].coplanar(plane) for plane in planes):
                lifted = self.surface.radius * (np.sqrt(1.0 + planes[0].slope @ planes[0].slope) - 1.0)
                return LocalModel.plane(place, float(planes[0].z(place) + lifted), planes[0].slope)
        return fit(place, points[used][known], touch.height[known], self.sigma)


@dataclass(frozen=True, eq=False)
class PlanarRegions(Regions):
    """Regions of ground made of planes alone: exact."""

    def label(self, points: Array) -> NDArray[np.intp]:
        plane = self._plane(points)
        labels = np.where(plane >= 0, self._components[plane], -1)
        return np.where(_clear(self.obstacles, points, labels), labels, -1)

    def rollable(self, points: Array) -> NDArray[np.bool_]:
        plane = self._plane(points)
        labels = np.where(plane >= 0, self._components[plane], -1)
        return np.asarray((labels >= 0) & _clear(self._edges, points, labels))

    @cached_property
    def obstacles(self) -> Obstacles:
        kept = replace(self._edges, clearance=self._edges.clearance + self.margin)
        return kept if self.rolls else kept.together(self._kinks)

    @property
    def sigma(self) -> float:
        return SIGMA

    def _same_side(self, ref: Array, points: Array) -> NDArray[np.bool_]:
        wall = self._edges
        used = self.rollable(points)
        if len(wall.begin):
            used &= ~_crosses(ref, points, wall)
        return used

    def _plane(self, points: Array) -> NDArray[np.intp]:
        """Number of the plane at each point."""
        result = np.full(len(points), -1, dtype=np.intp)
        for number, index in self.terrain.seen.under(points):
            result[index] = number
        return result

    @cached_property
    def _standable(self) -> NDArray[np.bool_]:
        return np.array(
            [np.linalg.norm(plane.slope) <= FRICTION_SHARE * plane.friction for plane in self.terrain.planes]
        )

    @cached_property
    def _borders(self) -> tuple[Border, ...]:
        return tuple(borders(self.terrain.planes))

    @cached_property
    def _components(self) -> NDArray[np.intp]:
        return components(self.terrain.planes, self._borders, self._standable, kinks_divide=not self.rolls)

    @cached_property
    def _edges(self) -> Obstacles:
        return hard_edges(self.terrain, self._borders, self._components, self.surface.radius)

    @cached_property
    def _kinks(self) -> Obstacles:
        return hard_edges(self.terrain, self._borders, self._components, self.surface.radius, kinks=True)


@dataclass(frozen=True, eq=False)
class RasterRegions(Regions):
    """Regions of ground with a map: cells of the grid on which the map was dilated."""

    def label(self, points: Array) -> NDArray[np.intp]:
        """As the cells around say, and as far from obstacles as `grow` asks."""
        labels = self._around(self._labels, points)
        if self._rim is not None:
            free = np.flatnonzero(labels >= 0)
            labels[free[self._rim.query(points[free])[0] < self._kept - ROUNDING]] = -1
        return labels

    def rollable(self, points: Array) -> NDArray[np.bool_]:
        return self._lookup(self._rollable, points, 0)

    @cached_property
    def _rim(self) -> cKDTree | None:
        """The obstacles, to ask for the nearest one; None if there are none."""
        places = self.obstacles.begin
        return cKDTree(places) if len(places) else None

    @cached_property
    def obstacles(self) -> Obstacles:
        """Where what is rollable ends, between nodes; beyond the map lies what is not known."""
        places = self._borders
        both = np.zeros_like(places)
        every = np.full(len(places), EVERY, dtype=np.intp)
        return Obstacles(places, places, both, np.full(len(places), self._kept), every)

    @property
    def rollable_cells(self) -> tuple[HeightMap, NDArray[np.bool_], NDArray[np.intp]]:
        """The grid, which of its cells are rollable, and the labels of those that keep the margin."""
        return self._grid, self._rollable, self._labels

    @property
    def sigma(self) -> float:
        raster = self.terrain.map
        return SIGMA if raster is None else max(SIGMA, SIGMA_CELLS * raster.resolution)

    def _same_side(self, ref: Array, points: Array) -> NDArray[np.bool_]:
        """Those reached from `ref` over rollable cells within the pattern itself, not around an edge."""
        place = self._cells(np.vstack([ref[None], points]))
        low, high = place.min(axis=0) - 1, place.max(axis=0) + 1
        low, high = np.maximum(low, 0), np.minimum(high, np.array(self._rollable.shape) - 1)
        cells = self._inside if self._inside[tuple(place[0].clip(0, high))] else self._rollable
        labels, _ = ndimage.label(cells[low[0] : high[0] + 1, low[1] : high[1] + 1])
        inside = np.clip(place - low, 0, np.array(labels.shape) - 1)
        found = labels[inside[:, 0], inside[:, 1]]
        return np.asarray((found[1:] == found[0]) & (found[0] > 0) & self.rollable(points))

    @property
    def _kept(self) -> float:
        """Distance from borders, m: an edge taken for the middle of its cell may be anywhere in it.

        Between the values of a map that is coarser than the grid a riser is a slope, whose foot says less.
        """
        raster = self.terrain.map
        coarser = 0.0 if raster is None else raster.resolution - self._grid.resolution
        return self.margin + 0.5 * self._grid.resolution + COARSER * coarser

    @property
    def _grid(self) -> HeightMap:
        grid = self.surface.grid
        assert grid is not None, "RasterRegions are for ground with a map"
        return grid

    def _cells(self, points: Array) -> NDArray[np.intp]:
        place = np.round(self._grid.to_local(points) / self._grid.resolution)
        return place.astype(np.intp)

    @cached_property
    def _across(self) -> dict[tuple[int, int], Array]:
        """Of each node beside a jump, the neighbour beyond the largest one."""
        cells = np.argwhere(self._jumps)
        around = cells[:, None] + np.array([(1, 0), (-1, 0), (0, 1), (0, -1)])
        inside = np.clip(around, 0, np.array(self._raw.shape) - 1)
        jump = np.abs(self._raw[inside[..., 0], inside[..., 1]] - self._raw[tuple(cells.T)][:, None])
        best = inside[np.arange(len(cells)), np.nan_to_num(jump).argmax(axis=1)]
        return {(int(i), int(j)): far for (i, j), far in zip(cells, best, strict=True)}

    @property
    def _as_fine_as_the_map(self) -> bool:
        raster = self.terrain.map
        return raster is not None and raster.resolution < self._grid.resolution * 1.01

    def _touching(self, inner: Array, outer: Array) -> Array:
        """From which part (n,) of the way between nodes (n, 2) on a wheel touches what it cannot roll over.

        Half of it where it does at neither end, or at both: then the outer node is bad for another reason.
        """
        raw, radius = self.surface.raw_grid, self.surface.radius
        half = np.full(len(inner), 0.5)
        if raw is None or radius == 0.0 or not len(inner):
            return half

        def touches(share: Array, which: NDArray[np.intp]) -> NDArray[np.bool_]:
            places = raw.to_world(
                raw.resolution * (inner[which] + share[:, None] * (outer[which] - inner[which]))
            )
            height, away = ball_touch(raw, radius, places)
            steepest = FRICTION_SHARE * self.terrain.friction_at(*places.T)
            far = radius * steepest / np.sqrt(1.0 + steepest**2) + raw.resolution
            return np.asarray((height - raw.height(places) > _lift_max(radius, steepest)) | (away > far))

        all_of_them = np.arange(len(inner))
        begins = ~touches(np.zeros(len(inner)), all_of_them) & touches(np.ones(len(inner)), all_of_them)
        which = np.flatnonzero(begins)
        low, high = np.zeros(len(which)), np.ones(len(which))
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            bad = touches(middle, which)
            low, high = np.where(bad, low, middle), np.where(bad, middle, high)
        half[which] = low
        return half

    def _around(self, labels: NDArray[np.intp], points: Array) -> NDArray[np.intp]:
        """The largest label of the four nodes around each point, −1 off the map."""
        place = self._grid.to_local(np.nan_to_num(points, nan=1e9, posinf=1e9, neginf=-1e9))
        first = np.floor(place / self._grid.resolution + ROUNDING).astype(np.intp)
        padded = np.pad(labels, 1, constant_values=-1)
        inside = np.asarray(((first >= -1) & (first < labels.shape)).all(axis=1))
        i, j = np.where(inside[:, None], first + 1, 0).T
        four = np.max([padded[i + a, j + b] for a in (0, 1) for b in (0, 1)], axis=0)
        return np.where(inside, four, -1)

    def _lookup(self, values: NDArray[Scalar], points: Array, outside: int) -> NDArray[Scalar]:
        cells = self._cells(np.nan_to_num(points, nan=1e9, posinf=1e9, neginf=-1e9))
        inside = ((cells >= 0) & (cells < values.shape)).all(axis=1)
        result = np.full(len(points), outside, dtype=values.dtype)
        result[inside] = values[cells[inside, 0], cells[inside, 1]]
        return result

    @cached_property
    def _rollable(self) -> NDArray[np.bool_]:
        """Known, not too steep, and nothing lifts the wheel off what is below it.

        On a slope a wheel stands R (√(1 + g²) − 1) over the ground below its lowest point. What it stands
        higher comes from something else that it touches: the edge of a step, the far side of a gap.
        """
        grid, raw, total, mu = self._grid, self._raw, self._total, self._friction
        lifted = total - raw > _lift_max(self.surface.radius, FRICTION_SHARE * mu)
        steepness = _steepness(np.where(lifted, np.nan, total), grid.resolution)
        lift = total - raw - self.surface.radius * (np.sqrt(1.0 + steepness**2) - 1.0)
        with np.errstate(invalid="ignore"):
            good = (steepness <= FRICTION_SHARE * mu) & (lift <= LIFT_MAX) & ~lifted
        return np.asarray(good & ~self._jumps)

    @cached_property
    def _raw(self) -> Array:
        """Heights of the ground at the nodes, m."""
        return self.terrain.height(*self._nodes.T).reshape(self._grid.values.shape)

    @cached_property
    def _total(self) -> Array:
        """Heights of the wheel's surface at the nodes, parts on the map included, m."""
        return self.surface.touch(self._nodes).height.reshape(self._grid.values.shape)

    @cached_property
    def _friction(self) -> Array:
        return self.terrain.friction_at(*self._nodes.T).reshape(self._grid.values.shape)

    @property
    def _nodes(self) -> Array:
        return self._grid.nodes().reshape(-1, 2)

    @cached_property
    def _jumps(self) -> NDArray[np.bool_]:
        """Nodes beside which the ground rises or falls by more than any slope that can be stood on."""
        resolution = self._grid.resolution
        with np.errstate(invalid="ignore"):
            rise = _steepness(self._raw, resolution, largest=True) * resolution
            return np.asarray(rise > LIFT_MAX + FRICTION_SHARE * self._friction * resolution)

    @cached_property
    def _borders(self) -> Array:
        """Places between a rollable node and one beside it that is not, where what is rollable ends, (n, 2).

        A jump ends it in the middle of the jump, where the map has no coarser values than the grid: else the
        jump is a slope that begins at once. The touch of a wheel with something beyond ends it where that
        begins; what else there is, as a slope, half way to the node.
        """
        good = np.pad(self._rollable, 1)
        pairs = []
        for step in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            beside = np.roll(good, (-step[0], -step[1]), axis=(0, 1))
            first = np.argwhere(good & ~beside) - 1
            pairs.append(np.column_stack([first, first + step]))
        cells = np.concatenate(pairs)
        inner, outer = cells[:, :2], cells[:, 2:]
        share = self._touching(inner.astype(np.float64), outer.astype(np.float64))
        places = inner + share[:, None] * (outer - inner)
        inside = ((outer >= 0) & (outer < self._rollable.shape)).all(axis=1)
        for k in np.flatnonzero(inside) if self._as_fine_as_the_map else ():
            across = self._across.get(tuple(outer[k]))
            if across is not None and share[k] == 0.5:
                places[k] = 0.5 * (outer[k] + across)
        return self._grid.to_world(self._grid.resolution * np.unique(np.round(places, 6), axis=0))

    @cached_property
    def _inside(self) -> NDArray[np.bool_]:
        """Rollable cells between rollable ones: at the rim an edge has lifted the wheel a little already."""
        return np.asarray(ndimage.binary_erosion(self._rollable, structure=np.ones((3, 3))))

    @cached_property
    def _labels(self) -> NDArray[np.intp]:
        """Components of what keeps the margin; beyond the border of the map lies what is not known."""
        padded = np.pad(self._rollable, 1)
        distance = self._grid.resolution * ndimage.distance_transform_edt(padded)[1:-1, 1:-1]
        kept = distance > 0.0
        if self._rim is not None:  # those near borders are looked at one by one
            near = np.argwhere(kept & (distance < self._kept + self._grid.resolution))
            places = self._grid.to_world(self._grid.resolution * near.astype(np.float64))
            kept[tuple(near.T)] = self._rim.query(places)[0] >= self._kept - ROUNDING
        labels, _ = ndimage.label(kept, structure=np.ones((3, 3)))
        return np.asarray(labels - 1, dtype=np.intp)


def regions_of(
    terrain: Terrain,
    radius: float,
    margin: float = MARGIN,
    window: Window | None = None,
    rolls: bool = True,
) -> Regions:
    """The regions of a wheel, or of a point foot, on some ground.

    Args:
        terrain: the ground.
        radius: of the wheel, or of the ball of a point foot, m.
        margin: distance from edges, m.
        window: smallest and largest (x, y) of the part of a map that is needed, m.
        rolls: whether the foot does. One that does not has each foothold in one plane.
    """
    surface = WheelSurface(terrain, radius, window)
    kind = PlanarRegions if surface.grid is None else RasterRegions
    return kind(surface, margin, rolls)


def regions_about(
    terrain: Terrain,
    radii: Sequence[float],
    places: Array,
    around: float,
    rolls: Sequence[bool] | None = None,
) -> list[Regions]:
    """The regions of several feet about some places; the last ones are kept, for they are asked for again.

    Args:
        terrain: the ground.
        radii: of the feet, m.
        places: what must be seen, (n, 2), m.
        around: how far about them a map is looked at, m; planes are reckoned with as a whole.
        rolls: which feet roll; all if None.
    """
    low, high = places.min(axis=0) - around, places.max(axis=0) + around
    window = (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))
    seen = None if terrain.planar else window
    return [
        _kept_regions(terrain, radius, seen, roll)
        for radius, roll in zip(radii, rolls or [True] * len(radii), strict=True)
    ]


@lru_cache(maxsize=8)
def _kept_regions(terrain: Terrain, radius: float, window: Window | None, rolls: bool) -> Regions:
    return regions_of(terrain, radius, window=window, rolls=rolls)


def arcs(labels: Sequence[int]) -> list[tuple[int, int, int]]:
    """Runs of equal labels along a track that are in a region: (label, first, last) place of each."""
    result: list[tuple[int, int, int]] = []
    for k, label in enumerate(labels):
        if label < 0:
            continue
        if result and result[-1][0] == label and result[-1][2] == k - 1:
            result[-1] = (label, result[-1][1], k)
        else:
            result.append((label, k, k))
    return result


def _clear(obstacles: Obstacles, points: Array, labels: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Which points, each in a region, keep all clearances that count there."""
    result = np.ones(len(points), dtype=bool)
    o = obstacles
    places = Places(points)
    low = np.minimum(o.begin, o.end) - o.clearance[:, None]
    high = np.maximum(o.begin, o.end) + o.clearance[:, None]
    for k in np.flatnonzero(((low <= places.high) & (high >= places.low)).all(axis=1)):
        index = places.within(low[k], high[k])
        index = index[labels[index] == o.region[k]]
        near = points[index]
        nearest = nearest_on_segments(near, o.begin[k, None], o.end[k, None])[:, 0]
        too_near = np.linalg.norm(near - nearest, axis=1) < o.clearance[k] - 1e-9
        result[index[too_near & ((near - o.begin[k]) @ o.side[k] >= -1e-9)]] = False
    return result


def _crosses(ref: Array, points: Array, wall: Obstacles) -> NDArray[np.bool_]:
    """Which straight ways from `ref` to points cross a segment."""
    a, b = wall.begin[None], wall.end[None]
    c, d = ref[None, None], points[:, None]

    def side(p: Array, q: Array, r: Array) -> Array:
        return np.asarray(
            (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1])
            - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])
        )

    crossing = (side(a, b, c) * side(a, b, d) <= 0.0) & (side(c, d, a) * side(c, d, b) <= 0.0)
    return np.asarray(crossing.any(axis=1))


def _lift_max(radius: float, steepest: Array) -> Array:
    """So far a wheel stands at most over ground that it can roll on, m."""
    return np.asarray(LIFT_MAX + radius * (np.sqrt(1.0 + steepest**2) - 1.0))


def _steepness(heights: Array, resolution: float, largest: bool = False) -> Array:
    """Rise over run at each node, by central differences; or the largest to any of its four neighbours.

    Where one neighbour is not known, the other one alone counts.
    """
    padded = np.pad(heights, 1, mode="edge")
    forward_x = (padded[2:, 1:-1] - heights) / resolution
    backward_x = (heights - padded[:-2, 1:-1]) / resolution
    forward_y = (padded[1:-1, 2:] - heights) / resolution
    backward_y = (heights - padded[1:-1, :-2]) / resolution
    if largest:
        return np.asarray(np.abs([forward_x, backward_x, forward_y, backward_y]).max(axis=0))
    both = []
    for a, b in ((forward_x, backward_x), (forward_y, backward_y)):
        a, b = np.where(np.isnan(a), b, a), np.where(np.isnan(b), a, b)
        both.append(0.5 * (a + b))
    return np.asarray(np.hypot(*both))
