"""The smallest problem that fatrop's linear algebra can be tried on: two stages, solved again by NumPy."""

from __future__ import annotations

from functools import partial
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.solvers.watched import NoAnswerError, call_watched

STATES, INPUTS, END_STATES, EQUATIONS = 7, 6, 9, 3
"""Sizes that are no multiples of a panel, large enough for whole panels inside."""

SECONDS_MAX = 1.0
"""s of processor time; it takes less than 1 ms, unless the product is wrong."""


def error_of_two_stages() -> float:
    """Largest difference between fatrop's solution and that of a dense factorisation; infinite if it fails.

    minimise ½ zᵀ H z + cᵀ z subject to J z = r, where z holds state and inputs of the first stage and the
    state of the second, and J the dynamics and some equations of the first.
    """
    random, first = np.random.default_rng(0), STATES + INPUTS
    size, rows = first + END_STATES, END_STATES + EQUATIONS
    H, J = np.zeros((size, size)), np.zeros((rows, size))
    H[:first, :first], H[first:, first:] = _definite(random, first), _definite(random, END_STATES)
    J[:, :first] = random.normal(size=(rows, first))
    J[:END_STATES, first:] = np.eye(END_STATES)
    c, r = random.normal(size=size), random.normal(size=rows)
    kkt = np.block([[H, J.T], [J, np.zeros((rows, rows))]])
    wanted = np.linalg.solve(kkt, np.concatenate([-c, r]))[:size]

    z = ca.MX.sym("z", size)
    H_sparse, J_sparse = (ca.sparsify(ca.DM(matrix)) for matrix in (H, J))
    program: dict[str, Any] = {
        "x": z,
        "f": 0.5 * ca.bilin(H_sparse, z) + ca.dot(ca.DM(c), z),
        "g": ca.mtimes(J_sparse, z),
    }
    options: dict[str, Any] = {
        "structure_detection": "manual",
        "N": 1,
        "nx": [STATES, END_STATES],
        "nu": [INPUTS, 0],
        "ng": [EQUATIONS, 0],
        "print_time": False,
        "error_on_fail": False,
        "fatrop": {"print_level": 0, "max_iter": 20},
    }
    solver: Any = ca.nlpsol("two_stages", "fatrop", program, options)
    try:
        result = call_watched(partial(solver, lbg=r, ubg=r), lambda: 0, SECONDS_MAX)
    except NoAnswerError:
        return float("inf")
    found = np.asarray(result["x"]).ravel()
    if not solver.stats()["success"] or not np.isfinite(found).all():
        return float("inf")
    return float(np.abs(found - wanted).max())


def _definite(random: np.random.Generator, size: int) -> NDArray[np.float64]:
    root = random.normal(size=(size, size))
    return root @ root.T + np.eye(size)
