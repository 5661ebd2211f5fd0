"""The smooth lift of a foot in swing: the height that the profile `executable` follows.

Each half of the swing is a minimum-jerk rise or descent, so that the foot leaves and meets the ground at
rest and is at its full height at the node nearest to the middle, where the paper demands it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rollgait.footing.footing import SwingOver
from rollgait.scenario.schedule import ContactSchedule

Array = NDArray[np.float64]


def minimum_jerk(s: Array) -> tuple[Array, Array]:
    """Rise from 0 to 1 over s in [0, 1] at rest on both ends (clipped outside), and its derivative."""
    s = np.clip(s, 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2), 30.0 * s**2 * (1.0 - s) ** 2


def lift(
    schedule: ContactSchedule, clearance: float, times: Array, over: Sequence[SwingOver] = ()
) -> tuple[Array, Array]:
    """Height above the ground and its rate at times: two arrays (n, 4) in m and m/s.

    Args:
        schedule: the swings.
        clearance: height in their middle, m, above what is gone over.
        times: (n,), s.
        over: how high swings go that go over something: there the height is that above the ground which the
            foot leaves, and in the second half of the swing above that where it lands.
    """
    height, rate = np.zeros((times.size, 4)), np.zeros((times.size, 4))
    highs = {(s.leg, s.lift_off): s for s in over if s.over}
    for swing in schedule.swings():
        high = highs.get((swing.leg, swing.lift_off))
        rise, fall = (
            (clearance, clearance)
            if high is None
            else (high.clearance + high.top - high.before, high.clearance + high.top - high.after)
        )
        begin, middle, end = schedule.node_times[[swing.lift_off, swing.middle, swing.touch_down]]
        inside = (times >= begin) & (times <= end)
        rises = inside & (times < middle)
        for part, origin, length, sign, top in (
            (rises, begin, middle - begin, 1.0, rise),
            (inside & ~rises, end, end - middle, -1.0, fall),
        ):
            value, slope = minimum_jerk(sign * (times[part] - origin) / length)
            height[part, swing.leg] = top * value
            rate[part, swing.leg] = sign * top * slope / length
    return height, rate
