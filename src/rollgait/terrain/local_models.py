"""The ground about the ways of a foot as local models: one for each interval in which it stands or rolls.

On a plane it is the plane. Elsewhere it is the quadratic that meets the surface at both ends and in the
middle of the way, and has the surface's slope across it there: so that models of neighbouring intervals meet
where the foot goes from one to the next.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.terrain.local_model import SUPPORT, LocalModel
from rollgait.terrain.polygons import Array
from rollgait.terrain.regions import PlanarRegions, Regions

RINGS: Final = (0.5, 1.0)
"""Radii of the circles about a place on which the ground is looked at first, in radii of its samples."""
DIRECTIONS: Final = 12
"""Places on each."""
HALF_LENGTH: Final = 0.02
"""Least half of a way along which the ground is looked at, m: at a kink a shorter one would bend the model so
much that it says nothing about places beside it."""
ACROSS: Final = 0.02
"""Half the distance across the way over which its slope is taken, m."""


def models_along(regions: Regions, begin: Array, end: Array, headings: Array) -> list[LocalModel]:
    """The models of n ways.

    Args:
        regions: of the wheel.
        begin: where the ways begin, (n, 2), m.
        end: where they end, (n, 2), m.
        headings: directions in which feet point that do not move, (n,), rad.
    """
    refs = 0.5 * (begin + end)
    plane = _planes_around(regions, refs)
    bent = np.flatnonzero(plane < 0)
    fitted = dict(zip(bent.tolist(), _fitted(regions, begin[bent], end[bent], headings[bent]), strict=True))
    result = []
    for k, (ref, number) in enumerate(zip(refs, plane, strict=True)):
        if number < 0:
            result.append(fitted[k])
            continue
        facet = regions.terrain.planes[number]
        lifted = regions.surface.radius * (np.sqrt(1.0 + facet.slope @ facet.slope) - 1.0)
        result.append(LocalModel.plane(ref, float(facet.z(ref) + lifted), facet.slope))
    return result


def _fitted(regions: Regions, begin: Array, end: Array, headings: Array) -> list[LocalModel]:
    refs, way = 0.5 * (begin + end), end - begin
    length = np.linalg.norm(way, axis=1)
    pointing = np.column_stack([np.cos(headings), np.sin(headings)])
    moves = length > 1e-6
    along = np.where(moves[:, None], way / np.where(moves, length, 1.0)[:, None], pointing)
    left = np.column_stack([-along[:, 1], along[:, 0]])
    a = np.maximum(0.5 * length, HALF_LENGTH)
    back, front = (regions.surface.touch(refs + sign * a[:, None] * along).height for sign in (-1.0, 1.0))
    right, beside = (regions.surface.touch(refs + sign * ACROSS * left).height for sign in (-1.0, 1.0))
    middle = regions.surface.touch(refs).height
    # what is not known, or over an edge, is taken for a continuation of what is on the other side
    back, front = _other_side(regions, refs, -a[:, None] * along, back, front, middle)
    right, beside = _other_side(regions, refs, -ACROSS * left, right, beside, middle)
    result = []
    for k, ref in enumerate(refs):
        slope = (front[k] - back[k]) / (2.0 * a[k])
        bend = (front[k] - 2.0 * middle[k] + back[k]) / a[k] ** 2
        slope_across = (beside[k] - right[k]) / (2.0 * ACROSS)
        t, n = along[k], left[k]
        result.append(LocalModel(ref, float(middle[k]), slope * t + slope_across * n, bend * np.outer(t, t)))
    return result


def _other_side(
    regions: Regions, refs: Array, step: Array, low: Array, high: Array, middle: Array
) -> tuple[Array, Array]:
    """Heights a step (n, 2) before and after places; where a wheel cannot be, the ground goes on straight."""
    good = [regions.rollable(refs + step) & ~np.isnan(low), regions.rollable(refs - step) & ~np.isnan(high)]
    low_found = np.where(good[0], low, np.where(good[1], 2.0 * middle - high, middle))
    high_found = np.where(good[1], high, np.where(good[0], 2.0 * middle - low, middle))
    return low_found, high_found


def _planes_around(regions: Regions, refs: Array) -> NDArray[np.intp]:
    """Number of the plane that a wheel touches at each place and all around it, −1 if there is no one."""
    if not isinstance(regions, PlanarRegions) or not len(refs):
        return np.full(len(refs), -1, dtype=np.intp)
    angle = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    around = np.vstack([np.zeros((1, 2)), *(SUPPORT * regions.sigma * ring * circle for ring in RINGS)])
    touch = regions.surface.touch((refs[:, None] + around).reshape(-1, 2))
    plane = np.where(touch.face, touch.plane, -1).reshape(len(refs), -1)
    one = (plane == plane[:, :1]).all(axis=1)
    return np.asarray(np.where(one, plane[:, 0], -1), dtype=np.intp)
