"""Fatrop through CasADi's nlpsol, with the NLP's own derivatives and structure.

Fatrop wants the stages in order, x0 u0 x1 u1 …, and for each the rows that define the next state before the
others; that is how the condensed transcription numbers them.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.errors import InputError
from rollgait.solvers.budget import Repair, most_iterations
from rollgait.solvers.fatrop_direct import DirectFatrop
from rollgait.solvers.fatrop_library import InterfaceError
from rollgait.solvers.interrupt import deferred_interrupt
from rollgait.solvers.kernels import say_once
from rollgait.solvers.linear_algebra import use_fast_products
from rollgait.solvers.refusal import refuse_unsolvable
from rollgait.solvers.solution import Progress, Solution, largest_violation
from rollgait.solvers.watched import NoAnswerError, call_watched
from rollgait.transcription.base import Solvable, Structure
from rollgait.transcription.nlp import Nlp, named_functions

log = logging.getLogger("rollgait")
Array = NDArray[np.float64]

OPTIONS: dict[str, Any] = {
    "print_level": 0,
    "tol": 1e-5,
    "max_iter": 300,
    "mu_init": 0.1,
    "bound_push": 1e-2,  # fatrop's own; told, as it keeps what a warm start told it
    "kappa_wmin": 0.1,  # lets the regularisation decay faster
}


WARM_OPTIONS: dict[str, Any] = {"mu_init": 1e-3, "bound_push": 1e-4}
"""For a guess near the solution: the barrier starts low, and slacks begin where the guess has them. A
hundredth off each bound, as fatrop begins, they contradict what the guess has right."""
REPAIR_OPTIONS: dict[str, Any] = WARM_OPTIONS | {"mu_init": 1e-2}
"""The same where one iteration has to do: with a lower barrier its step is cut short more often."""

OUTPUTS = {"nlp_grad_f": ("grad_f_x",), "nlp_hess_l": ("grad_gamma_x", "hess_gamma_x_x")}
"""Names of outputs where this plugin asks for others than the rest do."""


SECONDS_MAX = 120.0
"""s of processor time after which fatrop, called by CasADi, will not come back."""
OVERTIME_MAX = 1.0
"""The same after the time at which somebody waits for it."""


def make_solver(transcribed: Solvable, kernels: bool = True) -> Fatrop | DirectFatrop:
    """Fatrop for a transcribed problem: called directly, or by nlpsol if its library is not the expected one.

    Raises:
        InputError: the transcription has no stages, or this CasADi no fatrop.
    """
    structure = transcribed.structure
    if structure is None:
        rule = f"cannot solve the transcription {transcribed.name!r}"
        raise InputError("solver", "fatrop", rule, ["ipopt"])
    if kernels:
        use_fast_products()
    try:
        return DirectFatrop(transcribed.nlp, structure, OPTIONS, WARM_OPTIONS, REPAIR_OPTIONS, kernels)
    except InterfaceError as error:
        if not ca.has_nlpsol("fatrop"):
            raise InputError("solver", "fatrop", "is not part of this CasADi", ["ipopt"]) from None
        say_once(f"{error}: calling it through CasADi, which is slower")
        return Fatrop(transcribed.nlp, structure)


class Fatrop:
    """A solver for one NLP with stages, built once.

    CasADi tells nothing while fatrop runs, so that it cannot be stopped: neither Ctrl-C nor a deadline ends
    it before it is done. Who waits for it is bounded by its number of iterations, and beyond that by
    `SECONDS_MAX` of processor time, after which it is left behind.
    """

    name = "fatrop"
    linear_algebra = "BLASFEO"
    real_time = False

    def __init__(self, nlp: Nlp, structure: Structure, options: dict[str, Any] | None = None) -> None:
        self.nlp = nlp
        self._structure = structure
        self._options = options or {}
        self._cache = self._derivatives()
        self._made: dict[tuple[bool, int | None], ca.Function] = {}

    def _solver(self, warm: bool, iterations: int | None) -> ca.Function:
        """With these options, which nlpsol takes once. Making it is slow: few numbers should be asked for."""
        key = (warm, iterations)
        if key not in self._made:
            # of `max_iter` 0 fatrop makes none and of 1 two
            limit = {} if iterations is None else {"max_iter": max(1, iterations - 1)}
            self._made[key] = self._make((WARM_OPTIONS if warm else {}) | self._options | limit)
        return self._made[key]

    def _make(self, options: dict[str, Any]) -> ca.Function:
        structure = self._structure
        return ca.nlpsol(
            "fatrop",
            "fatrop",
            self.nlp.functions["nlp"],
            {
                "structure_detection": "manual",
                "N": len(structure.nx) - 1,
                "nx": list(structure.nx),
                "nu": list(structure.nu),
                "ng": list(structure.ng),
                "cache": self._cache,
                "fatrop": OPTIONS | options,
                "print_time": False,
                "error_on_fail": False,
                "calc_lam_p": False,
            },
        )

    def _derivatives(self) -> dict[str, ca.Function]:
        """The derivatives as this plugin asks for them: the Hessian in full, with the gradient."""
        nlp, f = self.nlp, self.nlp.functions
        x, p = ca.MX.sym("x", nlp.size), ca.MX.sym("p", nlp.parameters.size)
        lam_f, lam_g = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", nlp.rows)
        gradient = f["nlp_grad_f"](x, p)[1]
        jacobian = f["nlp_jac_g"](x, p)[1]
        of_lagrangian = lam_f * gradient + ca.mtimes(jacobian.T, lam_g)
        hessian = ca.triu2symm(f["nlp_hess_l"](x, p, lam_f, lam_g))
        own = {"nlp_grad_f": [gradient], "nlp_hess_l": [of_lagrangian, hessian]}
        unchanged = {name: f[name] for name in ("nlp_f", "nlp_g", "nlp_grad", "nlp_jac_g")}
        return unchanged | named_functions((x, p, lam_f, lam_g), own, OUTPUTS)

    def solve(
        self,
        guess: Array,
        progress: Progress | None = None,
        warm: bool = False,
        until: float = math.inf,
        iterations: int | None = None,
        repair: Repair | None = None,
    ) -> Solution:
        """The solution from a guess of the free variables; `warm` says that the guess is near a solution.

        At most `iterations` are made (two, if one is asked for), of a `repair` all. `progress` hears nothing:
        fatrop reports at the end; nor does `until` end it, but `OVERTIME_MAX` later it is left behind.

        Raises:
            NotSolvedError: the numbers are such that no solver is asked.
            KeyboardInterrupt: the user interrupted it.
        """
        nlp = self.nlp
        refuse_unsolvable(nlp, guess)
        solver = self._solver(warm, most_iterations(iterations, repair))
        limits = {"lbx": nlp.lower, "ubx": nlp.upper, "lbg": nlp.g_lower, "ubg": nlp.g_upper}
        call: Callable[[], Any] = partial(solver, x0=guess, p=nlp.parameters, **limits)
        patience = min(SECONDS_MAX, max(0.0, until - time.perf_counter()) + OVERTIME_MAX)
        try:
            with deferred_interrupt():
                result = call_watched(call, lambda: 0, patience)
        except NoAnswerError as error:
            log.warning("fatrop does not come back (%s): it is left behind", error)
            self._made.clear()
            return self._as_it_was(guess)
        return Solution.of_nlpsol(result, solver.stats())

    def _as_it_was(self, guess: Array) -> Solution:
        f, g = (np.asarray(v).ravel() for v in self.nlp.functions["nlp"](guess, self.nlp.parameters))
        return Solution(guess.copy(), g, float(f[0]), solved=False, status="No_Answer", iterations=0)

    def violation(self, w: Array) -> float:
        """Largest violation of a constraint at the free variables, for the NLP as it is now; may be NaN."""
        return largest_violation(self.nlp, w)
