"""Planar pieces of ground, and which of each is seen where later ones lie over earlier ones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.terrain.places import Places
from rollgait.terrain.polygons import Array, clip, contains, subtract

FAR: Final = 1000.0
"""Half the side of the square that holds all planar ground, m: a plane "without end" ends here."""
COPLANAR: Final = 1.0e-9
"""Planes that differ by no more than this, in m at the origin and as a slope, are one."""


@dataclass(frozen=True, eq=False)
class Facet:
    """A convex piece of a plane z = height + slope · (x, y).

    Attributes:
        polygon: its vertices from above, counter-clockwise, (n, 2), m.
        height: of the plane over the origin of the world, m.
        slope: gradient of the plane, (2,).
        friction: μ.
        source: number of the part that it belongs to; −1 is the plane that all parts lie on.
    """

    polygon: Array
    height: float
    slope: Array
    friction: float
    source: int = -1

    @cached_property
    def box(self) -> tuple[Array, Array]:
        """Smallest and largest coordinates, each (2,), m."""
        return self.polygon.min(axis=0), self.polygon.max(axis=0)

    def z(self, points: Array) -> Array:
        """Height of its plane at points (…, 2), m."""
        return np.asarray(self.height + points @ self.slope)

    def contains(self, points: Array) -> NDArray[np.bool_]:
        """Which points (n, 2) it lies under or over; its border belongs to it."""
        (x0, y0), (x1, y1) = self.box[0] - 1e-6, self.box[1] + 1e-6
        x, y = points.T
        inside = np.asarray((x >= x0) & (x <= x1) & (y >= y0) & (y <= y1))
        inside[inside] = contains(self.polygon, points[inside])
        return inside

    def coplanar(self, other: Facet) -> bool:
        """Whether both lie in one plane."""
        same_slope = np.abs(self.slope - other.slope).max() <= COPLANAR
        return bool(same_slope and abs(self.height - other.height) <= COPLANAR)


def plane_through(point: Array, slope: Array) -> float:
    """Height over the origin of the plane of a slope (2,) through a point (3,), m."""
    return float(point[2] - slope @ point[:2])


def square(height: float, friction: float) -> Facet:
    """The horizontal plane that all parts lie on."""
    corners = FAR * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return Facet(corners, height, np.zeros(2), friction)


def bands(facet: Facet, count: int) -> Iterator[Facet]:
    """An inclined piece cut across its slope into strips of equal rise; a level one as it is."""
    steepness = float(np.linalg.norm(facet.slope))
    z = facet.z(facet.polygon)
    if steepness * count <= COPLANAR or count == 1:
        yield facet
        return
    uphill = facet.slope / steepness
    lowest = facet.polygon[z.argmin()]
    width = float(np.ptp(z)) / steepness / count
    for k in range(count):
        strip = clip(facet.polygon, lowest + k * width * uphill, uphill) if k else facet.polygon
        if strip is not None and k < count - 1:
            strip = clip(strip, lowest + (k + 1) * width * uphill, -uphill)
        if strip is not None:
            yield replace(facet, polygon=strip)


@dataclass(frozen=True, eq=False)
class Facets:
    """Facets in their order, and which of them may be met where: of hundreds only a few are near.

    Attributes:
        all: the facets.
    """

    all: tuple[Facet, ...]

    @cached_property
    def boxes(self) -> tuple[Array, Array]:
        """Smallest and largest coordinates of each, each (n, 2), m."""
        boxes = np.array([facet.box for facet in self.all]).reshape(-1, 2, 2)
        return boxes[:, 0], boxes[:, 1]

    def near(self, points: Array, reach: float = 0.0) -> Iterator[tuple[int, NDArray[np.intp]]]:
        """The number of each facet, in order, and which points (n, 2) lie in its box grown by `reach`, m.

        Facets with none are left out.
        """
        places, grown = Places(points), reach + 1e-6
        low, high = self.boxes
        met = ((low - grown <= places.high) & (high + grown >= places.low)).all(axis=1)
        for number in np.flatnonzero(met):
            index = places.within(low[number] - grown, high[number] + grown)
            if len(index):
                yield int(number), index

    def under(self, points: Array) -> Iterator[tuple[int, NDArray[np.intp]]]:
        """The number of each facet, in their order, and which points (n, 2) it lies under or over."""
        for number, index in self.near(points):
            inside = contains(self.all[number].polygon, points[index])
            if inside.any():
                yield number, index[inside]


def visible(facets: Sequence[Facet]) -> tuple[Facet, ...]:
    """The pieces of facets that later ones leave: they tile what the facets cover, without overlap."""
    result: list[Facet] = []
    low, high = Facets(tuple(facets)).boxes
    for k, facet in enumerate(facets):
        pieces, boxes = [facet.polygon], np.array([facet.box])
        met = ((low[k + 1 :] < high[k]) & (high[k + 1 :] > low[k])).all(axis=1)
        for later in (k + 1 + np.flatnonzero(met)).tolist():
            cut = ((boxes[:, 0] < high[later]) & (boxes[:, 1] > low[later])).all(axis=1)
            if not cut.any():
                continue
            rest = [p for i in np.flatnonzero(cut) for p in subtract(pieces[i], facets[later].polygon)]
            pieces = [piece for piece, gone in zip(pieces, cut, strict=True) if not gone] + rest
            new = np.array([(piece.min(axis=0), piece.max(axis=0)) for piece in rest]).reshape(-1, 2, 2)
            boxes = np.concatenate([boxes[~cut], new])
        result += [replace(facet, polygon=piece) for piece in pieces]
    return tuple(result)
