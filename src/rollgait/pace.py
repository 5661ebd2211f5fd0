"""Real time: a loop that waits for the clock on the wall, and slows down rather than jumps."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import Final

BACKLOG: Final = 0.05
"""A delay up to this is made good, s; of a longer one the rest is lost: time goes slower."""
WINDOW: Final = 1.0
"""Over so long the rate is measured, s."""


class Pace:
    """Waits between the rounds of a loop.

    Args:
        period: of a round, s.
        clock: seconds that only go on.
        sleep: waits some seconds.
    """

    def __init__(
        self,
        period: float,
        clock: Callable[[], float] = time.perf_counter,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._period, self._clock, self._sleep = period, clock, sleep
        self._due = clock()
        self._rounds: deque[float] = deque()

    def wait(self) -> None:
        """Waits until the next round is due."""
        self._due += self._period
        now = self._clock()
        if now < self._due:
            self._sleep(self._due - now)
        elif now - self._due > BACKLOG:
            self._due = now - BACKLOG
        self._rounds.append(self._clock())
        while self._rounds[-1] - self._rounds[0] > WINDOW:
            self._rounds.popleft()

    def restart(self) -> None:
        """After a pause: what was due is forgotten."""
        self._due = self._clock()
        self._rounds.clear()

    @property
    def rate(self) -> float:
        """Rounds per second over the last second, Hz; 0 before there were two."""
        if len(self._rounds) < 2:
            return 0.0
        return (len(self._rounds) - 1) / (self._rounds[-1] - self._rounds[0])

    @property
    def factor(self) -> float:
        """Simulated over wall time: 1 keeps up."""
        return self.rate * self._period
