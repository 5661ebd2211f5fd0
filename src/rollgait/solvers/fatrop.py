"""Fatrop through CasADi's nlpsol, with the NLP's own derivatives and structure.

Fatrop wants the stages in order, x0 u0 x1 u1 …, and for each the rows that define the next state before the
others; that is how the condensed transcription numbers them.
"""

from __future__ import annotations

import logging
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.errors import InputError
from rollgait.solvers.fatrop_direct import DirectFatrop
from rollgait.solvers.fatrop_library import InterfaceError
from rollgait.solvers.interrupt import deferred_interrupt
from rollgait.solvers.linear_algebra import use_fast_products
from rollgait.solvers.solution import Progress, Solution
from rollgait.transcription.base import Structure, Transcribed
from rollgait.transcription.nlp import Nlp, named_functions

log = logging.getLogger("rollgait")

OPTIONS: dict[str, Any] = {
    "print_level": 0,
    "tol": 1e-5,
    "max_iter": 300,
    "mu_init": 0.1,
    "kappa_wmin": 0.1,  # lets the regularisation decay faster
}


WARM_OPTIONS: dict[str, Any] = {"mu_init": 1e-2}
"""For a guess near the solution: the barrier starts low, or it would push the guess away from its bounds."""

OUTPUTS = {"nlp_grad_f": ("grad_f_x",), "nlp_hess_l": ("grad_gamma_x", "hess_gamma_x_x")}
"""Names of outputs where this plugin asks for others than the rest do."""


def make_solver(transcribed: Transcribed, kernels: bool = True) -> Fatrop | DirectFatrop:
    """Fatrop for a transcribed problem: called directly, or by nlpsol if its library is not the expected one.

    Raises:
        InputError: the transcription has no stages.
    """
    structure = transcribed.structure
    if structure is None:
        rule = f"cannot solve the transcription {transcribed.name!r}"
        raise InputError("solver", "fatrop", rule, ["ipopt"])
    if kernels:
        use_fast_products()
    try:
        return DirectFatrop(transcribed.nlp, structure, OPTIONS, WARM_OPTIONS)
    except InterfaceError as error:
        log.info("%s: calling it through CasADi, which is slower", error)
        return Fatrop(transcribed.nlp, structure)


class Fatrop:
    """A solver for one NLP with stages, built once."""

    name = "fatrop"

    def __init__(self, nlp: Nlp, structure: Structure, options: dict[str, Any] | None = None) -> None:
        self.nlp = nlp
        self._structure = structure
        self._options = options or {}
        self._cache = self._derivatives()
        self._solver = self._make(self._options)

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
        self, guess: NDArray[np.float64], progress: Progress | None = None, warm: bool = False
    ) -> Solution:
        """The solution from a guess of the free variables; `warm` says that the guess is near a solution.

        (`progress` hears nothing: fatrop reports at the end.)

        Raises:
            KeyboardInterrupt: the user interrupted it.
        """
        nlp = self.nlp
        if warm:  # nlpsol takes its options once
            self._solver = self._make(WARM_OPTIONS | self._options)
        with deferred_interrupt():
            result = self._solver(
                x0=guess, p=nlp.parameters, lbx=nlp.lower, ubx=nlp.upper, lbg=nlp.g_lower, ubg=nlp.g_upper
            )
        return Solution.of_nlpsol(result, self._solver.stats())
