"""How far the discs of wheels are from the raw ground, and how far footholds are from edges."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

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
    distance = z - terrain.height(x, y)
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
    distance, known = _along_rays(terrain, lowest, contact, heading, radius, RAYS)
    near = np.flatnonzero(distance < FAR)
    if near.size:
        distance[near], known[near] = _along_rays(
            terrain, lowest[near], contact[near], heading[near], radius[near], FINE_RAYS
        )
    return distance, known


def _along_rays(
    terrain: Terrain, lowest: Array, contact: Array, heading: Array, radius: Array, rays: int
) -> tuple[Array, NDArray[np.bool_]]:
    reach = float(radius.max(initial=0.0)) + FAR
    length = np.linspace(0.0, reach, int(np.ceil(reach / RAY_STEP)) + 1)
    angle = heading[:, None] + 2.0 * np.pi * np.arange(rays) / rays
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=-1)  # (n, rays, 2)

    def height(about: Array, way: Array, ways: Array) -> Array:
        places = about + way[..., None] * ways
        return terrain.height(places[..., 0], places[..., 1])

    origin = lowest[:, None, None, :2]
    z = height(origin, np.broadcast_to(length, (*direction.shape[:2], length.size)), direction[:, :, None])
    mu = terrain.friction_at(lowest[:, 0], lowest[:, 1])[:, None, None]
    step = length[1] - length[0]
    unknown = np.isnan(z)
    edge = np.abs(np.diff(z, axis=-1)) > STEP_MAX + STEEP * mu * step
    foot, ray, number = np.nonzero(edge)
    inner, outer = length[number], length[number + 1]
    z_inner, z_outer = z[foot, ray, number], z[foot, ray, number + 1]
    rises = z_outer > z_inner
    top = np.maximum(z_inner, z_outer)
    ways, about = direction[foot, ray], lowest[foot, :2]
    for _ in range(HALVINGS):
        middle = 0.5 * (inner + outer)
        z_middle = height(about, middle, ways)
        first = ~(np.abs(z_middle - z_inner) < np.abs(z_outer - z_middle))  # the jump is in the first half
        outer, z_outer = np.where(first, middle, outer), np.where(first, z_middle, z_outer)
        inner, z_inner = np.where(first, inner, middle), np.where(first, z_inner, z_middle)
    place = about + (0.5 * (inner + outer))[:, None] * ways
    R, centre = radius[foot], lowest[foot, 2] + radius[foot]
    under = np.clip(centre - top, 0.0, R)
    half_chord = np.sqrt(R**2 - under**2)  # of the wheel, at the height of the edge
    of_wheel = np.linalg.norm(place - lowest[foot, :2], axis=-1) - half_chord
    of_contact = np.linalg.norm(place - contact[foot, :2], axis=-1)
    result = np.full(len(lowest), FAR)
    np.minimum.at(result, foot, np.where(rises, of_wheel, of_contact))
    near = np.linalg.norm(
        origin + length[:, None] * direction[:, :, None] - contact[:, None, None, :2], axis=-1
    )
    return result, ~(unknown & (near < EDGE_OF_KNOWN)).any(axis=(1, 2))


EDGE_OF_KNOWN: Final = 0.025
"""m; so far around its contact a foot must know the ground: what a robot misses its footholds by, less the
distance of two probes."""
