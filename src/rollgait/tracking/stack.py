"""Strict priorities: of all steps that serve the upper levels best, the one that serves the next level best.

Level by level, min ‖A_k x − b_k‖ over x = x_k + Z_k y, where Z_k spans what the levels above leave free, so
that a lower level never moves a higher one. Without bounds each level is one singular value decomposition. If
the step found so lies within the bounds it is the answer with bounds too, as every level has its optimum;
only otherwise each level becomes a quadratic program, solved by daqp, or by piqp if that fails.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Level = tuple[Array, Array]
"""A level: A of shape (rows, n), b of shape (rows,)."""

RANK_TOLERANCE: Final = 1e-4
"""Singular values below this share of the level's largest are zero: the level cannot be served there."""

BOUND_TOLERANCE: Final = 1e-9
"""By how much a bound may be exceeded by rounding, rad or m."""

ACCEPTED_EXCESS: Final = 1e-6
"""By how much a solver may leave a bound before its answer counts as a failure, rad or m; it is cut off."""

REGULARISATION: Final = 1e-8
"""Of the quadratic programs, on the square of the free step: below any effect, above rounding."""


@dataclass(frozen=True)
class Step:
    """The answer of a stack.

    Attributes:
        x: the step, shape (n,).
        bounded: whether a bound made quadratic programs necessary.
        failed: numbers of the levels that no solver could serve and that fell back to the levels above,
            from 0.
    """

    x: Array
    bounded: bool = False
    failed: tuple[int, ...] = ()


def solve(levels: Sequence[Level], lower: Array, upper: Array) -> Step:
    """The step that serves the levels in strict order within its bounds.

    Args:
        levels: the most important first; the step of smallest norm is taken if they leave a choice.
        lower: smallest step, shape (n,); −inf where there is none.
        upper: largest step, shape (n,).
    """
    x = _unbounded(levels, len(lower))
    if np.all(x >= lower - BOUND_TOLERANCE) and np.all(x <= upper + BOUND_TOLERANCE):
        return Step(x)
    return _bounded(levels, lower, upper)


def _unbounded(levels: Sequence[Level], n: int) -> Array:
    x, Z = np.zeros(n), np.eye(n)
    for A, b in levels:
        if Z.shape[1] == 0:
            break
        y, free = _best(A @ Z, b - A @ x)
        x = x + Z @ y
        Z = Z @ free
    return x


def _bounded(levels: Sequence[Level], lower: Array, upper: Array) -> Step:
    """As `_unbounded`, each level a quadratic program. A level that fails takes no part, and is named."""
    n = len(lower)
    x = np.clip(np.zeros(n), lower, upper)  # a joint beyond its limit is led back before anything else
    Z = np.eye(n)
    failed = []
    for number, (A, b) in enumerate(levels):
        if Z.shape[1] == 0:
            break
        AZ, rest = A @ Z, b - A @ x
        y = _program(AZ, rest, Z, lower - x, upper - x)
        if y is None:
            failed.append(number)
            continue
        x = x + Z @ y
        Z = Z @ _best(AZ, rest)[1]
    return Step(np.clip(x, lower, upper), True, tuple(failed))


def _best(A: Array, b: Array) -> tuple[Array, Array]:
    """Least-squares solution of smallest norm, and a basis of the null space, shape (n, free)."""
    if A.shape[0] == 0:
        return np.zeros(A.shape[1]), np.eye(A.shape[1])
    U, s, Vt = np.linalg.svd(A, full_matrices=True)
    rank = int(np.sum(s > RANK_TOLERANCE * max(float(s[0]), 1e-12)))
    y = Vt[:rank].T @ ((U[:, :rank].T @ b) / s[:rank])
    return y, Vt[rank:].T


def _program(A: Array, b: Array, Z: Array, lower: Array, upper: Array) -> Array | None:
    """min ‖A y − b‖² + ε ‖y‖² with lower ≤ Z y ≤ upper; None if neither solver finds it."""
    H = A.T @ A + REGULARISATION * np.eye(A.shape[1])
    f = -A.T @ b
    limited = np.isfinite(lower) | np.isfinite(upper)
    C, low, high = Z[limited], lower[limited], upper[limited]
    for solver in (_daqp, _piqp):
        y = solver(H, f, C, low, high)
        if y is not None and np.all(np.isfinite(y)):
            place = C @ y
            if np.all(place <= high + ACCEPTED_EXCESS) and np.all(place >= low - ACCEPTED_EXCESS):
                return y
    return None


def _daqp(H: Array, f: Array, C: Array, lower: Array, upper: Array) -> Array | None:
    import daqp

    big = 1e30  # daqp's infinity
    y, _, flag, _ = daqp.solve(
        np.ascontiguousarray(H),
        np.ascontiguousarray(f),
        np.ascontiguousarray(C),
        np.ascontiguousarray(np.minimum(upper, big)),
        np.ascontiguousarray(np.maximum(lower, -big)),
        np.zeros(len(C), dtype=np.intc),
    )
    return np.asarray(y) if flag == 1 else None


def _piqp(H: Array, f: Array, C: Array, lower: Array, upper: Array) -> Array | None:
    import piqp

    solver: Any = piqp.DenseSolver()
    solver.settings.verbose = False
    solver.setup(H, f, G=C, h_l=lower, h_u=upper)
    status = solver.solve()
    return np.array(solver.result.x) if status == piqp.PIQP_SOLVED else None
