"""The smooth lift of a foot in swing: the height that the profile `executable` follows.

Each half of the swing is a minimum-jerk rise or descent, so that the foot leaves and meets the ground at
rest and is at its full height at the node nearest to the middle, where the paper demands it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollgait.footing.footing import SwingOver
from rollgait.scenario.schedule import ContactSchedule, SwingPhase

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class InAir:
    """Feet at t = 0: height above the ground that they come from, (4,), m, and how fast they rise, m/s."""

    height: Array
    rate: Array


def minimum_jerk(s: Array) -> tuple[Array, Array]:
    """Rise from 0 to 1 over s in [0, 1] at rest on both ends (clipped outside), and its derivative."""
    s = np.clip(s, 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2), 30.0 * s**2 * (1.0 - s) ** 2


def lift(
    schedule: ContactSchedule,
    clearance: float,
    times: Array,
    over: Sequence[SwingOver] = (),
    in_air: InAir | None = None,
) -> tuple[Array, Array]:
    """Height above the ground and its rate at times: two arrays (n, 4) in m and m/s.

    Args:
        schedule: the swings.
        clearance: height in their middle, m, above what is gone over.
        times: (n,), s.
        over: how high swings go that go over something: there the height is that above the ground which the
            foot leaves, and in the second half of the swing above that where it lands.
        in_air: feet whose swings have begun before t = 0: these go on from there.
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
        if swing.begun > 0.0 and in_air is not None:
            inside = times <= schedule.node_times[swing.touch_down]
            found = _going_on(schedule, swing, (rise, fall), in_air, times[inside])
            height[inside, swing.leg], rate[inside, swing.leg] = found
            continue
        assert swing.middle is not None, "only a swing that has begun before t = 0 may be past its middle"
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


def _going_on(
    schedule: ContactSchedule, swing: SwingPhase, tops: tuple[float, float], in_air: InAir, times: Array
) -> tuple[Array, Array]:
    """Height and rate of a foot that is in the air at t = 0 at times (n,) of its swing, both (n,).

    From where it is and as fast as it rises to its full height, if the middle is yet to come, and down, at
    rest at both; `tops` are that height above the ground before and after.
    """
    end = float(schedule.node_times[swing.touch_down])
    here, rate = float(in_air.height[swing.leg]), float(in_air.rate[swing.leg])
    if swing.middle is None:
        return _quintic(times, end, here, rate, 0.0)
    middle = float(schedule.node_times[swing.middle])
    rises = times < middle
    height, speed = _quintic(times, middle, here, rate, tops[0])
    falls, fall_rate = minimum_jerk((end - times) / (end - middle))
    return np.where(rises, height, tops[1] * falls), np.where(
        rises, speed, -tops[1] * fall_rate / (end - middle)
    )


def _quintic(
    times: Array, end: float, begin_value: float, begin_rate: float, end_value: float
) -> tuple[Array, Array]:
    """From a value and a rate at 0, not accelerated, to a value at rest at `end`: values and rates, (n,)."""
    s = np.clip(times / end, 0.0, 1.0)
    rise, slope = minimum_jerk(s)
    change, way = end_value - begin_value, begin_rate * end
    # s − 6 s³ + 8 s⁴ − 3 s⁵ begins with rate 1 and ends at rest
    value = begin_value + change * rise + way * (s - s**3 * (6.0 - s * (8.0 - 3.0 * s)))
    rate = change * slope + way * (1.0 - s**2 * (18.0 - s * (32.0 - 15.0 * s)))
    return value, rate / end
