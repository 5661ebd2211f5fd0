"""The ground about the ways of a foot as local models: one for each interval in which it stands or rolls.

On a way along one plane it is the plane. Elsewhere it is the quadratic that meets the surface at both ends
and in the middle of the way, and has the surface's slope across it there: so that models of neighbouring
intervals meet where the foot goes from one to the next.
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

INSIDE: Final = (-0.96, -0.5, 0.0, 0.5, 0.96)
"""Places along a way, in halves of it from its middle, that lie in one plane if all of it does: so little
before an end there may be a bend, as where a mesh is cut there."""

MOVES: Final = 2e-3
"""m; a foot whose way is shorter may as well go the other way next: then what is beside it counts, too."""


def models_along(
    regions: Regions, begin: Array, end: Array, headings: Array, reach: float = 0.0
) -> list[LocalModel]:
    """The models of n ways.

    Args:
        regions: of the wheel.
        begin: where the ways begin, (n, 2), m.
        end: where they end, (n, 2), m.
        headings: directions in which feet point that do not move, (n,), rad.
        reach: at least so far before and behind the middle of its way the ground counts, m, where it is not
            known well when a foot will be there: bends are as much rounder.
    """
    refs = 0.5 * (begin + end)
    plane = _planes_around(regions, refs, reach)
    bent = np.flatnonzero(plane < 0)
    fitted = dict(
        zip(bent.tolist(), _fitted(regions, begin[bent], end[bent], headings[bent], reach), strict=True)
    )
    along = np.full(len(refs), -1, dtype=np.intp)
    half = 0.5 * (end - begin)
    known = bent[2.0 * np.linalg.norm(half[bent], axis=1) > MOVES] if not reach else bent[:0]
    along[known] = _planes_along(regions, refs[known], half[known])
    result = []
    for k, (ref, around) in enumerate(zip(refs, plane, strict=True)):
        number = max(around, along[k])
        if number < 0:
            result.append(fitted[k])
            continue
        facet = regions.terrain.planes[number]
        lifted = regions.surface.radius * (np.sqrt(1.0 + facet.slope @ facet.slope) - 1.0)
        z, bends = float(facet.z(ref) + lifted), around < 0 and fitted[k].curved
        result.append(LocalModel.plane(ref, z, facet.slope, bends))
    return result


def _fitted(regions: Regions, begin: Array, end: Array, headings: Array, reach: float) -> list[LocalModel]:
    refs, way = 0.5 * (begin + end), end - begin
    length = np.linalg.norm(way, axis=1)
    pointing = np.column_stack([np.cos(headings), np.sin(headings)])
    moves = length > 1e-6
    along = np.where(moves[:, None], way / np.where(moves, length, 1.0)[:, None], pointing)
    left = np.column_stack([-along[:, 1], along[:, 0]])
    a = np.maximum(0.5 * length, max(HALF_LENGTH, reach))
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
    here = regions.label(refs)

    def same(places: Array) -> NDArray[np.bool_]:
        return np.where(here >= 0, regions.label(places) == here, regions.rollable(places))

    good = [same(refs + step) & ~np.isnan(low), same(refs - step) & ~np.isnan(high)]
    low_found = np.where(good[0], low, np.where(good[1], 2.0 * middle - high, middle))
    high_found = np.where(good[1], high, np.where(good[0], 2.0 * middle - low, middle))
    return low_found, high_found


def _planes_around(regions: Regions, refs: Array, reach: float) -> NDArray[np.intp]:
    """Number of the plane that a wheel touches at each place and all around it, −1 if there is no one."""
    angle = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    circle = max(SUPPORT * regions.sigma, reach) * np.column_stack([np.cos(angle), np.sin(angle)])
    around = np.vstack([np.zeros((1, 2)), *(ring * circle for ring in RINGS)])
    return _one_plane(regions, refs[:, None] + around)


def _planes_along(regions: Regions, refs: Array, half: Array) -> NDArray[np.intp]:
    """The same along the ways from −half to +half about each place."""
    return _one_plane(regions, refs[:, None] + np.array(INSIDE)[:, None] * half[:, None])


def _one_plane(regions: Regions, places: Array) -> NDArray[np.intp]:
    """Number of the plane that a wheel touches at all of some places (n, m, 2), (n,); −1 if there is none."""
    if not isinstance(regions, PlanarRegions) or not len(places):
        return np.full(len(places), -1, dtype=np.intp)
    touch = regions.surface.touch(places.reshape(-1, 2))
    plane = np.where(touch.face, touch.plane, -1).reshape(len(places), -1)
    one = (plane == plane[:, :1]).all(axis=1)
    return np.asarray(np.where(one, plane[:, 0], -1), dtype=np.intp)
