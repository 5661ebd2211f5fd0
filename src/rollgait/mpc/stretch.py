"""How much longer a second of simulated time takes on the wall: deadlines count in simulated time."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

WINDOW: Final = 0.5
"""Time constant of the mean, s of simulated time."""
STRETCH_MAX: Final = 50.0
"""A machine that is slower than that says nothing about controllers."""


class Stretch:
    """Wall time over simulated time, lately; 1 where a simulation keeps up with real time.

    Simulated time waits for the controller. Where a busy machine lets a simulation go slowly, a step that
    takes as much longer as all else is not late.

    Args:
        period: of simulated time between two updates, s.
        clock: seconds that only go on.
    """

    def __init__(self, period: float, clock: Callable[[], float] = time.perf_counter) -> None:
        self._period, self._clock = period, clock
        self._share = min(1.0, period / WINDOW)
        self._mean = 1.0
        self._last: float | None = None

    @property
    def factor(self) -> float:
        """Seconds of wall time in one of simulated time, at least 1."""
        return min(max(1.0, self._mean), STRETCH_MAX)

    def update(self) -> float:
        """Another period of simulated time begins; the factor."""
        now = self._clock()
        if self._last is not None:
            took = min((now - self._last) / self._period, STRETCH_MAX)
            self._mean += self._share * (took - self._mean)
        self._last = now
        return self.factor
