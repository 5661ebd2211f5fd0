"""When to take the steps that must be taken: one foot at a time, as early as the robot can."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from rollgait.discover.crossings import Crossing
from rollgait.footing.footing import Array
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario.gait import Schedule, Swing

SPEED: Final = 0.35
"""Mean speed of the base between steps, m/s: wheels that have just landed begin at rest."""
SWING: Final = 1.0
"""Length of a swing, s."""
SHIFT: Final = 0.4
"""Time between two swings in which the base moves over the feet that will stand, s."""
PAUSE: Final = 1.0
"""Time before the first swing, and after the last one, s."""


@dataclass(frozen=True)
class Pace:
    """How fast steps follow one another: speed in m/s, the others in s."""

    speed: float = SPEED
    swing: float = SWING
    shift: float = SHIFT
    pause: float = PAUSE

    def times(self, factor: float) -> Pace:
        """The pace that takes so many times the time."""
        return Pace(self.speed / factor, self.swing * factor, self.shift * factor, self.pause * factor)


@dataclass(frozen=True)
class Timed:
    """A gait in time.

    Attributes:
        gait: lift-offs and touch-downs.
        horizon: how long it all lasts, s.
        anchors: times (s) at which the base has gone some lengths (m), (n, 2).
    """

    gait: Schedule
    horizon: float
    anchors: Array

    def time_at(self, length: float) -> float:
        """When the base has gone a length (m), s."""
        return float(np.interp(length, self.anchors[:, 1], self.anchors[:, 0]))


def timed(
    crossings: Sequence[Crossing],
    s: Array,
    length: Array,
    pace: Pace,
    places: Sequence[float] | None = None,
) -> Timed:
    """The gait that takes all steps in their order, and how long it all lasts.

    Args:
        crossings: in their order.
        s: progress along the way, (m,).
        length: of the way there, (m,), m.
        pace: how fast.
        places: progress of the base in the middle of each step, rising; the middles of the crossings if not
            given.
    """
    swings: dict[str, tuple[Swing, ...]] = dict.fromkeys(LEG_NAMES, ())
    time, place = 0.0, 0.0
    free = pace.pause
    anchors = [(0.0, 0.0)]
    middles = [crossing.middle for crossing in crossings] if places is None else places
    for crossing, middle in zip(crossings, middles, strict=True):
        there = float(np.interp(middle, s, length))
        arrives = time + max(0.0, there - place) / pace.speed
        begin = max(arrives - 0.5 * pace.swing, free)
        name = LEG_NAMES[crossing.leg]
        swings[name] = (*swings[name], (round(begin, 6), round(begin + pace.swing, 6)))
        free = begin + pace.swing + pace.shift
        time, place = begin + 0.5 * pace.swing, max(place, there)
        anchors.append((time, place))
    rest = max(0.0, length[-1] - place) / pace.speed
    last = free - pace.shift if len(crossings) else 0.0
    horizon = float(np.ceil((max(time + rest, last) + pace.pause) * 10.0 - 1e-9) / 10.0)
    anchors.append((max(time + rest, last), float(length[-1])))
    gait = Schedule(FL=swings["FL"], FR=swings["FR"], HL=swings["HL"], HR=swings["HR"])
    return Timed(gait, horizon, np.array(anchors))
