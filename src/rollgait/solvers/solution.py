"""What a solver reports, while it runs and when it is done."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.transcription.base import Program


@dataclass(frozen=True)
class Iteration:
    """One iteration: its number, the cost, the largest violation of a constraint (scaled), and what for."""

    number: int
    cost: float
    violation: float
    task: str = "solving"


Progress = Callable[[Iteration], None]
"""Is called after each iteration."""


def saying(task: str, progress: Progress | None) -> Progress | None:
    """Progress that says what the iterations are for."""
    if progress is None:
        return None
    return lambda iteration: progress(replace(iteration, task=task))


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
        multipliers: of rows and of bounds, where the solver tells them: the gradient of cost + multipliers ·
            (g, w) is zero at the solution, and those of upper limits are positive.
    """

    w: NDArray[np.float64]
    g: NDArray[np.float64]
    cost: float
    solved: bool
    status: str
    iterations: int
    multipliers: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None

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


def largest_violation(nlp: Program, w: NDArray[np.float64]) -> float:
    """Of constraints and bounds of a program, at free variables, with its numbers of now; may be NaN."""
    g = np.asarray(nlp.functions["nlp_g"](w, nlp.parameters)).ravel()
    return float(nlp.violations(g, w).max(initial=0.0))
