"""The ground under a robot, which hides it from its own sensors, from what is known around it."""

from __future__ import annotations

from itertools import combinations
from typing import Final

import numpy as np

from rollgait.terrain.polygons import Array, plane_of

SECTORS: Final = 12
"""Directions about the robot in which the ground is looked at."""
ON_PLANE: Final = 0.02
"""So far from a plane a height belongs to it, m: noise and bumps, and less than a step."""
STEEPEST: Final = 1.0
"""Slope of the steepest plane that a robot may stand on: 45 degrees."""
MOST: Final = 2000
"""So many of the heights around are looked at."""


def plane_around(centre: Array, around: Array) -> tuple[float, Array] | None:
    """The plane on which most of the ground around a place lies; a kerb on one side does not tilt it.

    Args:
        centre: of the robot, (2,), m.
        around: known points of the ground about it, (n, 3), m.

    Returns:
        Its height at `centre`, m, and its gradient (2,); level if points lie on one side only. None without
        any point.
    """
    if not len(around):
        return None
    points = around[:: 1 + len(around) // MOST] - np.array([*centre, 0.0])
    best = np.array([float(np.median(points[:, 2])), 0.0, 0.0])
    candidates = np.array([best, *_through_three(points)])
    places = np.column_stack([np.ones(len(points)), points[:, :2]])
    off = np.abs(points[:, 2] - candidates @ places.T)
    members = off <= ON_PLANE
    count = members.sum(axis=1)
    spread = np.where(members, off, 0.0).sum(axis=1)
    chosen = int(np.lexsort([spread, -count])[0])
    if chosen == 0 or count[chosen] < 3:
        return float(candidates[chosen, 0]), candidates[chosen, 1:]
    place, height, slope = plane_of(points[members[chosen]])
    return height - float(slope @ place), slope


def _through_three(points: Array) -> Array:
    """Planes (m, 3) through the middles of any three sectors that do not lie on one line."""
    turn = np.arctan2(points[:, 1], points[:, 0]) / (2.0 * np.pi) + 0.5
    sector = np.minimum(np.floor(turn * SECTORS), SECTORS - 1)
    middles = []
    for k in np.unique(sector):
        own = points[sector == k]
        middles.append(
            own[np.argsort(own[:, 2], kind="stable")[len(own) // 2]]
        )  # a point of the ground itself
    found = []
    for three in combinations(middles, 3):
        p = np.array(three)
        matrix = np.column_stack([np.ones(3), p[:, :2]])
        if abs(np.linalg.det(matrix)) > 1e-2:  # twice the area of the triangle, m²
            plane = np.linalg.solve(matrix, p[:, 2])
            if np.hypot(*plane[1:]) <= STEEPEST:
                found.append(plane)
    return np.array(found).reshape(-1, 3)
