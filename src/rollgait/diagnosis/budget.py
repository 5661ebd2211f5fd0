"""How long may be looked for a reason: seconds and iterations, over all solvers that take part."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import TYPE_CHECKING, Final, TypedDict

from rollgait.errors import InputError

if TYPE_CHECKING:
    from rollgait.solvers.solution import Iteration, Progress

SECONDS: Final = 10.0
"""Of wall time, unless told otherwise: as long as a person waits for an answer."""
ITERATIONS: Final = 2000
"""Of all solvers together; usual diagnoses take some hundred."""


class Limits(TypedDict):
    """What a solver is told: until when (`time.perf_counter`, s), and how many iterations at the most."""

    until: float
    iterations: int | None


UNLIMITED: Final[Limits] = {"until": math.inf, "iterations": None}


class Budget:
    """What may be spent, and how much of it is left.

    Args:
        seconds: of wall time from `begin` on; infinite for no limit.
        iterations: of all solvers together.
        field: name under which the seconds were given.

    Raises:
        InputError: a number is not positive.
    """

    def __init__(
        self, seconds: float = SECONDS, iterations: int = ITERATIONS, field: str = "seconds"
    ) -> None:
        if not seconds > 0.0:  # not a number either
            raise InputError(field, seconds, "must be a positive number of seconds")
        if iterations < 1:
            raise InputError("iterations", iterations, "must be at least 1")
        self.seconds, self._left, self._until = seconds, iterations, math.inf

    def begin(self) -> None:
        """Time passes from now on."""
        self._until = time.perf_counter() + self.seconds

    def is_spent(self) -> bool:
        """Whether nothing is left."""
        return self._left <= 0 or time.perf_counter() >= self._until

    @property
    def limits(self) -> Limits:
        """What is left, for the next solver."""
        return {"until": self._until, "iterations": max(1, self._left)}

    def counting(self, task: str, progress: Progress | None) -> Progress:
        """Progress of a solver that takes part: each iteration is counted, and told with what it is for."""

        def report(iteration: Iteration) -> None:
            self._left -= 1
            if progress is not None:
                progress(replace(iteration, task=task))

        return report
