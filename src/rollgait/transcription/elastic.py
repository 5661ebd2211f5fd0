"""A nonlinear program whose constraints may be missed, at a price: what is missed stands in the way.

    minimise c f(w) + Σ π (s + b s² / 2)   subject to   lower ≤ g(w) + U (s⁻ − s⁺) ≤ upper,  s ≥ 0

U holds the size of a usual miss, so that slacks are about 1; π is the price of each. The price of the first
unit is what drives most slacks to exactly zero (L1) and leaves the few that are needed; b makes large ones
dearer, so that a limit is missed by a little for some time rather than by much at once. Bounds of variables
that come from constraints are rows here, and may be missed as well.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.transcription.nlp import Nlp, RowOrigin, named_functions, violations_of

Array = NDArray[np.float64]
Index = NDArray[np.intp]

BEND = 0.2
"""b: a slack of ten usual misses costs twice its first price."""
START = 0.1
"""Slack at the start beyond what is missed there: interior-point methods begin inside their bounds."""

UsualMiss = Callable[[RowOrigin], float | None]
"""Size of a usual miss of a constraint, in the row's scaling; None where it must hold."""


class ElasticNlp:
    """The elastic variant of a program.

    Attributes:
        nlp: the program that it is the variant of.
        slack_origins: which constraint each slack belongs to.
        usual: U, size of one unit of each slack, in the row's scaling.
        prices: π, may be changed between solves.
        cost_factor: c.
    """

    def __init__(self, nlp: Nlp, usual_miss: UsualMiss, cost_factor: float) -> None:
        self.nlp = nlp
        self.cost_factor = cost_factor
        self._bounded = np.array([], dtype=np.intp)
        self.slack_origins: list[RowOrigin] = []
        self._slack_row: list[int] = []
        self._slack_sign: list[float] = []
        self._slack_size: list[float] = []
        usual: list[float] = []
        for row, origin in enumerate(nlp.origins):
            if (size := usual_miss(origin)) is not None:
                usual += self._add_slacks(row, origin, size, 1.0, nlp.g_lower[row], nlp.g_upper[row])
        self.lower, self.upper = nlp.lower.copy(), nlp.upper.copy()
        usual += self._relax_bounds(usual_miss)
        self.usual = np.array(usual)
        count = self.usual.size
        self.size, self.rows = nlp.size + count, nlp.rows + self._bounded.size
        self.prices = np.ones(count)
        self.lower = np.concatenate([self.lower, np.zeros(count)])
        self.upper = np.concatenate([self.upper, np.full(count, np.inf)])

    def _add_slacks(
        self, row: int, origin: RowOrigin, size: float, slope: float, low: float, high: float
    ) -> list[float]:
        """A slack for each side on which the row has a limit; their sizes."""
        signs = [sign for sign, limit in ((1.0, low), (-1.0, high)) if np.isfinite(limit)]
        self.slack_origins += [origin] * len(signs)
        self._slack_row += [row] * len(signs)
        self._slack_sign += signs
        self._slack_size += [size / slope] * len(signs)
        return [size] * len(signs)

    def _relax_bounds(self, usual_miss: UsualMiss) -> list[float]:
        """Makes rows of the bounds that may be missed."""
        nlp, usual, bounded, limits = self.nlp, list[float](), list[int](), [list[float](), list[float]()]
        for variable, origins in enumerate(zip(*nlp.bound_origins, strict=True)):
            sizes = [usual_miss(origin) if origin is not None else None for origin in origins]
            if all(size is None for size in sizes):
                continue
            row = nlp.rows + len(bounded)
            bounded.append(variable)
            for side, (own, sign) in enumerate(((self.lower, -1.0), (self.upper, 1.0))):
                origin, size = origins[side], sizes[side]
                if origin is None or size is None:
                    limits[side].append(sign * np.inf)
                    continue
                ends = (own[variable], np.inf) if side == 0 else (-np.inf, own[variable])
                limits[side].append(own[variable])
                usual += self._add_slacks(row, origin, size, origin.slope, *ends)
                own[variable] = sign * np.inf
        self._bounded = np.array(bounded, dtype=np.intp)
        self.g_lower = np.concatenate([nlp.g_lower, limits[0]])
        self.g_upper = np.concatenate([nlp.g_upper, limits[1]])
        return usual

    # -- to and from the program -------------------------------------------------------------------------

    def start(self, w: Array) -> Array:
        """Variables of the elastic program at free variables of the program: slacks cover what is missed."""
        g = np.asarray(self.nlp.functions["nlp_g"](w, self.nlp.parameters)).ravel()
        values = np.concatenate([g, w[self._bounded]])
        row, sign = np.array(self._slack_row, dtype=np.intp), np.array(self._slack_sign)
        beyond = np.where(sign > 0.0, self.g_lower[row] - values[row], values[row] - self.g_upper[row])
        missed = np.nan_to_num(np.maximum(beyond, 0.0) / np.array(self._slack_size))
        return np.concatenate([w, missed + START])

    def split(self, x: Array) -> tuple[Array, Array]:
        """Free variables of the program, and slacks in units of a usual miss."""
        return x[: self.nlp.size], x[self.nlp.size :]

    def violations(self, g: Array, w: Array) -> Array:
        """By how much each constraint, then each bound, is violated (0 where it holds)."""
        return violations_of(self, g, w)

    def limit_name(self, number: int) -> str:
        """What a constraint, or a bound, is about; numbered as in `violations`."""
        if number < self.nlp.rows:
            return self.nlp.limit_name(number)
        variable = self._bounded[number - self.nlp.rows] if number < self.rows else number - self.rows
        return self.nlp.limit_name(self.nlp.rows + variable) if variable < self.nlp.size else "a slack"

    # -- functions ---------------------------------------------------------------------------------------

    @property
    def parameters(self) -> Array:
        """The program's parameters, the factor of its cost, and the prices."""
        return np.concatenate([self.nlp.parameters, [self.cost_factor], self.prices])

    @cached_property
    def functions(self) -> dict[str, ca.Function]:
        """f, g and their derivatives as CasADi functions of (x, p), under the names that `nlpsol` uses."""
        nlp, own = self.nlp, self.nlp.functions
        rows, bounded, slacks = nlp.rows, self._bounded.tolist(), self.usual.size
        values = [sign * size for sign, size in zip(self._slack_sign, self._slack_size, strict=True)]
        per_slack = ca.DM.triplet(self._slack_row, list(range(slacks)), ca.DM(values), self.rows, slacks)
        picks = ca.DM.triplet(
            list(range(len(bounded))), bounded, ca.DM.ones(len(bounded)), len(bounded), nlp.size
        )
        x, p = ca.MX.sym("x", self.size), ca.MX.sym("p", self.parameters.size)
        lam_f, lam_g = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", self.rows)
        w, s = x[: nlp.size], x[nlp.size :]
        q, factor, prices = ca.vertsplit(
            p, [0, nlp.parameters.size, nlp.parameters.size + 1, self.parameters.size]
        )

        def cost(f: ca.MX) -> ca.MX:
            return factor * f + ca.dot(prices, s + 0.5 * BEND * s**2)

        def constraints(g: ca.MX) -> ca.MX:
            return ca.vertcat(g, w[bounded]) + ca.mtimes(per_slack, s)

        f, g = own["nlp"](w, q)
        f_again, gradient = own["nlp_grad_f"](w, q)
        g_again, jacobian = own["nlp_jac_g"](w, q)
        full_gradient = ca.vertcat(factor * gradient, prices * (1.0 + BEND * s))
        full_jacobian = ca.horzcat(ca.vertcat(jacobian, picks), per_slack)
        of_program = own["nlp_hess_l"](w, q, factor * lam_f, lam_g[:rows])
        hessian = ca.diagcat(of_program, ca.diag(lam_f * BEND * prices))
        of_lagrangian = lam_f * full_gradient + ca.mtimes(full_jacobian.T, lam_g)
        return named_functions(
            (x, p, lam_f, lam_g),
            {
                "nlp": [cost(f), constraints(g)],
                "nlp_f": [cost(own["nlp_f"](w, q))],
                "nlp_g": [constraints(own["nlp_g"](w, q))],
                "nlp_grad_f": [cost(f_again), full_gradient],
                "nlp_jac_g": [constraints(g_again), full_jacobian],
                "nlp_grad": [cost(f), constraints(g), of_lagrangian, ca.MX(1, p.numel())],
                "nlp_hess_l": [hessian],
            },
        )
