"""IPOPT with MUMPS, through CasADi, with the NLP's own derivatives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.solvers.interrupt import deferred_interrupt
from rollgait.solvers.solution import Iteration, Progress, Solution
from rollgait.transcription.base import Program, Transcribed

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


def make_solver(transcribed: Transcribed, kernels: bool = True) -> Ipopt:
    """IPOPT for a transcribed problem."""
    return Ipopt(transcribed.nlp)


class Ipopt:
    """A solver for one nonlinear program, built once."""

    name = "ipopt"

    def __init__(self, nlp: Program, options: dict[str, Any] | None = None) -> None:
        self.nlp = nlp
        self._report = _Report(nlp)
        self._options = options or {}
        self._solver = self._make(self._options)

    def _make(self, options: dict[str, Any]) -> ca.Function:
        functions = self.nlp.functions
        own = {
            "cache": {name: functions[name] for name in DERIVATIVES},
            "iteration_callback": self._report,
        }
        return ca.nlpsol("ipopt", "ipopt", functions["nlp"], OPTIONS | own | options)

    def solve(
        self, guess: NDArray[np.float64], progress: Progress | None = None, warm: bool = False
    ) -> Solution:
        """The solution from a guess of the free variables; `warm` says that the guess is near a solution.

        Raises:
            KeyboardInterrupt: the user interrupted it.
        """
        nlp = self.nlp
        self._report.progress, self._report.interrupted = progress, None
        self._report.count = -1
        if warm:  # nlpsol takes its options once
            self._solver = self._make(WARM_OPTIONS | self._options)
        with deferred_interrupt() as self._report.stop:
            result = self._solver(
                x0=guess, p=nlp.parameters, lbx=nlp.lower, ubx=nlp.upper, lbg=nlp.g_lower, ubg=nlp.g_upper
            )
        if self._report.interrupted is not None:
            raise self._report.interrupted
        return Solution.of_nlpsol(result, self._solver.stats())


class _Report(ca.Callback):
    """Passes IPOPT's iterations on; an exception in there stops IPOPT and is raised after it."""

    def __init__(self, nlp: Program) -> None:
        ca.Callback.__init__(self)
        self._nlp = nlp
        self.progress: Progress | None = None
        self.interrupted: BaseException | None = None
        self.stop: Callable[[], bool] = lambda: False
        self.count = -1
        self.construct("report", {})

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
        if self.progress is None:
            return [0]
        try:
            values = {ca.nlpsol_out(i): a for i, a in enumerate(arguments)}
            violations = self._nlp.violations(
                np.asarray(values["g"]).ravel(), np.asarray(values["x"]).ravel()
            )
            self.progress(Iteration(self.count, float(values["f"]), float(violations.max(initial=0.0))))
        except BaseException as error:
            self.interrupted = error
            return [1]
        return [0]
