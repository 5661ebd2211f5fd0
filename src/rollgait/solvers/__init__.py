"""From a nonlinear program to numbers: one adapter per solver, all with the same signature."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import UnknownNameError
from rollgait.solvers.solution import Iteration, Progress, Solution

if TYPE_CHECKING:
    from rollgait.transcription.base import Transcribed

SOLVER_NAMES = ("fatrop", "ipopt")
"""Names under which a solver can be asked for: each is a module here with a function `make_solver`."""


class Solver(Protocol):
    """A solver for one nonlinear program, built once."""

    name: str

    def solve(
        self, guess: NDArray[np.float64], progress: Progress | None = None, warm: bool = False
    ) -> Solution:
        """The solution from a guess of the free variables; `warm` says that the guess is near a solution."""


def make_solver(name: str, transcribed: Transcribed, kernels: bool = True) -> Solver:
    """The solver of this name, ready for a problem; with `kernels` it may compile what it needs.

    Raises:
        UnknownNameError: there is no such solver.
        InputError: the solver cannot work with this transcription.
    """
    if name not in SOLVER_NAMES:
        raise UnknownNameError("solver", name, SOLVER_NAMES)
    solver: Solver = import_module(f"rollgait.solvers.{name}").make_solver(transcribed, kernels)
    return solver


__all__ = ["SOLVER_NAMES", "Iteration", "Progress", "Solution", "Solver", "make_solver"]
