"""From a nonlinear program to numbers: one adapter per solver, all with the same signature."""

from __future__ import annotations

import math
from importlib import import_module
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import InputError, UnknownNameError
from rollgait.solvers.budget import Repair
from rollgait.solvers.kernels import say_once
from rollgait.solvers.solution import Iteration, Progress, Solution

if TYPE_CHECKING:
    from rollgait.transcription.base import Solvable

SOLVER_NAMES = ("fatrop", "ipopt")
"""Names under which a solver can be asked for: each is a module here with a function `make_solver`."""


class Solver(Protocol):
    """A solver for one nonlinear program, built once. Its limits and parameters may change between solves.

    Attributes:
        name: of the solver, as a user says it.
        linear_algebra: what factorises its matrices.
        real_time: whether it keeps deadlines, and a single iteration from a near guess is of use.
    """

    name: str
    linear_algebra: str
    real_time: bool

    def solve(
        self,
        guess: NDArray[np.float64],
        progress: Progress | None = None,
        warm: bool = False,
        until: float = math.inf,
        iterations: int | None = None,
        repair: Repair | None = None,
    ) -> Solution:
        """The solution from a guess of the free variables, or what there is when it ends.

        Args:
            guess: free variables of the program.
            progress: is called after each iteration, by those that can.
            warm: whether the guess is near a solution.
            until: time of `time.perf_counter` at which it should be over, s.
            iterations: most that are made; as many as it takes if not given.
            repair: when there may be more; the best of them counts. Who keeps no deadline makes all of them.

        Raises:
            NotSolvedError: the numbers are such that no solver is asked: it might never come back.
        """

    def violation(self, w: NDArray[np.float64]) -> float:
        """Largest violation of a constraint at free variables, with the numbers of now; may be NaN."""


def make_solver(name: str, transcribed: Solvable, kernels: bool = True) -> Solver:
    """The solver of this name, ready for a problem; with `kernels` it may compile what it needs.

    Raises:
        UnknownNameError: there is no such solver.
        InputError: the solver cannot work with this transcription, or is not installed.
    """
    if name not in SOLVER_NAMES:
        raise UnknownNameError("solver", name, SOLVER_NAMES)
    solver: Solver = import_module(f"rollgait.solvers.{name}").make_solver(transcribed, kernels)
    return solver


def quickest_solver(transcribed: Solvable, kernels: bool = True) -> Solver:
    """The quickest solver that can be had here for a problem with stages; IPOPT is always there."""
    try:
        return make_solver("fatrop", transcribed, kernels)
    except InputError as error:
        say_once(f"{error}: solving with ipopt, which is slower")
        return make_solver("ipopt", transcribed, kernels)


__all__ = [
    "SOLVER_NAMES",
    "Iteration",
    "Progress",
    "Repair",
    "Solution",
    "Solver",
    "make_solver",
    "quickest_solver",
]
