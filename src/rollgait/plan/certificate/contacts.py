"""Where feet touch ground that is not flat, by the judge's own look at the raw ground.

A wheel is looked at as a ball about its centre, p + R e_z with p the lowest point of its rim, above probes of
the ground. Whether it touches one side of a kink or the other nobody knows better than its place: so of all
normals that the ground has within `tolerances.PLACE` (give or take `tolerances.SLOPE`) the one nearest to the
plan's own is taken. What a plan states of its contacts counts only as far as the ground agrees.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np

from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.certificate.chunks import in_chunks
from rollgait.plan.certificate.motion import DenseMotion
from rollgait.plan.certificate.physics import Array
from rollgait.robot.robot import Robot

if TYPE_CHECKING:
    from rollgait.terrain.terrain import Terrain

RINGS: Final = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Radii of the rings of probes, in `tolerances.PLACE`."""
DIRECTIONS: Final = 8
"""Probes on a ring."""


@dataclass(frozen=True)
class Contacts:
    """What feet touch, all with leading axes (N, K, 4).

    Attributes:
        position: where the ground pushes a foot, p + R (e_z − n), (…, 3), m.
        normal: n, unit normal of the ground there, upwards, (…, 3).
        friction: μ there, (…).
        gap: distance of the ball from the ground, (…), m; negative where it is inside, NaN over unknown
            ground.
        bend: by how much the gradient of the ground differs around, (…); 0 on a plane and in swing.
        stated_apart: distance of the contact that the plan states, (…), m.
    """

    position: Array
    normal: Array
    friction: Array
    gap: Array
    bend: Array
    stated_apart: Array


def contacts_on(terrain: Terrain, robot: Robot, motion: DenseMotion) -> Contacts:
    """The contacts of feet that stand; of those in swing at the lowest points of their rims.

    Args:
        terrain: the raw ground.
        robot: knows the radii of its feet.
        motion: the plan, sampled.
    """
    at = motion.at
    shape = at.foot_position.shape[:-1]
    stands = np.broadcast_to(motion.in_stance, shape)
    p, stated = at.foot_position[stands], at.contact_normal[stands]
    radius = np.broadcast_to([leg.foot_radius for leg in robot.leg_list], shape)[stands]
    direction = ahead(robot, motion)[stands]
    touched = partial(_touched, terrain)
    slope, gap, bend = in_chunks(touched, p, radius, direction, _gradient(stated))
    up = np.concatenate([-slope, np.ones((len(p), 1))], axis=-1)
    up /= np.linalg.norm(up, axis=-1, keepdims=True)
    position, normal = at.foot_position.copy(), np.zeros((*shape, 3))
    normal[..., 2] = 1.0
    normal[stands] = up
    position[stands] += radius[:, None] * (np.array([0.0, 0.0, 1.0]) - up)
    all_gaps, all_bends = np.zeros((2, *shape))
    all_gaps[stands], all_bends[stands] = gap, bend
    return Contacts(
        position=position,
        normal=normal,
        friction=terrain.friction_at(position[..., 0], position[..., 1]),
        gap=all_gaps,
        bend=all_bends,
        stated_apart=np.linalg.norm(at.contact_position - position, axis=-1),
    )


def ahead(robot: Robot, motion: DenseMotion) -> Array:
    """The direction in which a foot is looked at, its heading or the yaw of the base, (N, K, 4), rad."""
    is_point = np.array([leg.foot == "point" for leg in robot.leg_list])
    return np.where(is_point, motion.at.euler[..., :1], motion.at.heading)


def _touched(
    terrain: Terrain, p: Array, radius: Array, direction: Array, stated: Array
) -> tuple[Array, Array, Array]:
    """The gradient (n, 2) of the ground below each foot nearest to that stated, its gap and bend, (n,)."""
    centre = p + radius[:, None] * [0.0, 0.0, 1.0]
    steepness = np.sqrt(1.0 + (stated**2).sum(axis=-1))
    about = p[:, :2] + (radius / steepness)[:, None] * stated
    along, left = _axes(direction)
    ring = tol.PLACE * np.array([(r * np.cos(a), r * np.sin(a)) for r, a in _pattern()])  # (m, 2)
    probes = about[:, None] + ring[:, :1] * along[:, None] + ring[:, 1:] * left[:, None]
    ground = terrain.height(probes[..., 0], probes[..., 1])
    beside = ((probes - centre[:, None, :2]) ** 2).sum(axis=-1)
    below = radius[:, None] ** 2 - beside
    under = (below >= 0.0) | (beside < 1e-12)
    above = np.where(under, centre[:, None, 2] - np.sqrt(np.maximum(below, 0.0)) - ground, np.nan)
    known = ~np.isnan(above)
    gap = np.where(known, above, np.inf).min(axis=1)
    gradient = terrain.slope(probes[..., 0], probes[..., 1])
    seen = ~np.isnan(gradient).any(axis=-1)
    result, spread = np.zeros((len(p), 2)), np.zeros(len(p))
    for axis in (along, left):
        component = np.einsum("nmi,ni->nm", gradient, axis)
        low = np.where(seen, component, np.inf).min(axis=1) - tol.SLOPE
        high = np.where(seen, component, -np.inf).max(axis=1) + tol.SLOPE
        wanted = np.einsum("ni,ni->n", stated, axis)
        nearest = np.where(low <= high, np.clip(wanted, low, high), 0.0)
        result += nearest[:, None] * axis
        spread = np.hypot(spread, np.maximum(high - low - 2.0 * tol.SLOPE, 0.0))
    return result, np.where(known.any(axis=1), gap, np.nan), spread


def _pattern() -> list[tuple[float, float]]:
    """Radius and angle of each probe."""
    angles = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    return [(r, float(a)) for r in RINGS for a in (angles if r else angles[:1])]


def _axes(direction: Array) -> tuple[Array, Array]:
    c, s = np.cos(direction), np.sin(direction)
    return np.stack([c, s], axis=-1), np.stack([-s, c], axis=-1)


def _gradient(normal: Array) -> Array:
    """Gradients (…, 2) of surfaces with normals (…, 3); 0 where they do not look up."""
    up = normal[..., 2:]
    return np.where(up > 0.0, -normal[..., :2] / np.where(up > 0.0, up, 1.0), 0.0)


def in_contact_frame(vector: Array, normal: Array, heading: Array) -> Array:
    """World vectors (…, 3) along the ground in the direction of a heading, to its left, along the normal."""
    axle = np.stack([-np.sin(heading), np.cos(heading), np.zeros_like(heading)], axis=-1)
    along = np.cross(axle, normal)
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    left = np.cross(normal, along)
    return np.stack([(vector * axis).sum(axis=-1) for axis in (along, left, normal)], axis=-1)


def slope_along(normal: Array, heading: Array) -> Array:
    """How much the ground rises over a way in the direction of a heading, (…)."""
    gradient = _gradient(normal)
    return np.asarray(gradient[..., 0] * np.cos(heading) + gradient[..., 1] * np.sin(heading))
