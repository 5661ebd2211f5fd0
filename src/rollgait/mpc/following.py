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
