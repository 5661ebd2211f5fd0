"""Ground as triangles: what pictures, films, exports and physics draw of it.

Planes are exact polygons with vertical walls where they jump; a map is a grid of triangles, as coarse as a
bound says. What is not known stays open.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.terrain.edges import borders, cuts
from rollgait.terrain.facet import Facet, bands
from rollgait.terrain.height_map import HeightMap
from rollgait.terrain.places import Places
from rollgait.terrain.polygons import Array, clip, contains, edges, inward, subtract
from rollgait.terrain.relief import face_colours
from rollgait.terrain.terrain import Terrain

MESH_CELLS: Final = 20_000
"""Most cells of a map that become triangles: what a browser loads at once, and more than a screen shows."""
AROUND: Final = 1.0
"""Ground shown around a motion, m."""
BANDS: Final = 16
"""Strips of an inclined plane: each has one colour."""
BESIDE: Final = 1.0e-6
"""So far beside the edge of a part one asks what is there, m."""


@dataclass(frozen=True, eq=False)
class GroundMesh:
    """Triangles of the ground.

    Attributes:
        vertices: (n, 3), world, m.
        faces: numbers of vertices, counter-clockwise from outside, (m, 3).
        colours: of the faces by their height and slope, red, green and blue, (m, 3).
    """

    vertices: Array
    faces: NDArray[np.uint32]
    colours: NDArray[np.uint8]

    @property
    def corners(self) -> Array:
        """Corners of the triangles, (m, 3, 3), m."""
        return np.asarray(self.vertices[self.faces])


def window_around(points: ArrayLike, margin: float = AROUND) -> tuple[Array, Array]:
    """Smallest and largest (x, y) of a rectangle of whole metres around points (…, 2 or 3), with a margin."""
    places = np.asarray(points, dtype=float)[..., :2].reshape(-1, 2)
    return np.floor(places.min(axis=0) - margin), np.ceil(places.max(axis=0) + margin)


def mesh_of(terrain: Terrain, low: ArrayLike, high: ArrayLike, cells: int = MESH_CELLS) -> GroundMesh:
    """The ground over a rectangle.

    Args:
        terrain: the ground.
        low: smallest x and y, (2,), m.
        high: largest x and y, (2,), m. Cells of a map that it cuts are whole.
        cells: most cells of a map; where there are more, every second or third node counts, and so on.
    """
    window = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    planes = within(terrain.planes, *window)
    grid = None if terrain.map is None else _Grid.of(terrain.map, terrain.level, window, cells)
    strips = [strip for plane in planes for strip in bands(plane, BANDS)]
    triangles = [*_tops(strips), *_walls_between(planes)]
    if grid is not None:
        triangles += [*_uncovered(grid, planes), *_walls_to(grid, planes)]
    corners = np.concatenate([np.zeros((0, 3, 3)), *triangles])
    vertices, faces = np.unique(corners.reshape(-1, 3).round(9), axis=0, return_inverse=True)
    faces = faces.reshape(-1, 3)
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    level = terrain.level if terrain.planar else None
    return GroundMesh(vertices, faces.astype(np.uint32), face_colours(vertices[faces], level))


def within(planes: Sequence[Facet], low: Array, high: Array) -> tuple[Facet, ...]:
    """What lies of planes in a rectangle from `low` to `high`, (2,) each, m."""
    cut = [(plane, _cut(plane.polygon, (low, high))) for plane in planes]
    return tuple(replace(plane, polygon=polygon) for plane, polygon in cut if polygon is not None)


def _cut(polygon: Array, window: tuple[Array, Array]) -> Array | None:
    """The part of a polygon within a rectangle."""
    result: Array | None = polygon
    for axis in np.eye(2):
        for point, normal in ((window[0], axis), (window[1], -axis)):
            result = None if result is None else clip(result, point, normal)
    return result


# -- planes --


def _tops(planes: Sequence[Facet]) -> Iterator[Array]:
    """Triangles of the planes, about their middles; edges are cut where others begin: no crack shows."""
    corners = Places(np.concatenate([np.zeros((0, 2)), *(plane.polygon for plane in planes)]))
    for plane in planes:
        begins, ends = edges(plane.polygon)
        ring = np.concatenate([cuts(a, b, corners)[:-1] for a, b in zip(begins, ends, strict=True)])
        yield _fan(ring, plane)


def _fan(ring: Array, plane: Facet) -> Array:
    """Triangles (n, 3, 3) of a convex polygon (n, 2) on a plane."""
    points = np.vstack([ring, ring.mean(axis=0)])
    points = np.column_stack([points, plane.z(points)])
    n = np.arange(len(ring))
    return np.asarray(points[np.stack([n, np.roll(n, -1), np.full_like(n, len(ring))], axis=1)])


def _walls_between(planes: Sequence[Facet]) -> Iterator[Array]:
    """Walls where a plane stands above its neighbour."""
    for border in borders(planes):
        both = np.array([border.begin, border.end])
        own = planes[border.own].z(both)
        yield _wall(both, own, own + border.jump)


def _wall(ends: Array, own: Array, other: Array) -> Array:
    """Triangles (…, 3, 3) of the wall below the edge of something, where it is higher than what is beside it.

    Args:
        ends: of the edge, (2, 2), m; what it belongs to lies on its left.
        own: heights at the ends, (2,), m.
        other: heights beside it, (2,), m.
    """
    over = own - other
    if np.isnan(over).any() or over.max() <= 0.0:
        return np.zeros((0, 3, 3))
    share = np.array([0.0, 1.0])
    if over.min() < 0.0:
        share[over.argmin()] = over[0] / (over[0] - over[1])
    places = ends[0] + share[:, None] * (ends[1] - ends[0])
    top, bottom = (z[0] + share * (z[1] - z[0]) for z in (own, other))
    a, b = np.column_stack([places, bottom])
    d, c = np.column_stack([places, top])
    return np.array([[a, b, c], [a, c, d]])


# -- maps --


@dataclass(frozen=True, eq=False)
class _Grid:
    """Nodes of a map that are drawn.

    Attributes:
        raster: the map.
        at: numbers of the rows and of the columns that are taken.
        z: heights there, m.
    """

    raster: HeightMap
    at: tuple[NDArray[np.intp], NDArray[np.intp]]
    z: Array

    @classmethod
    def of(cls, raster: HeightMap, level: float, window: tuple[Array, Array], cells: int) -> _Grid | None:
        """The nodes over a rectangle, `cells` at most; None if there are none."""
        (x0, y0), (x1, y1) = window
        place = raster.to_local(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])) / raster.resolution
        last = np.array(raster.values.shape) - 1
        first = np.clip(np.floor(place.min(axis=0) + 1e-9), 0, last).astype(int)
        end = np.clip(np.ceil(place.max(axis=0) - 1e-9), 0, last).astype(int)
        if (end <= first).any():
            return None
        step = int(np.ceil(np.sqrt(np.prod((end - first).astype(float)) / cells)))
        i, j = (np.unique(np.append(np.arange(a, b, step), b)) for a, b in zip(first, end, strict=True))
        return cls(raster, (i, j), level + raster.values[np.ix_(i, j)])

    def triangles(self) -> Array:
        """Two for each cell of which all corners are known, (n, 3, 3)."""
        i, j = np.meshgrid(*(k.astype(float) for k in self.at), indexing="ij")
        xy = self.raster.to_world(self.raster.resolution * np.stack([i, j], axis=-1))
        node = np.concatenate([xy, self.z[..., None]], axis=-1)
        a, b, c, d = node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]
        both = np.stack([np.stack([a, b, c], axis=-2), np.stack([a, c, d], axis=-2)], axis=-3)
        known = ~np.isnan(both[..., 2]).any(axis=(-1, -2))
        return np.asarray(both[known].reshape(-1, 3, 3))

    def height(self, points: Array) -> Array:
        """Height of the triangles at points (n, 2), m; NaN where there is none."""
        place = self.raster.to_local(points) / self.raster.resolution
        cell, share = [], []
        for k, at in enumerate(self.at):
            c = np.clip(np.searchsorted(at, place[:, k], side="right") - 1, 0, len(at) - 2)
            cell.append(c)
            share.append((place[:, k] - at[c]) / (at[c + 1] - at[c]))
        (i, j), (u, v) = cell, share
        z00, z10, z11, z01 = self.z[i, j], self.z[i + 1, j], self.z[i + 1, j + 1], self.z[i, j + 1]
        below = z00 + u * (z10 - z00) + v * (z11 - z10)
        above = z00 + u * (z11 - z01) + v * (z01 - z00)
        outside = (np.minimum(u, v) < -1e-6) | (np.maximum(u, v) > 1.0 + 1e-6)
        return np.where(outside, np.nan, np.where(v <= u, below, above))

    def stops(self, begin: Array, end: Array) -> Array:
        """Where a way crosses sides of the triangles, as shares of it with both its ends."""
        a, b = self.raster.to_local(np.array([begin, end])) / self.raster.resolution
        found = [np.array([0.0, 1.0])]
        for k, at in enumerate(self.at):
            if abs(b[k] - a[k]) > 1e-9:
                found.append((at - a[k]) / (b[k] - a[k]))
        every = np.concatenate(found)
        return np.unique(every[(every >= 0.0) & (every <= 1.0)].round(9))


def _uncovered(grid: _Grid, planes: Sequence[Facet]) -> Iterator[Array]:
    """The triangles of a map where no part lies on it."""
    whole = grid.triangles()
    touched = np.zeros(len(whole), dtype=bool)
    inside = np.zeros(len(whole), dtype=bool)
    for plane in planes:
        begin, end = edges(plane.polygon)
        depth = np.einsum("ek,ntek->nte", inward(begin, end), whole[:, :, None, :2] - begin)
        inside |= (depth >= -BESIDE).all(axis=(1, 2))
        touched |= ~(depth <= BESIDE).all(axis=1).any(axis=1)
    yield whole[~touched]
    for triangle in whole[touched & ~inside]:
        yield from _rest(triangle, planes)


def _rest(triangle: Array, planes: Sequence[Facet]) -> Iterator[Array]:
    """What parts leave of a triangle."""
    pieces = [triangle[:, :2]]
    for plane in planes:
        pieces = [rest for piece in pieces for rest in subtract(piece, plane.polygon)]
    slope = np.linalg.solve(triangle[1:, :2] - triangle[0, :2], triangle[1:, 2] - triangle[0, 2])
    surface = Facet(triangle[:, :2], float(triangle[0, 2] - slope @ triangle[0, :2]), slope, 1.0)
    for piece in pieces:
        yield _fan(piece, surface)


def _walls_to(grid: _Grid, planes: Sequence[Facet]) -> Iterator[Array]:
    """Walls between parts and the map that they lie on."""
    for plane in planes:
        begins, ends = edges(plane.polygon)
        for begin, end, side in zip(begins, ends, inward(begins, ends), strict=True):
            places = begin + grid.stops(begin, end)[:, None] * (end - begin)
            beside = 0.5 * (places[1:] + places[:-1]) - BESIDE * side
            covered = np.zeros(len(beside), dtype=bool)
            for other in planes:
                covered |= contains(other.polygon, beside)
            for k in np.flatnonzero(~covered):
                both = places[k : k + 2]
                own, map_ = plane.z(both), grid.height(both)
                yield _wall(both, own, map_)
                yield _wall(both[::-1], map_[::-1], own[::-1])
