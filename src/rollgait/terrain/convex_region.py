"""Convex pieces of free ground: half-planes around a path, between the things that are in the way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.terrain.polygons import Array, clip, convex_hull, nearest_pairs

SIDES: Final = 8
"""Most half-planes of a region: four sides of its window and four cuts. A problem wants a fixed number."""
REACH: Final = 1.0
"""So far a region goes beyond its path at most, m: further than a foot gets in a stance."""
TOUCHING: Final = 1.0e-9
"""A distance that counts as none, m."""
EVERY: Final = -1
"""Stands for every region."""
BEHIND: Final = 1.0e-7
"""By so much what a line leaves out may reach over it, m: the line's direction comes from centimetres."""

ROW: Final = 0.8
"""Least cosine between the shortest way to a point and the direction across its row."""
ROOM_KEPT: Final = 0.8
"""Share of the room about the path that a cut along a row leaves at least, of what one across the shortest
way leaves."""
ROW_TRIED: Final = 16
"""So many rows through a point are tried."""


@dataclass(frozen=True, eq=False)
class Obstacles:
    """Segments from which the lowest point of a wheel keeps its distance. A segment may be a point.

    What is forbidden by one is convex: the places on its side that are nearer than its clearance.

    Attributes:
        begin: first ends, (n, 2), m.
        end: second ends, (n, 2), m.
        side: unit vectors to the side for which a segment counts, (n, 2); zeros if for both. An edge between
            two levels has an entry for each: above it one keeps another distance than below.
        clearance: distances to be kept, (n,), m.
        region: number of the region for which each counts, (n,); `EVERY` if for all. The floor of a pothole
            has its walls, and they end where it ends.
    """

    begin: Array
    end: Array
    side: Array
    clearance: Array
    region: NDArray[np.intp]

    def together(self, other: Obstacles) -> Obstacles:
        """These and others."""
        names = ("begin", "end", "side", "clearance", "region")
        return Obstacles(*(np.concatenate([getattr(self, n), getattr(other, n)]) for n in names))

    def of(self, region: int) -> Obstacles:
        """Those that count for a region."""
        kept = (self.region == region) | (self.region == EVERY)
        return self._kept(kept, self.begin, self.end)

    def _kept(self, kept: NDArray[np.bool_], begin: Array, end: Array) -> Obstacles:
        return Obstacles(begin[kept], end[kept], self.side[kept], self.clearance[kept], self.region[kept])

    def near(self, centre: Array, distance: float) -> Obstacles:
        """The parts of them that are, with their clearance, within a distance (m) of a place (2,).

        An edge without end is cut short: over a kilometre the direction of a line across it loses its digits.
        """
        along = self.end - self.begin
        length = np.linalg.norm(along, axis=1)
        along = along / np.where(length > 0.0, length, 1.0)[:, None]
        relative = centre - self.begin
        middle = np.einsum("nk,nk->n", relative, along)
        beside = np.linalg.norm(relative - middle[:, None] * along, axis=1)
        chord = np.sqrt(np.maximum((distance + self.clearance) ** 2 - beside**2, 0.0))
        first, last = np.maximum(middle - chord, 0.0), np.minimum(middle + chord, length)
        kept = (first <= last) & (beside <= distance + self.clearance)
        begin = self.begin + first[:, None] * along
        end = self.begin + last[:, None] * along
        return self._kept(np.asarray(kept), begin, end)

    def begins(self, normal: Array) -> Array:
        """Smallest n · p of the places p that each forbids, (n,), for a unit vector n (2,)."""
        beyond = np.clip(self.side @ normal, 0.0, 1.0)  # 1: what is forbidden lies beyond the segment alone
        share = np.sqrt(1.0 - beyond**2)
        return np.asarray(np.minimum(self.begin @ normal, self.end @ normal) - share * self.clearance)

    def is_point(self, k: int) -> bool:
        """Whether one is a point."""
        return bool((self.begin[k] == self.end[k]).all())

    def behind(self, normal: Array, offset: float) -> NDArray[np.bool_]:
        """Which forbid nothing on the near side of the line n · p = offset."""
        return np.asarray(self.begins(normal) >= offset - BEHIND)

    def ways(self, hull: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Shortest ways from a convex hull: unit vectors (n, 2), lengths (n,) in m, and which count.

        Those count on whose side a part of the hull lies.
        """
        on_hull, on_segment = nearest_pairs(hull, self.begin, self.end)
        way = on_segment - on_hull
        distance = np.linalg.norm(way, axis=1)
        counts = np.einsum("nk,hnk->hn", self.side, hull[:, None] - self.begin[None]).max(axis=0) >= -TOUCHING
        return way / np.where(distance > 0.0, distance, 1.0)[:, None], distance, np.asarray(counts)


@dataclass(frozen=True, eq=False)
class ConvexRegion:
    """The places p with A p ≤ b.

    Attributes:
        A: outward unit normals, (n, 2).
        b: offsets, (n,), m.
    """

    A: Array
    b: Array

    def margin(self, points: Array) -> Array:
        """How far points (…, 2) are inside the nearest side, m; negative outside."""
        return np.asarray((self.b - points @ self.A.T).min(axis=-1))

    def contains(self, points: Array) -> NDArray[np.bool_]:
        """Which points (…, 2) lie in it."""
        return np.asarray(self.margin(points) >= -TOUCHING)

    @property
    def vertices(self) -> Array:
        """Its corners, counter-clockwise, (m, 2), m."""
        far = np.abs(self.b).max() + 10.0 * REACH
        polygon: Array | None = far * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        for normal, offset in zip(self.A, self.b, strict=True):
            if polygon is not None:
                polygon = clip(polygon, offset * normal, -normal)
        return np.zeros((0, 2)) if polygon is None else polygon

    def padded(self, count: int) -> tuple[Array, Array]:
        """A and b with rows that always hold (0 · p ≤ 1) up to `count` rows."""
        missing = count - len(self.b)
        return np.vstack([self.A, np.zeros((missing, 2))]), np.append(self.b, np.ones(missing))


def grow(
    obstacles: Obstacles, path: Array, heading: float = 0.0, reach: float = REACH, sides: int = SIDES
) -> ConvexRegion | None:
    """A convex region about a path that keeps all clearances; None if the hull of the path itself does not.

    The nearest obstacle is cut off first, by the line across the shortest way to it; what lies behind that
    line needs no cut of its own. When the cuts are used up, sides of the window move in instead.

    Args:
        obstacles: what to keep away from.
        path: places, (n, 2), m.
        heading: direction of the window, rad.
        reach: how far the window goes beyond the path, m.
        sides: most half-planes, at least 4.
    """
    hull = convex_hull(path)
    window_A = _window_normals(heading)
    window_b = (hull @ window_A.T).max(axis=0) + reach
    corners = ConvexRegion(window_A, window_b).vertices
    centre = corners.mean(axis=0)
    around = obstacles.near(centre, float(np.linalg.norm(corners - centre, axis=1).max()))
    way, distance, counts = around.ways(hull)
    if (counts & (distance < around.clearance - TOUCHING)).any():
        return None
    normals: list[Array] = []
    offsets: list[float] = []
    left = ~_behind_any(around, window_A, window_b)
    for k in np.lexsort([np.where(counts, distance - around.clearance, distance), ~counts]):
        if not left[k] or len(normals) >= sides - 4:
            continue
        # Across the shortest way; what is forbidden beyond an edge alone, also along that edge.
        most = -1
        for normal in (way[k], around.side[k], *_along_a_row(around, left, k, way[k])):
            begins = around.begins(normal)
            offset = float(begins[k])
            room = offset - (hull @ normal).max()
            if not normal.any() or room < -TOUCHING:
                continue
            behind = begins >= offset - BEHIND
            if most < 0:
                normals.append(normal)
                offsets.append(offset)
                least = ROOM_KEPT * room
            elif np.count_nonzero(left & behind) > most and room >= least:
                normals[-1], offsets[-1] = normal, offset
            else:
                continue
            most = int(np.count_nonzero(left & behind))
            best = behind
            if not around.is_point(k):
                break
        if most >= 0:
            left &= ~best
    for k in np.flatnonzero(left):
        if _behind_any(around, window_A, window_b)[k]:
            continue
        if not _move_side(window_A, window_b, around, int(k), hull):
            return None
    return ConvexRegion(np.vstack([window_A, *normals]), np.append(window_b, offsets))


def _along_a_row(around: Obstacles, left: NDArray[np.bool_], k: int, normal: Array) -> Array:
    """Directions across lines through the point k and others of its row, (n, 2), near to a given one.

    The points of an edge lie in a row: the line across the shortest way to one of them is hardly ever that of
    the row, and would leave the others to cuts that slant.
    """
    if not around.is_point(k):
        return np.zeros((0, 2))
    over = left & (around.begins(normal) < around.begins(normal)[k] - BEHIND)
    way = around.begin[over] - around.begin[k]
    across = np.column_stack([-way[:, 1], way[:, 0]])
    across *= np.sign(across @ normal)[:, None]
    length = np.linalg.norm(across, axis=1)
    across = across[length > TOUCHING] / length[length > TOUCHING, None]
    turn = across @ np.array([-normal[1], normal[0]])
    near = np.flatnonzero(across @ normal > ROW)
    chosen = near[np.argsort(turn[near])]
    if len(chosen) > ROW_TRIED:
        chosen = chosen[np.linspace(0, len(chosen) - 1, ROW_TRIED).round().astype(int)]
    return np.asarray(across[chosen])


def _window_normals(heading: float) -> Array:
    c, s = np.cos(heading), np.sin(heading)
    return np.array([[c, s], [-s, c], [-c, -s], [s, -c]])


def _behind_any(obstacles: Obstacles, A: Array, b: Array) -> NDArray[np.bool_]:
    behind = [obstacles.behind(n, offset) for n, offset in zip(A, b, strict=True)]
    return np.asarray(np.logical_or.reduce(behind))


def _move_side(A: Array, b: Array, obstacles: Obstacles, k: int, hull: Array) -> bool:
    """Moves that side of the window in (in place) that must give way least to leave out an obstacle."""
    limit = np.array([obstacles.begins(normal)[k] for normal in A])
    room = limit - (hull @ A.T).max(axis=0)
    best = int(np.argmax(room))
    if room[best] < -TOUCHING:
        return False
    b[best] = min(b[best], limit[best])
    return True
