"""How much a solve may take: a time at which it is over, and a number of iterations."""

from __future__ import annotations

import math
import time


class Budget:
    """Counts from now on.

    Args:
        until: no iteration begins that would end later, a time of `time.perf_counter`, s.
        iterations: no more than these; None for as many as the solver's options allow.
    """

    def __init__(self, until: float = math.inf, iterations: int | None = None) -> None:
        self._until = until
        self._iterations = math.inf if iterations is None else iterations
        self._began = time.perf_counter()

    def allows_another(self, after: int, last_runs: bool = False) -> bool:
        """Whether one more iteration may follow, if it takes as long as the one before. Ask once in each.

        Args:
            after: how many iterations.
            last_runs: whether the last of these has only begun.
        """
        now = time.perf_counter()
        ends = now + (2.0 if last_runs else 1.0) * (now - self._began)
        self._began = now
        return after < self._iterations and ends <= self._until
