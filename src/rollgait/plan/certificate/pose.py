"""How high and how tilted the base should stand over its feet, on ground that is not flat."""

from __future__ import annotations

from typing import Final

import numpy as np

from rollgait.plan.certificate.motion import DenseMotion
from rollgait.plan.certificate.physics import Array
from rollgait.scenario.schedule import ContactSchedule
from rollgait.terrain.terrain import Terrain

STEP_SHARE: Final = 0.4
"""Highest step, in heights of the CoM: what is farther above or below is no ground that a foot steps from."""
TILT_SHARE: Final = 0.6
"""Share of the slope under its feet that the base takes (docs/terrain.md)."""


def wanted_pose(feet: Array, yaw: Array, stance: Array) -> tuple[Array, Array]:
    """The height (…) over which the CoM should be at its nominal one, and the angles of the base (…, 3), rad.

    Args:
        feet: places of the ground under the feet, (…, 4, 3), m.
        yaw: of the base, (…), rad.
        stance: nominal places of the feet, at which their heights count, base-yaw frame, (4, 3), m.
    """
    z = feet[..., 2]
    middle = z.mean(axis=-1)
    columns = np.column_stack([np.ones(len(stance)), stance[:, :2]])
    plane, *_ = np.linalg.lstsq(columns, z.reshape(-1, len(stance)).T, rcond=1e-9)
    forward, left = plane[1:].reshape(2, *middle.shape)
    pitch, roll = -TILT_SHARE * np.arctan(forward), TILT_SHARE * np.arctan(left)
    return middle, np.stack([yaw, pitch, roll], axis=-1)


def ground_under_feet(
    schedule: ContactSchedule, motion: DenseMotion, terrain: Terrain, height: float
) -> Array:
    """Where feet stand, and in swing below them as if the ground rose evenly, (N, K, 4, 3), m.

    Of a swing that has begun before t = 0 the ground below the foot then counts as what it has left, if it
    is no more than a step from where it lands.

    Args:
        schedule: the contacts.
        motion: the motion.
        terrain: the raw ground.
        height: of the CoM over its feet, m.
    """
    under = motion.at.foot_position.copy()
    times = schedule.node_times
    for swing in schedule.swings():
        inside = slice(swing.lift_off, swing.touch_down)
        begin, end = times[swing.lift_off] - swing.begun, times[swing.touch_down]
        passed = (motion.time[inside] - begin) / (end - begin)
        z = under[inside, :, swing.leg, 2]
        begin_z = z[0, 0]
        if swing.begun > 0.0:
            below = float(terrain.height(*under[0, 0, swing.leg, :2]))
            near = abs(below - z[-1, -1]) <= STEP_SHARE * height
            begin_z = below if near else z[-1, -1]  # a ditch, or nothing that is known
        under[inside, :, swing.leg, 2] = begin_z + passed * (z[-1, -1] - begin_z)
    return under
