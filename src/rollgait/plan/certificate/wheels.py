"""How far the discs of wheels are from the raw ground, and how far footholds are from edges."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.certificate.chunks import in_chunks
from rollgait.plan.certificate.physics import Array

if TYPE_CHECKING:
    from rollgait.terrain.terrain import Terrain

FINE: Final = np.radians(40.0)
"""rad; so far from below its centre a wheel touches ground that it can stand on: there its rim is probed
finely."""
RIM_FINE, RIM_COARSE = 31, 6
"""Probes in that part of the rim (2.7° apart: between two the rim bulges by 0.03 mm at R = 0.124 m), and on
either side of it (there by 0.3 mm)."""
RAYS: Final = 16
"""Directions around a foothold in which edges are looked for at first."""
FINE_RAYS: Final = 32
"""And where there are any: a ray meets a straight edge 3 cm away at most 0.15 mm farther than it is."""
RAY_STEP: Final = 0.01
"""m between the probes on a ray."""
STEP_MAX: Final = 5e-3
"""m; what a wheel rolls over anyway: only a greater rise or fall is an edge."""
STEEP: Final = 0.85
"""Share of μ up to which ground is a slope and not an edge."""
FAR: Final = 0.05
"""m; edges farther from a wheel than this are not looked for."""
HALVINGS: Final = 7
"""How often the place of an edge between two probes is halved: to less than 0.1 mm."""


def rim_clearance(terrain: Terrain, lowest: Array, heading: Array, radius: Array) -> Array:
    """Smallest vertical distance of the rims of upright discs from the ground, (n,), m; negative is a depth.

    Unknown ground is no hindrance.

    Args:
        terrain: the raw ground.
        lowest: lowest points of the rims, (n, 3), m.
        heading: directions in which the wheels roll, (n,), rad.
        radius: R, (n,), m; 0 of a foot that is a point.
    """
    angle = np.concatenate(
        [
            -np.linspace(0.5 * np.pi, FINE, RIM_COARSE, endpoint=False),
            np.linspace(-FINE, FINE, RIM_FINE),
            np.linspace(FINE, 0.5 * np.pi, RIM_COARSE + 1)[1:],
        ]
    )
    if not radius.any():
        angle = np.zeros(1)
    forward = radius[:, None] * np.sin(angle)
    x = lowest[:, :1] + forward * np.cos(heading)[:, None]
    y = lowest[:, 1:2] + forward * np.sin(heading)[:, None]
    z = lowest[:, 2:] + radius[:, None] * (1.0 - np.cos(angle))
    (ground,) = in_chunks(lambda *places: (terrain.height(*places),), x, y)
    distance = z - ground
    return np.asarray(np.where(np.isnan(distance), np.inf, distance).min(axis=1))


def edge_distance(
    terrain: Terrain, lowest: Array, contact: Array, heading: Array, radius: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """How far feet could be displaced in any direction before they meet an edge, (n,), m, at most `FAR`.

    An edge is where the ground rises or falls by more than `STEP_MAX` and more steeply than anything can
    stand on: a kink is none. An edge that falls off is met by the contact, one that rises by the wheel.

    Args:
        terrain: the raw ground.
        lowest: lowest points of the rims, (n, 3), m.
        contact: where they touch the ground, (n, 3), m.
        heading: by which the directions are turned, (n,), rad.
        radius: R, (n,), m.

    Returns:
        The distances, and whether the ground is known within them.
    """
    feet = (lowest, contact, heading, radius)
    distance, known = in_chunks(partial(_along_rays, terrain, RAYS), *feet)
    near = np.flatnonzero(distance < FAR)
    if near.size:
        near_feet = (values[near] for values in feet)
        distance[near], known[near] = in_chunks(partial(_along_rays, terrain, FINE_RAYS), *near_feet)
    return distance, known


def _along_rays(
    terrain: Terrain, rays: int, lowest: Array, contact: Array, heading: Array, radius: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """See `edge_distance`; looks in so many directions."""
    reach = float(radius.max(initial=0.0)) + FAR
    length = np.linspace(0.0, reach, int(np.ceil(reach / RAY_STEP)) + 1)
    angle = heading[:, None] + 2.0 * np.pi * np.arange(rays) / rays
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=-1)  # (n, rays, 2)
    places = lowest[:, None, None, :2] + length[:, None] * direction[:, :, None]
    z = terrain.height(places[..., 0], places[..., 1])
    mu = terrain.friction_at(lowest[:, 0], lowest[:, 1])[:, None, None]
    steepest = STEP_MAX + STEEP * mu * (length[1] - length[0])
    foot, ray, number = np.nonzero(np.abs(np.diff(z, axis=-1)) > steepest)
    place = _edge_between(terrain, places[foot, ray, number], places[foot, ray, number + 1])
    inner, outer = z[foot, ray, number], z[foot, ray, number + 1]
    R, centre = radius[foot], lowest[foot, 2] + radius[foot]
    half_chord = np.sqrt(
        R**2 - np.clip(centre - outer, 0.0, R) ** 2
    )  # of the wheel, at the height of the edge
    of_wheel = np.linalg.norm(place - lowest[foot, :2], axis=-1) - half_chord
    of_contact = np.linalg.norm(place - contact[foot, :2], axis=-1)
    distance = np.full(len(lowest), FAR)
    np.minimum.at(distance, foot, np.where(outer > inner, of_wheel, of_contact))
    near = np.linalg.norm(places - contact[:, None, None, :2], axis=-1) < tol.KNOWN
    return distance, ~(np.isnan(z) & near).any(axis=(1, 2))


def _edge_between(terrain: Terrain, inner: Array, outer: Array) -> Array:
    """Where on the ways between places (n, 2) the ground jumps, (n, 2), m."""
    z_inner, z_outer = (terrain.height(at[:, 0], at[:, 1]) for at in (inner, outer))
    for _ in range(HALVINGS):
        middle = 0.5 * (inner + outer)
        z = terrain.height(middle[:, 0], middle[:, 1])
        first = ~(np.abs(z - z_inner) < np.abs(z_outer - z))  # where the larger part of the jump is
        inner, outer = np.where(first[:, None], inner, middle), np.where(first[:, None], middle, outer)
        z_inner, z_outer = np.where(first, z_inner, z), np.where(first, z, z_outer)
    return np.asarray(0.5 * (inner + outer))
