"""Where things lie that are drawn on the ground: its heights, its normals, lines laid over it."""

from __future__ import annotations

from typing import Final

import numpy as np

from rollgait.plan.samples import Array
from rollgait.terrain import Terrain
from rollgait.view.paths import segments_of

ABOVE: Final = 0.004
"""Height over the ground of what lies on it, m: it must not flicker."""
STEP: Final = 0.01
"""Between places at which a line over the ground looks for its height, m."""


def heights(terrain: Terrain, points: Array) -> Array:
    """Height of the ground at points (…, 2 or 3), (…), m; where it is not known, the level of the ground."""
    z = terrain.height(points[..., 0], points[..., 1])
    return np.where(np.isnan(z), _middle(terrain), z)


def on_ground(terrain: Terrain, points: Array, above: float = ABOVE) -> Array:
    """Points (…, 2 or 3) laid on the ground, (…, 3), m."""
    return np.concatenate([points[..., :2], (heights(terrain, points) + above)[..., None]], axis=-1)


def normals(terrain: Terrain, points: Array) -> Array:
    """Unit normals of the ground at points (…, 2 or 3), (…, 3); up where it is not known."""
    normal = terrain.normal(points[..., 0], points[..., 1])
    return np.where(np.isnan(normal), [0.0, 0.0, 1.0], normal)


def frames(terrain: Terrain, points: Array, heading: Array) -> Array:
    """R (…, 3, 3) of axes on the ground: x along a heading (…) as seen from above, z along the normal."""
    z = normals(terrain, points)
    left = np.stack([-np.sin(heading), np.cos(heading), np.zeros_like(heading)], axis=-1)
    x = np.cross(left, z)
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=-1)


def laid_segments(terrain: Terrain, line: Array, above: float = ABOVE) -> Array:
    """A line of straight pieces (n, 2) laid over the ground, as segments (m, 2, 3), m.

    Where the ground is not known the line is open.
    """
    length = np.linalg.norm(np.diff(line, axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(length)])
    if is_plane(terrain):
        flat = on_ground(terrain, line, above)
        return np.stack([flat[:-1], flat[1:]], axis=1)
    places = np.unique(np.concatenate([way, np.arange(0.0, way[-1], STEP)]).round(9))
    xy = np.column_stack([np.interp(places, way, line[:, k]) for k in range(2)])
    z = terrain.height(*xy.T)
    points = np.column_stack([xy, z + above])
    found = [np.zeros((0, 2, 3))]
    for run in np.split(np.arange(len(points)), np.flatnonzero(np.diff(np.isnan(z))) + 1):
        if len(run) > 1 and not np.isnan(z[run[0]]):
            found.append(points[run][segments_of(points[run])])
    return np.concatenate(found)


def grid_lines(terrain: Terrain, low: Array, high: Array, spacing: float) -> Array:
    """Lines over the ground in a rectangle at multiples of a distance (m), as segments (n, 2, 3), m."""
    found = [np.zeros((0, 2, 3))]
    for axis in range(2):
        places = spacing * np.arange(np.ceil(low[axis] / spacing), np.floor(high[axis] / spacing) + 1.0)
        for place in places:
            line = np.array([low, high], dtype=float)
            line[:, axis] = place
            found.append(laid_segments(terrain, line))
    return np.concatenate(found)


def is_plane(terrain: Terrain) -> bool:
    """Whether it is a horizontal plane without end."""
    return terrain.planar and not terrain.parts


def _middle(terrain: Terrain) -> float:
    """What is taken for the height of ground that is not known, m."""
    known = None if terrain.map is None else terrain.map.values[~np.isnan(terrain.map.values)]
    return terrain.level + (float(np.median(known)) if known is not None and known.size else 0.0)
