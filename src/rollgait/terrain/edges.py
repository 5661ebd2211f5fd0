"""Edges between planes: where ground made of parts jumps or is too steep, and how far a wheel stays away."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from rollgait.terrain.convex_region import Obstacles
from rollgait.terrain.facet import Facet, Facets
from rollgait.terrain.places import Places
from rollgait.terrain.polygons import Array, edges, inward
from rollgait.terrain.terrain import Terrain

JUMP: Final = 1.0e-3
"""A smaller difference in height is no edge, m."""
BESIDE: Final = 1.0e-6
"""So far beside an edge one asks which plane is there, m: more than rounding, less than any part."""
PIECE: Final = 0.1
"""Longest piece of an edge whose height changes along it, m: each piece has one clearance."""
PROBES: Final = 33
"""Places beyond an edge, up to a radius away, at which the ground may touch the wheel."""


@dataclass(frozen=True, eq=False)
class Border:
    """A piece of the border of a plane, with one neighbour.

    Attributes:
        begin: first end, (2,), m.
        end: second end, (2,), m.
        side: unit normal into the plane, (2,).
        own: number of the plane.
        other: number of its neighbour.
        jump: by how much the neighbour is higher at both ends, (2,), m.
    """

    begin: Array
    end: Array
    side: Array
    own: int
    other: int
    jump: Array

    @property
    def continuous(self) -> bool:
        """Whether the ground does not jump here."""
        return bool(np.abs(self.jump).max() <= JUMP)


def borders(planes: Sequence[Facet]) -> Iterator[Border]:
    """All borders of planes that tile the ground, each from both of its sides."""
    corners = Places(np.concatenate([np.zeros((0, 2)), *(plane.polygon for plane in planes)]))
    pieces: list[tuple[int, Array, Array, Array]] = []
    for own, plane in enumerate(planes):
        begins, ends = edges(plane.polygon)
        for begin, end, side in zip(begins, ends, inward(begins, ends), strict=True):
            pieces += [(own, first, last, side) for first, last in pairwise(cuts(begin, end, corners))]
    beyond = np.array([0.5 * (first + last) - BESIDE * side for _, first, last, side in pieces])
    for (own, first, last, side), other in zip(
        pieces, _planes_at(Facets(tuple(planes)), beyond), strict=True
    ):
        if other not in (-1, own):
            both = np.array([first, last])
            jump = planes[other].z(both) - planes[own].z(both)
            yield Border(first, last, side, own, int(other), jump)


def cuts(begin: Array, end: Array, corners: Places) -> Array:
    """Where along an edge the neighbour may change: at corners of other planes that lie on it."""
    along = end - begin
    length = float(np.linalg.norm(along))
    along = along / length
    near = corners.within(np.minimum(begin, end) - BESIDE, np.maximum(begin, end) + BESIDE)
    relative = corners.points[near] - begin
    place = relative @ along
    beside = relative @ np.array([-along[1], along[0]])
    on = (np.abs(beside) < BESIDE) & (place > BESIDE) & (place < length - BESIDE)
    stops = np.unique(np.round(np.concatenate([[0.0], place[on], [length]]), 9))
    return np.asarray(begin + stops[:, None] * along)


def _planes_at(planes: Facets, points: Array) -> NDArray[np.intp]:
    """The number of the first plane at each point (n, 2), −1 where there is none."""
    result = np.full(len(points), -1, dtype=np.intp)
    for number, index in planes.under(points.reshape(-1, 2)):
        result[index[result[index] < 0]] = number
    return result


def components(
    planes: Sequence[Facet],
    all_borders: Sequence[Border],
    standable: NDArray[np.bool_],
    kinks_divide: bool = False,
) -> NDArray[np.intp]:
    """A number for each plane, equal where a wheel can roll between them; −1 where it cannot stand.

    With `kinks_divide` only what lies in one plane has one number.
    """
    count = len(planes)
    joined = [
        (b.own, b.other)
        for b in all_borders
        if b.continuous
        and standable[b.own]
        and standable[b.other]
        and not (kinks_divide and not planes[b.own].coplanar(planes[b.other]))
    ]
    rows, columns = np.array(joined, dtype=int).reshape(-1, 2).T
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(count, count))
    _, labels = connected_components(graph, directed=False)
    return np.where(standable, labels, -1)


def hard_edges(
    terrain: Terrain,
    all_borders: Sequence[Border],
    region: NDArray[np.intp],
    radius: float,
    kinks: bool = False,
) -> Obstacles:
    """The borders that a wheel that stands beside them may not come near.

    Where the ground beyond is higher, the wheel stays so far that nothing beyond touches it;
    where it is lower, so far that its contact is on its plane. Margins come on top.

    Args:
        terrain: made of planes alone.
        all_borders: of its planes.
        region: of each plane, from `components`.
        radius: of the wheel, m.
        kinks: whether in place of these the borders are meant where the ground only bends, between regions.
    """
    standable = region >= 0
    pieces = [
        piece
        for border in all_borders
        if standable[border.own]
        and (border.continuous and standable[border.other]) == kinks
        and not (kinks and region[border.own] == region[border.other])
        for piece in _level_pieces(border)
    ]
    if not pieces:
        nothing = np.zeros((0, 2))
        return Obstacles(nothing, nothing, nothing, np.zeros(0), np.zeros(0, dtype=np.intp))
    own = [terrain.planes[piece.own] for piece in pieces]
    begin, end, side = (np.array([getattr(p, name) for p in pieces]) for name in ("begin", "end", "side"))
    clearance = _distance(terrain, own, begin, end, side, radius)
    return Obstacles(begin, end, side, clearance, region[[piece.own for piece in pieces]])


def _level_pieces(border: Border) -> Iterator[Border]:
    """A border cut up where the jump changes along it."""
    length = float(np.linalg.norm(border.end - border.begin))
    count = 1 if abs(border.jump[1] - border.jump[0]) <= JUMP else int(np.ceil(length / PIECE - 1e-6))
    if count > 200:  # an edge without end: what is far away may be coarse
        count = 200
    shares = np.linspace(0.0, 1.0, count + 1)
    for a, b in pairwise(shares):
        yield Border(
            border.begin + a * (border.end - border.begin),
            border.begin + b * (border.end - border.begin),
            border.side,
            border.own,
            border.other,
            border.jump[0] + np.array([a, b]) * (border.jump[1] - border.jump[0]),
        )


def _distance(
    terrain: Terrain, own: Sequence[Facet], begin: Array, end: Array, side: Array, radius: float
) -> Array:
    """So far from each edge a wheel on its plane touches nothing but that plane, (n,), m."""
    slope = np.array([plane.slope for plane in own])
    height = np.array([plane.height for plane in own])
    steepness = np.linalg.norm(slope, axis=1)
    lean = radius * np.einsum("nk,nk->n", slope, side) / np.sqrt(1.0 + steepness**2)
    result = np.maximum(-lean, 0.0)  # below an edge the contact is nearer to it than the rim's lowest point
    length = np.linalg.norm(end - begin, axis=1)[:, None]
    along = (end - begin) / length
    beyond = np.append(BESIDE, np.linspace(0.0, radius, PROBES)[1:])
    shares = np.array([0.0, 0.5, 1.0])[:, None, None, None]
    at = begin + np.clip(shares * length, BESIDE, length - BESIDE) * along  # a corner has other neighbours
    place = at - beyond[:, None, None] * side
    higher = terrain.height(place[..., 0], place[..., 1]) - (height + np.einsum("abnk,nk->abn", place, slope))
    kept = touching_distance(higher, steepness, radius) - beyond[:, None]
    return np.asarray(np.maximum(result, kept.max(axis=(0, 1))))


def touching_distance(higher: Array, steepness: Array, radius: float) -> Array:
    """How far a ball on a plane is from a point over that plane when it touches it, horizontally, (n,), m.

    The worst of all directions: the ball stands downhill of the point. On a level plane √(2 R Δ − Δ²).

    Args:
        higher: Δ, by how much the point is over the plane, (n,), m.
        steepness: of the plane, rise over run, (n,).
        radius: R, m.
    """
    m = steepness
    over = radius * np.sqrt(1.0 + m**2) - higher  # of the centre over the point, if it stood right there
    root = np.sqrt(np.maximum(radius**2 * (1.0 + m**2) - over**2, 0.0))
    distance = (over * m + root) / (1.0 + m**2)
    wall = over - m * distance < 0.0  # higher than the centre of the ball: it touches a wall
    distance = np.where(wall | (over < 0.0), radius, distance)
    return np.where(higher > JUMP, distance, 0.0)
