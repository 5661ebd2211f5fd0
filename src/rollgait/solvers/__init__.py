"""From a nonlinear program to numbers: one adapter per solver, all with the same signature."""

from rollgait.solvers.solution import Iteration, Progress, Solution

SOLVER_NAMES = ("ipopt",)
"""Names under which a solver can be asked for."""

__all__ = ["SOLVER_NAMES", "Iteration", "Progress", "Solution"]
