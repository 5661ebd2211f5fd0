"""When a robot counts as fallen: the same for every plant."""

from __future__ import annotations

from typing import Final

import numpy as np

FALLEN_TILT: Final = np.radians(45.0)
"""Tilt of the base at which the robot counts as fallen, rad."""
FALLEN_HEIGHT: Final = 0.5
"""Share of its height above the ground, as it should be, below which it counts as fallen."""


def is_fallen(up: float, height: float, nominal: float) -> bool:
    """Whether the robot has fallen. What is not a number counts as a fall.

    Args:
        up: cosine of the base's tilt.
        height: above the ground, m.
        nominal: as it should be, m.
    """
    return bool(not up >= np.cos(FALLEN_TILT) or not height >= FALLEN_HEIGHT * nominal)
