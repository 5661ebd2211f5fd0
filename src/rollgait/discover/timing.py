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


def timed(crossings: Sequence[Crossing], s: Array, length: Array, pace: Pace) -> tuple[Schedule, float]:
    """The gait that takes all steps in their order, and how long it all lasts (s).

    Args:
        crossings: in their order.
        s: progress along the way, (m,).
        length: of the way there, (m,), m.
        pace: how fast.
    """
    swings: dict[str, tuple[Swing, ...]] = dict.fromkeys(LEG_NAMES, ())
    time, place = 0.0, 0.0
    free = pace.pause
    for crossing in crossings:
        there = float(np.interp(crossing.middle, s, length))
        arrives = time + max(0.0, there - place) / pace.speed
        begin = max(arrives - 0.5 * pace.swing, free)
        name = LEG_NAMES[crossing.leg]
        swings[name] = (*swings[name], (round(begin, 6), round(begin + pace.swing, 6)))
        free = begin + pace.swing + pace.shift
        time, place = begin + 0.5 * pace.swing, max(place, there)
    rest = max(0.0, length[-1] - place) / pace.speed
    last = free - pace.shift if crossings else 0.0
    horizon = max(time + rest, last) + pace.pause
    gait = Schedule(FL=swings["FL"], FR=swings["FR"], HL=swings["HL"], HR=swings["HR"])
    return gait, float(np.ceil(horizon * 10.0) / 10.0)
