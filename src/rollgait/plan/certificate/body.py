"""Do trunk and hips stay off the ground? On ground that is not flat, of robots whose shapes are known."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.certificate.case import Case
from rollgait.plan.certificate.physics import Array, rotation_world_base
from rollgait.plan.certificate.rows import Row, measured
from rollgait.robot.robot import LEG_NAMES, Robot

LOOKED_AT: Final = (0, 5, 11)
"""Samples of an interval at which bodies are looked at: they move slower than wheels."""
APART: Final = 0.05
"""Distance of the places of a part below which the ground is looked up, m."""
RIGID: Final = 0.9
"""Of legs that is judged which goes with the base by at least this: hips. How high the rest is joints decide,
which tracking knows."""
ACROSS: Final = 5
"""Places across a sphere."""


def check_body(case: Case) -> Iterator[Row]:
    """The height of trunk and hips above the ground straight below, against what is asked."""
    asked = case.bound("body_clearance")
    terrain, robot, motion = case.terrain, case.robot, case.motion
    if terrain is None or not robot.underside.known:
        return
    at = motion.at
    com, feet = at.com_position[:, LOOKED_AT], at.foot_position[:, LOOKED_AT]
    tilted = rotation_world_base(at.euler[:, LOOKED_AT])
    upright = rotation_world_base(at.euler[:, LOOKED_AT] * np.array([1.0, 0.0, 0.0]))
    time = motion.time[:, LOOKED_AT]
    margin = np.full((*time.shape, len(LEG_NAMES)), np.inf)
    for places, share, leg, is_limb in _parts(robot):
        foot = feet[..., leg, :][..., None, :]
        from_base = com[..., None, :] + places @ tilted.swapaxes(-1, -2)
        from_foot = foot + (places - robot.stance[leg]) @ upright.swapaxes(-1, -2)
        place = share * from_base + (1.0 - share) * from_foot
        height = place[..., 2] - terrain.height(place[..., 0], place[..., 1])
        wanted = 0.0 if is_limb else asked or 0.0  # spheres are drawn large
        found = np.nan_to_num(height, nan=np.inf).min(axis=-1) - wanted
        margin[..., leg] = np.minimum(margin[..., leg], found)
    yield from measured(
        "body_clearance",
        "height of trunk and hips above the ground, beyond what is asked",
        "m",
        case.eased(margin, 0.0, tol.BEYOND, time),
        -tol.BODY,
        time,
        at_least=True,
        promised=asked is not None and case.has("body_clearance"),
    )


def _parts(robot: Robot) -> Iterator[tuple[Array, float, int, bool]]:
    """Places under each part in the nominal stance, what goes with the base, its leg, whether it is a leg's.

    A trunk has no foot to follow; the leg of its row is the nearest.
    """
    for box in robot.underside.belly:
        x, y = (np.linspace(*side, 2 + int((side[1] - side[0]) / APART)) for side in (box.x, box.y))
        grid = np.array([[a, b, box.z] for a in x for b in y])
        away = np.hypot(*np.moveaxis(grid[:, None, :2] - robot.stance[:, :2], -1, 0))
        for leg in range(len(LEG_NAMES)):
            own = grid[away.argmin(axis=1) == leg]
            if len(own):
                yield own, 1.0, leg, False
    for sphere in robot.underside.limbs:
        if sphere.with_base < RIGID:
            continue
        offset = np.linspace(-1.0, 1.0, ACROSS)
        disc = np.array([[a, b] for a in offset for b in offset if np.hypot(a, b) <= 1.0])
        below = -np.sqrt(np.maximum(0.0, 1.0 - (disc**2).sum(axis=1)))
        grid = np.array(sphere.centre) + sphere.radius * np.column_stack([disc, below])
        yield grid, sphere.with_base, LEG_NAMES.index(sphere.leg), True
