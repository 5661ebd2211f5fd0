"""When the feet of a motion meet bends of the ground: there a mesh is cut, so that each interval is smooth.

A model of an interval is a quadratic. Over the foot of a ramp it is beside the ground by up to an eighth of
the change of slope times half the way, 1.7 mm at 15° and a way of 10 cm; with a node at the bend both sides
are planes, exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from rollgait.footing.footing import FEET, Array
from rollgait.terrain.regions import Regions

if TYPE_CHECKING:
    from rollgait.plan.samples import Samples
    from rollgait.scenario.schedule import ContactSchedule

BESIDE: Final = 3e-4
"""By how much the ground may be beside a quadratic before its interval is cut, m: three tenths of what the
certificate allows."""
PARTS: Final = 16
"""Parts of an interval between which the ground is looked at."""
NEAR_END: Final = 0.01
"""Part of an interval from whose heights its slope at an end is reckoned."""
CUTS: Final = 2
"""How often an interval is cut in two."""
APART: Final = 2e-3
"""s; nodes are no nearer to one another: a foot moves by two millimetres."""


def bends(regions: Sequence[Regions], schedule: ContactSchedule, motion: Callable[[Array], Samples]) -> Array:
    """Times at which feet in stance meet bends, (n,), s, apart from one another and from the nodes.

    Args:
        regions: of the foot of each leg.
        schedule: the contacts.
        motion: a motion as a function of time, (m,) in s.
    """
    found = [np.empty(0)]
    for leg in range(FEET):
        stands = np.flatnonzero(schedule.contact[leg])
        begin, end = schedule.node_times[stands], schedule.node_times[stands + 1]
        for _ in range(CUTS):
            at = _cuts(regions[leg], leg, begin, end, motion)
            cut = ~np.isnan(at)
            if not cut.any():
                break
            found.append(at[cut])
            begin, end = np.append(begin[cut], at[cut]), np.append(at[cut], end[cut])
    return _apart(np.sort(np.concatenate(found)), schedule.node_times)


def _cuts(region: Regions, leg: int, begin: Array, end: Array, motion: Callable[[Array], Samples]) -> Array:
    """Where each interval from `begin` to `end` is to be cut, (n,), s; NaN where its ground is smooth.

    That is where the lines meet that touch the ground at both its ends: a kink, or the middle of a bend.
    """
    share = np.concatenate([np.linspace(0.0, 1.0, PARTS + 1), [NEAR_END, 1.0 - NEAR_END]])
    times = begin[:, None] + share * (end - begin)[:, None]
    xy = motion(times.ravel()).foot_position[:, leg, :2]
    z = region.surface.height(*xy.T).reshape(times.shape)
    middle, last = PARTS // 2, PARTS
    first_slope = (z[:, -2] - z[:, 0]) / NEAR_END
    last_slope = (z[:, last] - z[:, -1]) / NEAR_END
    bend = 2.0 * (z[:, 0] - 2.0 * z[:, middle] + z[:, last])
    rise = z[:, last] - z[:, 0]
    u = share - 0.5
    quadratic = z[:, middle, None] + rise[:, None] * u + bend[:, None] * u**2
    beside = np.abs(z - quadratic).max(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        meet = (rise - last_slope) / (first_slope - last_slope)
    meet = np.where((meet > NEAR_END) & (meet < 1.0 - NEAR_END), meet, 0.5)
    return np.asarray(np.where(beside > BESIDE, begin + meet * (end - begin), np.nan))


def _apart(times: Array, nodes: Array) -> Array:
    """The mean of those that are nearer than `APART` to one another, without those so near to a node."""
    if not times.size:
        return times
    groups = np.split(times, np.flatnonzero(np.diff(times) > APART) + 1)
    means = np.array([group.mean() for group in groups])
    return np.asarray(means[np.abs(means[:, None] - nodes).min(axis=1) > APART])
