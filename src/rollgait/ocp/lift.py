"""The smooth lift of a foot in swing: the height that the profile `executable` follows.

Each half of the swing is a minimum-jerk rise or descent, so that the foot leaves and meets the ground at
rest and is at its full height at the node nearest to the middle, where the paper demands it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rollgait.scenario.schedule import ContactSchedule

Array = NDArray[np.float64]


def minimum_jerk(s: Array) -> tuple[Array, Array]:
    """Rise from 0 to 1 over s in [0, 1] at rest on both ends (clipped outside), and its derivative."""
    s = np.clip(s, 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2), 30.0 * s**2 * (1.0 - s) ** 2


def lift(schedule: ContactSchedule, clearance: float, times: Array) -> tuple[Array, Array]:
    """Height above the ground and its rate at times (n,) in s: two arrays (n, 4) in m and m/s."""
    height, rate = np.zeros((times.size, 4)), np.zeros((times.size, 4))
    for swing in schedule.swings():
        begin, middle, end = schedule.node_times[[swing.lift_off, swing.middle, swing.touch_down]]
        inside = (times >= begin) & (times <= end)
        rises = inside & (times < middle)
        for part, origin, length, sign in (
            (rises, begin, middle - begin, 1.0),
            (inside & ~rises, end, end - middle, -1.0),
        ):
            value, slope = minimum_jerk(sign * (times[part] - origin) / length)
            height[part, swing.leg] = clearance * value
            rate[part, swing.leg] = sign * clearance * slope / length
    return height, rate
