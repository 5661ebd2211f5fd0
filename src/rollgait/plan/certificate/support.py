"""Could the robot stop in every step? CoM and capture point against the support while one foot swings."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.certificate.case import Case
from rollgait.plan.certificate.physics import Array
from rollgait.plan.certificate.rows import Row, measured
from rollgait.robot.robot import GRAVITY, LEG_NAMES


def check_support(case: Case) -> Iterator[Row]:
    """Distances from the edges of the triangle of the feet that stand, in every swing of a single foot.

    The capture point moves with the mean velocity of these feet, which is taken from their paths.
    """
    motion, at = case.motion, case.motion.at
    legs = range(len(LEG_NAMES))
    com, capture = (np.full((*motion.time.shape, len(legs)), np.nan) for _ in range(2))
    alone = ~motion.stance & (motion.stance.sum(axis=-1, keepdims=True) == len(legs) - 1)
    for leg in legs:
        standing = [other for other in legs if other != leg]
        feet = at.foot_position[..., standing, :]
        drift = motion.path_velocity[..., standing, :2].mean(axis=-2)
        height = np.maximum(at.com_position[..., 2] - feet[..., 2].mean(axis=-1), 0.0)
        fall_time = np.sqrt(height / GRAVITY)[..., None]
        place = at.com_position[..., :2]
        com[..., leg] = depth_in_triangle(place, feet[..., :2])
        stop = place + fall_time * (at.com_velocity[..., :2] - drift)
        capture[..., leg] = depth_in_triangle(stop, feet[..., :2])
    for name, description, margin in (
        ("com_margin", "distance of the CoM from the edges of the feet that stand, in swings of one", com),
        ("capture_margin", "the same of the capture point, relative to the feet that stand", capture),
    ):
        asked = case.bound(name)
        yield from measured(
            name,
            description,
            "m",
            margin if asked is None else case.eased(margin, asked, tol.BEYOND),
            None if asked is None else asked - tol.LENGTH_MARGIN,
            motion.time,
            where=alone[:, None, :],
            at_least=True,
            promised=case.has(name),
        )


def depth_in_triangle(point: Array, corners: Array) -> Array:
    """How far a point lies inside a triangle, whichever way round its corners come, (…), m.

    The smallest of its distances from the lines through two corners; negative outside.

    Args:
        point: (…, 2), m.
        corners: (…, 3, 2), m.
    """
    a, b, c = (corners[..., i, :] for i in range(3))
    orientation = np.sign(_doubled_area(a, b, c))
    depths = [
        orientation * _doubled_area(first, second, point) / np.linalg.norm(second - first, axis=-1)
        for first, second in ((a, b), (b, c), (c, a))
    ]
    return np.asarray(np.min(depths, axis=0))


def _doubled_area(a: Array, b: Array, c: Array) -> Array:
    u, v = b - a, c - a
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])
