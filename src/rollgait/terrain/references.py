"""What the ground under its feet asks of the base."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from rollgait.terrain.polygons import Array, plane_of

TILT_SHARE: Final = 0.6
"""Share of the slope under its feet that the base takes: none costs reach of legs, all of it stability."""


@dataclass(frozen=True)
class BaseReference:
    """Where the base is wanted over its feet.

    Attributes:
        ground: mean height under the feet, m: the CoM is wanted its nominal height above.
        pitch: θy, rad; negative with the nose up.
        roll: θx, rad; positive with the left side up.
    """

    ground: float
    pitch: float
    roll: float


def base_references(heights: Array, stance: Array, share: float = TILT_SHARE) -> Array:
    """What the ground asks of the base: mean ground (m), pitch and roll (rad), (…, 3).

    The slope is that through the heights at the nominal places of the feet: it hardly changes where the feet
    lean, so that a problem may know it before it is solved.

    Args:
        heights: of the ground under the feet, (…, 4), m.
        stance: nominal places of the feet, base-yaw frame, (4, 2) or (4, 3), m.
        share: of the slope that the base takes.
    """
    places = stance[:, :2] - stance[:, :2].mean(axis=0)
    ground = heights.mean(axis=-1)
    slope = (heights - ground[..., None]) @ np.linalg.pinv(places, rcond=1e-9).T
    return np.stack([ground, -share * np.arctan(slope[..., 0]), share * np.arctan(slope[..., 1])], axis=-1)


def base_reference(feet: Array, yaw: float, share: float = TILT_SHARE) -> BaseReference:
    """The reference of the base from its feet on the ground.

    Args:
        feet: lowest points of the rims, (n, 3), m; with fewer than three the slope is that along them.
        yaw: of the base, rad.
        share: of the slope that the base takes.
    """
    _, ground, slope = plane_of(np.asarray(feet, dtype=float))
    forward = slope @ np.array([np.cos(yaw), np.sin(yaw)])
    left = slope @ np.array([-np.sin(yaw), np.cos(yaw)])
    return BaseReference(ground, -share * float(np.arctan(forward)), share * float(np.arctan(left)))
