"""Turns by wheels that may slip sideways: how their rims run, and how they come to rest.

Sliding friction is against the slip. On a wheel at (a, b) from the base, ahead and to the left, whose rim
runs by u while the base turns at ω, it is along (u + b ω, −a ω), u ahead. Equal loads in a rectangle have no
moment about the base if Σ −b u = ω Σ (a² + b²): rims run faster than those of wheels that roll by
Σ (a² + b²) / Σ b². Friction is shared between along and across: where rims run faster still, a wheel slides
aside more easily, so that the base turns about a point farther from there.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TURN_GAIN: Final = 2.0
"""Share of a turn that sliding wheels take back per second, 1/s: nobody else does it."""

TURN_MAX: Final = 0.12
"""Largest rate of that, rad/s: rims that slide faster shake soft legs, and turn the base by less."""

ASIDE_GAIN: Final = 20.0
"""By how much faster, as a share, the rims of one end run per distance that the base is aside, 1/m."""

ASIDE_MAX: Final = 0.5
"""Largest such share."""

UNWIND_TIME: Final = 0.1
"""Time constant with which wheels are let go to where they are, s."""

LEAD_GAIN: Final = 5.0
"""Turn towards its way per distance aside from it of a base that drives, rad/m."""

LEAD_MAX: Final = 0.05
"""Largest such turn, rad: it is to be taken back at the end, slowly."""

DRIVES: Final = 0.05
"""m/s; at this speed half of it is made: a turn leads nowhere while the base does not drive."""

TINY: Final = 1e-6
"""m²; keeps rates finite where all wheels are in one line."""


def turning_rims(lever: Array, turned_by: float, aside: float) -> Array:
    """Speeds of the rims that turn the base by sliding, (4,), m/s.

    Args:
        lever: from the base to the wheels, ahead and to the left along their shared heading, (4, 2), m.
        turned_by: the turn that is missing, rad.
        aside: how far to the left the base should be of where it is, m.
    """
    rate = float(np.clip(TURN_GAIN * turned_by, -TURN_MAX, TURN_MAX))
    faster = np.sum(lever**2) / max(float(np.sum(lever[:, 1] ** 2)), TINY)
    share = np.clip(ASIDE_GAIN * aside * np.sign(rate), -ASIDE_MAX, ASIDE_MAX)
    return np.asarray(-faster * rate * lever[:, 1] * (1.0 + share * np.sign(lever[:, 0])))


def leading(aside: float, speed: float) -> float:
    """The turn by which a base that drives gets back to its way, rad.

    Args:
        aside: how far to the left the base should be of where it is, m.
        speed: with which it drives ahead, m/s.
    """
    turn = float(np.clip(LEAD_GAIN * aside, -LEAD_MAX, LEAD_MAX))
    return turn * speed / (abs(speed) + DRIVES)


def unwinding(wound: Array) -> Array:
    """Rates that let wheels at rest go to where they are, (4,), rad/s.

    Wheels that slid against one another stick where they stop, and would hold the legs strained and the base
    tilted.

    Args:
        wound: by what they are turned less far than asked, (4,), rad.
    """
    return -wound / UNWIND_TIME
