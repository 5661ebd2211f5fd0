"""IPOPT with MUMPS, through CasADi, with the NLP's own derivatives."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.solvers.budget import Budget, Repair, most_iterations
from rollgait.solvers.interrupt import deferred_interrupt
from rollgait.solvers.refusal import refuse_unsolvable
from rollgait.solvers.solution import Iteration, Progress, Solution, largest_violation
from rollgait.transcription.base import Program, Solvable

DERIVATIVES = ("nlp_f", "nlp_g", "nlp_grad_f", "nlp_jac_g", "nlp_hess_l", "nlp_grad")

OPTIONS: dict[str, Any] = {
    "print_time": False,
    "error_on_fail": False,
    "calc_lam_p": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    # MUMPS alone comes with the wheel; asking for HSL without having it can crash the process
    "ipopt.linear_solver": "mumps",
    "ipopt.mu_strategy": "adaptive",  # halves the iterations on this problem
    "ipopt.max_iter": 500,
    "ipopt.tol": 1e-6,
}


WARM_OPTIONS: dict[str, Any] = {"ipopt.mu_init": 1e-3, "ipopt.mu_strategy": "monotone"}
"""For a guess near the solution: the barrier starts low, or it would push the guess away from its bounds."""


def make_solver(transcribed: Solvable, kernels: bool = True) -> Ipopt:
    """IPOPT for a transcribed problem."""
    return Ipopt(transcribed.nlp)


class Ipopt:
    """A solver for one nonlinear program, built once."""

    name = "ipopt"
    linear_algebra = "MUMPS"
    real_time = False

    def __init__(self, nlp: Program, options: dict[str, Any] | None = None) -> None:
        self.nlp = nlp
        self._report = _Report(nlp)
        self._options = options or {}

    # nlpsol takes its options once: a solver for each set of them

    @cached_property
    def _cold(self) -> ca.Function:
        return self._make(self._options)

    @cached_property
    def _warm(self) -> ca.Function:
        return self._make(WARM_OPTIONS | self._options)

    def _make(self, options: dict[str, Any]) -> ca.Function:
        functions = self.nlp.functions
        own = {
            "cache": {name: functions[name] for name in DERIVATIVES},
            "iteration_callback": self._report,
        }
        return ca.nlpsol("ipopt", "ipopt", functions["nlp"], OPTIONS | own | options)

    def solve(
        self,
        guess: NDArray[np.float64],
        progress: Progress | None = None,
        warm: bool = False,
        until: float = math.inf,
        iterations: int | None = None,
        repair: Repair | None = None,
    ) -> Solution:
        """The solution from a guess of the free variables; `warm` says that the guess is near a solution.

        No iteration begins that would end after `until`, nor more than `iterations`; what there is then is
        returned, as not solved. Of a `repair` all iterations are made.

        Raises:
            NotSolvedError: the numbers are such that no solver is asked.
            KeyboardInterrupt: the user interrupted it.
        """
        nlp = self.nlp
        refuse_unsolvable(nlp, guess)
        solver = self._warm if warm else self._cold
        self._report.begin(progress, Budget(until, most_iterations(iterations, repair)))
        with deferred_interrupt() as self._report.stop:
            result = solver(
                x0=guess, p=nlp.parameters, lbx=nlp.lower, ubx=nlp.upper, lbg=nlp.g_lower, ubg=nlp.g_upper
            )
        if self._report.interrupted is not None:
            raise self._report.interrupted
        return Solution.of_nlpsol(result, solver.stats())

    def violation(self, w: NDArray[np.float64]) -> float:
        """Largest violation of a constraint at the free variables, for the NLP as it is now; may be NaN."""
        return largest_violation(self.nlp, w)


class _Report(ca.Callback):
    """Passes IPOPT's iterations on; an exception in there stops IPOPT and is raised after it."""

    def __init__(self, nlp: Program) -> None:
        ca.Callback.__init__(self)
        self._nlp = nlp
        self.stop: Callable[[], bool] = lambda: False
        self.begin(None, Budget())
        self.construct("report", {})

    def begin(self, progress: Progress | None, budget: Budget) -> None:
        """Another solve begins."""
        self.progress, self._budget = progress, budget
        self.interrupted: BaseException | None = None
        self.count = -1  # the first report is about the guess

    def get_n_in(self) -> int:
        return int(ca.nlpsol_n_out())

    def get_n_out(self) -> int:
        return 1

    def get_name_in(self, i: int) -> str:
        return str(ca.nlpsol_out(i))

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        sizes = {
            "f": 1,
            "x": self._nlp.size,
            "lam_x": self._nlp.size,
            "g": self._nlp.rows,
            "lam_g": self._nlp.rows,
        }
        return ca.Sparsity.dense(sizes.get(ca.nlpsol_out(i), 0), 1)

    def eval(self, arguments: Sequence[ca.DM]) -> list[int]:
        self.count += 1
        if self.stop():
            return [1]
        try:
            self._tell(arguments)
        except BaseException as error:
            self.interrupted = error
            return [1]
        return [int(not self._budget.allows_another(self.count))]

    def _tell(self, arguments: Sequence[ca.DM]) -> None:
        if self.progress is not None:
            values = {ca.nlpsol_out(i): a for i, a in enumerate(arguments)}
            violations = self._nlp.violations(
                np.asarray(values["g"]).ravel(), np.asarray(values["x"]).ravel()
            )
            self.progress(Iteration(self.count, float(values["f"]), float(violations.max(initial=0.0))))
