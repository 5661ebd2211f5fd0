"""What a solver reports, while it runs and when it is done."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Iteration:
    """One iteration: its number, the cost, the largest violation of a constraint (scaled), and what for."""

    number: int
    cost: float
    violation: float
    task: str = "solving"


Progress = Callable[[Iteration], None]
"""Is called after each iteration."""


@dataclass(frozen=True)
class Solution:
    """What a solver found.

    Attributes:
        w: free variables of the NLP.
        g: its constraints there.
        cost: its cost there.
        solved: whether the solver converged.
        status: the solver's own word.
        iterations: how many it took.
    """

    w: NDArray[np.float64]
    g: NDArray[np.float64]
    cost: float
    solved: bool
    status: str
    iterations: int

    @classmethod
    def of_nlpsol(cls, result: Mapping[str, Any], stats: Mapping[str, Any]) -> Solution:
        """What CasADi's nlpsol returned, with its statistics."""
        return cls(
            w=np.asarray(result["x"]).ravel(),
            g=np.asarray(result["g"]).ravel(),
            cost=float(result["f"]),
            solved=bool(stats["success"]),
            status=str(stats["return_status"]),
            iterations=int(stats["iter_count"]),
        )
