"""Local models about many places at once: most lie in the middle of a plane, which needs no fit."""

from __future__ import annotations

from typing import Final

import numpy as np

from rollgait.terrain.local_model import SIGMA, SUPPORT, LocalModel
from rollgait.terrain.polygons import Array
from rollgait.terrain.regions import PlanarRegions, Regions

RINGS: Final = (0.5, 1.0)
"""Radii of the circles about a place on which the ground is looked at first, in radii of its samples."""
DIRECTIONS: Final = 12
"""Places on each."""


def local_models(regions: Regions, refs: Array, headings: Array) -> list[LocalModel]:
    """`Regions.local_model` of each of n places.

    Args:
        regions: of the wheel.
        refs: places (n, 2), m.
        headings: turn the patterns of samples, (n,), rad.
    """
    plane = _planes_around(regions, refs)
    result = []
    for ref, heading, number in zip(refs, headings, plane, strict=True):
        if number < 0:
            result.append(regions.local_model(ref, float(heading)))
        else:
            facet = regions.terrain.planes[number]
            lifted = regions.surface.radius * (np.sqrt(1.0 + facet.slope @ facet.slope) - 1.0)
            result.append(LocalModel.plane(ref, float(facet.z(ref) + lifted), facet.slope))
    return result


def _planes_around(regions: Regions, refs: Array) -> Array:
    """Number of the plane that a wheel touches at each place and all around it, −1 if there is no one."""
    if not isinstance(regions, PlanarRegions) or not len(refs):
        return np.full(len(refs), -1)
    angle = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    around = np.vstack([np.zeros((1, 2)), *(SUPPORT * SIGMA * ring * circle for ring in RINGS)])
    touch = regions.surface.touch((refs[:, None] + around).reshape(-1, 2))
    plane = np.where(touch.face, touch.plane, -1).reshape(len(refs), -1)
    one = (plane == plane[:, :1]).all(axis=1)
    return np.asarray(np.where(one, plane[:, 0], -1))
