"""Where base and feet go when the steps are given and feet cannot roll everywhere.

The base goes on so far that each foot keeps to its box until its next step, and where an edge is before a
foot, so far that its next step leads beyond.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from rollgait.footing.carried import AHEAD, STEP, Carried, Feet, StuckError, carried_ways
from rollgait.footing.footing import FEET, Array, Index
from rollgait.ocp.lift import minimum_jerk
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule

SMOOTH: Final = 0.4
"""s, over which the progress of the base is smoothed: a body does not jerk."""
SHORT: Final = 0.1
"""s of the way, by which a base may miss the end of its way: that is the solver's to mend."""


def stepping_route(scenario: Scenario, schedule: ContactSchedule) -> tuple[Array, Array]:
    """Poses (x, y, yaw) of the base (N + 1, 3) and places of the feet (N + 1, 4, 2) at the nodes, m, rad."""
    best: tuple[float, Array, Array] | None = None
    for way in carried_ways(scenario):
        gone, at, arc = _progress(schedule, way)
        share = gone[-1] / way.duration if way.duration > 0.0 else 1.0
        if best is None or share > best[0] + 1e-6:  # of ways as good as each other the first
            gone = gone / share if 0.0 < share < 1.0 else gone
            best = (share, *_paths(schedule, way, _smoothed(schedule.node_times, gone), at, arc))
    assert best is not None, "there is a direct way"
    return best[1], best[2]


def route_along(way: Carried, schedule: ContactSchedule) -> tuple[Array, Array] | None:
    """The same along a way over any ground; None where these steps do not lead to its end."""
    try:
        gone, at, arc = _progress(schedule, way, in_time=True)
    except StuckError:
        return None
    if gone[-1] < way.duration - SHORT:
        return None
    return _paths(schedule, way, _smoothed(schedule.node_times, gone), at, arc)


def _progress(schedule: ContactSchedule, way: Carried, in_time: bool = False) -> tuple[Array, Index, Index]:
    """How far the base is at the nodes, (N + 1,), s; where feet are nominal, and in which arc, (N + 1, 4).

    Args:
        schedule: the contacts.
        way: of the base.
        in_time: whether the base hurries to where a foot needs it that lands beyond an edge, or for good.
    """
    times, contact = schedule.node_times, schedule.contact
    swings = list(schedule.swings())
    last = {swing.leg: swing.lift_off for swing in swings}  # where feet have to end is known
    feet, gone = Feet(way), np.zeros(times.size)
    at, arc = np.zeros((2, times.size, FEET), dtype=np.intp)
    rate, most = 1.0, way.duration
    for k in range(schedule.intervals):
        for swing in swings:
            if swing.touch_down == k:
                feet.land(swing.leg, float(gone[k]), swing.lift_off == last[swing.leg])
        at[k], arc[k] = feet.at, feet.arc
        if k == 0 or (contact[:, k] != contact[:, k - 1]).any():
            rate, most = 1.0, way.duration
            for leg in np.flatnonzero(contact[:, k]):
                until = feet.keeps_until(int(leg), float(gone[k]))
                lifts = [times[w.lift_off] for w in swings if w.leg == leg and w.lift_off > k]
                left = min(lifts, default=times[-1]) - times[k]
                most = min(most, until)
                if left < AHEAD:
                    rate = min(rate, max(0.0, until - gone[k]) / left)
            for swing in swings if in_time else ():
                if swing.lift_off <= k < swing.touch_down:
                    needed = feet.lands_from(swing.leg, float(gone[k]))
                    if swing.lift_off == last[swing.leg]:
                        needed = max(needed, feet.may_settle(swing.leg))
                    rate = max(rate, (needed - gone[k]) / (times[swing.touch_down] - times[k]))
        there = min(most, way.open_until(times[k]), gone[k] + rate * schedule.lengths[k])
        gone[k + 1] = max(gone[k], there)
    for swing in swings:
        if swing.touch_down == schedule.intervals:
            feet.land(swing.leg, float(gone[-1]), for_good=True)
    at[-1], arc[-1] = feet.at, feet.arc
    return gone, at, arc


def _paths(
    schedule: ContactSchedule, way: Carried, gone: Array, at: Index, arc: Index
) -> tuple[Array, Array]:
    """Base and feet at the nodes."""
    times, number = schedule.node_times, np.arange(len(way.base)) * STEP

    def there(values: Array) -> Array:
        return np.stack([np.interp(gone, number, column) for column in values.T], axis=-1)

    base = there(way.base)
    c, s = np.cos(base[:, 2]), np.sin(base[:, 2])
    feet = np.stack([there(way.nominal[:, leg]) for leg in range(FEET)], axis=1)
    for leg in range(FEET):
        for nominal_at, own in np.unique(np.stack([at[:, leg], arc[:, leg]], axis=-1), axis=0):
            here = (at[:, leg] == nominal_at) & (arc[:, leg] == own)
            x, y = there(way.offsets(leg, int(nominal_at), slice(None), int(own)))[here].T
            feet[here, leg] += np.stack([c[here] * x - s[here] * y, s[here] * x + c[here] * y], axis=-1)
    for swing in schedule.swings():
        begin, end = swing.lift_off, swing.touch_down
        value = minimum_jerk((times[begin : end + 1] - times[begin]) / (times[end] - times[begin]))[0]
        first, last = feet[begin, swing.leg], feet[end, swing.leg]
        feet[begin : end + 1, swing.leg] = first + value[:, None] * (last - first)
    return base, feet


def _smoothed(times: Array, gone: Array) -> Array:
    even = np.linspace(times[0], times[-1], len(times))
    width = max(1, round(0.5 * SMOOTH / (even[1] - even[0])))
    kernel = np.hanning(2 * width + 3)[1:-1]
    padded = np.pad(np.interp(even, times, gone), width, mode="reflect", reflect_type="odd")
    return np.asarray(np.interp(times, even, np.convolve(padded, kernel / kernel.sum(), mode="valid")))
