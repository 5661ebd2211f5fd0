"""What the ground under its feet asks of the base."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from rollgait.terrain.polygons import Array
from rollgait.terrain.terrain import plane_of

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
