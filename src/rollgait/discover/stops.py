"""Where wheels that can be steered come to a stop of their steering on the way of a base.

A wheel rolls along its track forwards or backwards: relative to the base its heading is the direction of the
track or half a turn beside it. As the base turns on its way, the heading that was begun with may leave the
range of the steering, though another is within it. In the air the wheel can turn to that one.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from rollgait.discover.crossings import Crossing
from rollgait.footing.footing import FEET, Array
from rollgait.footing.route import BaseWay

TOLERANCE: Final = np.radians(1.0)
"""By so much a heading may be beyond the range, rad: tracks are made of chords."""
STANDING: Final = 0.1
"""A foot that moves by less than this part of what the fastest one does may turn where it is."""


def stops(way: BaseWay, stance: Array, ranges: Sequence[tuple[float, float]]) -> list[Crossing]:
    """All stops on the way of a base, as steps, in the order of their middles.

    Between two poses the heading must not jump; at the poses the wheels may turn where they are.

    Args:
        way: of the base.
        stance: nominal places of the feet, base-yaw frame, (4, 2) or (4, 3), m.
        ranges: of the headings relative to the base, (4, 2), rad; infinite for feet that need not steer.

    Returns:
        Where a heading ends and another is within the range, a step on the spot; where none is, one from the
        place where the last was to where the next is.
    """
    moved = np.stack([np.diff(way.foot(way.s, stance[leg]), axis=0) for leg in range(FEET)])
    fastest = np.linalg.norm(moved, axis=-1).max(axis=0)
    yaw = 0.5 * (way.pose[1:, 2] + way.pose[:-1, 2])
    result = []
    for leg in range(FEET):
        moves = np.linalg.norm(moved[leg], axis=-1) > STANDING * fastest
        heading = np.arctan2(moved[leg, :, 1], moved[leg, :, 0]) - yaw
        for first, last in pairwise(np.searchsorted(way.s, np.arange(way.s[-1] + 1.5)).tolist()):
            here = slice(first, last)
            found = _stops(heading[here], moves[here], *ranges[leg])
            result += [Crossing(leg, float(way.s[first + a]), float(way.s[first + b])) for a, b in found]
    return sorted(result, key=lambda crossing: crossing.middle)


def _stops(heading: Array, moves: Array, low: float, high: float) -> list[tuple[int, int]]:
    """First and last place of each stop along n pieces of a track, places 0 … n."""
    if high - low >= 2.0 * np.pi:
        return []
    result: list[tuple[int, int]] = []
    begun: set[int] | None = None  # half turns by which a heading may differ that has been kept so far
    blocked: int | None = None
    unwrapped = np.unwrap(heading, period=np.pi)
    for k, angle in enumerate(unwrapped):
        if not moves[k]:
            begun = None
            continue
        first = int(np.ceil((low - TOLERANCE - angle) / np.pi))
        last = int(np.floor((high + TOLERANCE - angle) / np.pi))
        now = set(range(first, last + 1))
        if not now:
            blocked = k if blocked is None else blocked
            continue
        if blocked is not None:
            result.append((blocked, k))
        elif begun is not None and not begun & now:
            result.append((k, k))
            begun = None
        begun = now if begun is None or blocked is not None else begun & now
        blocked = None
    if blocked is not None:
        result.append((blocked, len(heading)))
    return result
