"""How much a solve may take: a time at which it is over, a number of iterations, more where needed."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass


@dataclass(frozen=True)
class Repair:
    """Iterations beyond those asked for, as long as they leave too much.

    Attributes:
        above: largest violation of a constraint (scaled as the solver sees it) that needs none.
        iterations: most that are made altogether.
    """

    above: float
    iterations: int


def most_iterations(iterations: int | None, repair: Repair | None) -> int | None:
    """How many may be made at most; None for as many as it takes."""
    return iterations if iterations is None or repair is None else max(iterations, repair.iterations)


class Budget:
    """Counts from now on.

    Args:
        until: no iteration begins that would end later, a time of `time.perf_counter`, s.
        iterations: no more than these; None for as many as the solver's options allow.
        repair: when there may be more.
    """

    def __init__(
        self, until: float = math.inf, iterations: int | None = None, repair: Repair | None = None
    ) -> None:
        self._until = until
        self._iterations = math.inf if iterations is None else iterations
        self._repair = repair
        self._began = time.perf_counter()

    def allows_another(self, after: int, violation: float = 0.0) -> bool:
        """Whether one more iteration may follow, if it takes as long as the one before. Ask once in each.

        Args:
            after: how many iterations.
            violation: largest of a constraint that they leave; may be NaN.
        """
        now = time.perf_counter()
        ends = 2.0 * now - self._began
        self._began = now
        most = self._iterations
        if self._repair is not None and not violation <= self._repair.above:
            most = max(most, self._repair.iterations)
        return after < most and ends <= self._until
