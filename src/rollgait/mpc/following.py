"""Whether the robot does what it is told: who plans from states of long ago finds out by the feet."""

from __future__ import annotations

from typing import Final

import numpy as np

from rollgait.plant.control import Control
from rollgait.plant.state import RobotState

WINDOW: Final = 0.6
"""Time constant of the mean, s: longer than a step, so that what an estimator's noise does cancels."""
STOOD_MIN: Final = 2.0 * WINDOW
"""Feet that have stood for less, all together, say little: they count as if they had stood so long, s."""


PLACES: Final = ("com_position", "foot_position")
"""Parts of a state that are places, m."""
SETTLING: Final = 0.02
"""Slower than that a robot that stands may be told to settle, m/s: that does not count."""
MOVES: Final = (*PLACES, "euler", "heading")
"""Parts of a state that change while the robot moves."""


class Following:
    """How fast the feet on the ground move away from where they are told to go, a mean over feet and time.

    One period says little, as who believes a state begins anew from it. But wheels roll and steer as they are
    told, and those of a state one second old as they were told one second ago.

    Args:
        period: of the controller, s.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._keep = float(np.exp(-period / WINDOW))
        self.reset()

    def reset(self) -> None:
        """Forgets everything."""
        self._away, self._stood = np.zeros(2), 0.0

    def speed(self, state: RobotState, last: Control) -> float:
        """That speed with this state, which comes one period after a control, m/s."""
        away = (state.foot_position - last.end.foot_position)[last.contact, :2].sum(axis=0)
        self._away = self._keep * self._away + away
        self._stood = self._keep * self._stood + self._period * float(last.contact.sum())
        return float(np.hypot(*self._away)) / max(self._stood, STOOD_MIN)


class Unchanged:
    """How far the robot is told to go while its state stays the same to the last bit.

    What is measured never does; what a source that has stopped sends again and again does.

    Args:
        period: of the controller, s.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self.reset()

    def reset(self) -> None:
        """Forgets everything."""
        self._before: RobotState | None = None
        self._way = 0.0

    def way(self, state: RobotState, last: Control) -> float:
        """That way with this state, of the CoM or of the foot that goes farthest, m."""
        before, self._before = self._before, state
        if before is None or not all(
            np.array_equal(getattr(state, name), getattr(before, name)) for name in MOVES
        ):
            self._way = 0.0
            return 0.0
        steps = (getattr(last.end, name) - getattr(last.begin, name) for name in PLACES)
        way = max(float(np.linalg.norm(step, axis=-1).max()) for step in steps)
        self._way += way if way > SETTLING * self._period else 0.0
        return self._way
