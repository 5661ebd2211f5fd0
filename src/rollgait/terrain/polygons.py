"""Convex polygons in the plane: clipping, subtracting, distances. Vertices counter-clockwise, (n, 2), m."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SLIVER: Final = 1.0e-10
"""Smallest area of a polygon, m²: what is less is rounding."""
ON_LINE: Final = 1.0e-9
"""A point so near to a line lies on it, m: rounding of coordinates within a kilometre."""


def rectangle(near: Array, yaw: float, length: float, left: float, right: float) -> Array:
    """The rectangle that begins at `near`, `length` long in the direction of `yaw`; shape (4, 2).

    Args:
        near: a point of its near edge, (2,), m.
        yaw: of its long axis, rad.
        length: along the axis, m.
        left: how far it goes to the left of the axis, m.
        right: how far it goes to the right of the axis, m.
    """
    along = np.array([np.cos(yaw), np.sin(yaw)])
    across = np.array([-np.sin(yaw), np.cos(yaw)])
    far = near + length * along
    return np.array([near - right * across, far - right * across, far + left * across, near + left * across])


def area(polygon: Array) -> float:
    """m²."""
    relative = polygon - polygon[0]  # far from the origin the products below would lose their digits
    x, y = relative.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def edges(polygon: Array) -> tuple[Array, Array]:
    """First and second ends of its edges, each of shape (n, 2), m."""
    return polygon, np.roll(polygon, -1, axis=0)


def inward(begin: Array, end: Array) -> Array:
    """Unit normals to the left of the ways from `begin` to `end`, (n, 2): into a polygon, from its edges."""
    along = end - begin
    normals = np.column_stack([-along[:, 1], along[:, 0]])
    return np.asarray(normals / np.linalg.norm(along, axis=1)[:, None])


def contains(polygon: Array, points: Array, slack: float = ON_LINE) -> NDArray[np.bool_]:
    """Which points, (n, 2), lie inside, or outside by no more than `slack` (m)."""
    begin, end = edges(polygon)
    x, y = points.T
    result = np.ones(len(points), dtype=bool)
    for (x0, y0), (nx, ny) in zip(begin, inward(begin, end), strict=True):  # few edges, many points
        result &= nx * (x - x0) + ny * (y - y0) >= -slack
    return result


def clip(polygon: Array, point: Array, normal: Array) -> Array | None:
    """The part of a polygon on the side of the line through `point` to which `normal` points, or None."""
    depth = (polygon - point) @ normal
    depth[np.abs(depth) <= ON_LINE] = 0.0
    kept: list[Array] = []
    for k, (vertex, here) in enumerate(zip(polygon, depth, strict=True)):
        following, there = polygon[(k + 1) % len(polygon)], depth[(k + 1) % len(polygon)]
        if here >= 0.0:
            kept.append(vertex)
        if here * there < 0.0:
            kept.append(vertex + here / (here - there) * (following - vertex))
    if len(kept) < 3:
        return None
    result = _without_doubles(np.array(kept))
    return result if len(result) >= 3 and area(result) > SLIVER else None


def subtract(polygon: Array, hole: Array) -> list[Array]:
    """What is left of a polygon without another: convex pieces that do not overlap."""
    if (polygon.max(axis=0) < hole.min(axis=0)).any() or (hole.max(axis=0) < polygon.min(axis=0)).any():
        return [polygon]
    begin, end = edges(hole)
    pieces, rest = [], polygon
    for point, normal in zip(begin, inward(begin, end), strict=True):
        outside = clip(rest, point, -normal)
        if outside is not None:
            pieces.append(outside)
        inside = clip(rest, point, normal)
        if inside is None:
            return [polygon]  # they only touch
        rest = inside
    return pieces


def _without_doubles(polygon: Array) -> Array:
    distance = np.linalg.norm(polygon - np.roll(polygon, 1, axis=0), axis=1)
    return np.asarray(polygon[distance > ON_LINE])


def nearest_on_segments(points: Array, begin: Array, end: Array) -> Array:
    """The point of each segment that is nearest to each point, shape (n, m, 2), m.

    Args:
        points: (n, 2), m.
        begin: first ends of the segments, (m, 2), m.
        end: second ends, (m, 2), m; a segment may be a point.
    """
    along = end - begin
    square = np.einsum("mk,mk->m", along, along)
    share = np.einsum("mk,nmk->nm", along, points[:, None] - begin[None])
    share = np.clip(share / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
    return np.asarray(begin[None] + share[..., None] * along[None])


def convex_hull(points: Array) -> Array:
    """The hull of points (n, 2); of points on one line its two ends, of one point that point: (1…n, 2)."""
    ordered = np.unique(points, axis=0)
    if len(ordered) < 3:
        return ordered

    def chain(sequence: Array) -> list[Array]:
        result: list[Array] = []
        for p in sequence:
            while len(result) > 1 and _turn(result[-2], result[-1], p) <= 0.0:
                result.pop()
            result.append(p)
        return result[:-1]

    return np.array(chain(ordered) + chain(ordered[::-1]))


def _turn(a: Array, b: Array, c: Array) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def distance_to_hull(hull: Array, points: Array) -> Array:
    """How far points (n, 2) are outside a convex polygon, (n,), m; 0 inside."""
    first, second = hull, np.roll(hull, -1, axis=0)
    nearest = nearest_on_segments(points, first, second)
    distance = np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1)
    if len(hull) > 2:
        distance[contains(hull, points)] = 0.0
    return np.asarray(distance)


def nearest_pairs(hull: Array, begin: Array, end: Array) -> tuple[Array, Array]:
    """For each segment the nearest point of a convex hull, and of the segment to it: two of shape (m, 2), m.

    Where a segment meets the hull the two are the same point.
    """
    first, second = (hull, np.roll(hull, -1, axis=0)) if len(hull) > 1 else (hull, hull)
    from_hull = nearest_on_segments(hull, begin, end)  # (h, m, 2), on the segments
    on_begin = nearest_on_segments(begin, first, second)  # (m, h, 2), on the hull
    on_end = nearest_on_segments(end, first, second)
    of_hull = np.concatenate(
        [np.broadcast_to(hull[:, None], from_hull.shape), on_begin.swapaxes(0, 1), on_end.swapaxes(0, 1)]
    )
    of_segment = np.concatenate(
        [
            from_hull,
            np.broadcast_to(begin[None], (len(hull), *begin.shape)),
            np.broadcast_to(end[None], (len(hull), *end.shape)),
        ]
    )
    best = np.linalg.norm(of_hull - of_segment, axis=2).argmin(axis=0)
    every = np.arange(len(begin))
    on_hull, on_segment = of_hull[best, every].copy(), of_segment[best, every].copy()
    meets = _meet(first, second, begin, end)
    if len(hull) > 2:
        meets |= contains(hull, begin)
    on_hull[meets] = on_segment[meets]
    return on_hull, on_segment


def _meet(first: Array, second: Array, begin: Array, end: Array) -> NDArray[np.bool_]:
    """Which segments cross one of the ways from `first` to `second`."""

    def side(a: Array, b: Array, c: Array) -> Array:
        return np.asarray(
            (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1])
            - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
        )

    a, b, c, d = first[:, None], second[:, None], begin[None], end[None]
    crossing = (side(a, b, c) * side(a, b, d) < 0.0) & (side(c, d, a) * side(c, d, b) < 0.0)
    return np.asarray(crossing.any(axis=0))


def plane_of(points: Array) -> tuple[Array, float, Array]:
    """The best plane through points (n, 3): a place (2,) on it, its height there (m) and its gradient (2,).

    The gradient is the smallest of those that fit equally well: of two points along the line between them, of
    a single one 0.
    """
    centre = points.mean(axis=0)
    spread = points - centre
    slope, *_ = np.linalg.lstsq(spread[:, :2], spread[:, 2], rcond=1e-9)
    return centre[:2], float(centre[2]), slope
