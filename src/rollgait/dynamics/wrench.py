"""Forces and torques on the base from outside, as 21 numbers per interval whatever their number.

With lever a from the CoM, fixed in the base, a wrench adds F and T + R a × F to Newton and Euler. Of those
that are constant in the world the sum is linear in R by M = Σ a Fᵀ, as (R a × F)_i = ε_ijk (R M)_jk; those
that turn with the base are one wrench about the CoM.

    F_world (3), T_world (3), M (9, row by row), F_base (3), T_base (3), that of the levers in it

What acts on expressions, numbers and arrays alike are sums and products.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.robot.loads import Wrench

Array = NDArray[np.float64]
Vector = Any
"""Its components: a list of them, or an array whose first axis they are."""

WRENCH_SIZE: Final = 21
"""Numbers of all wrenches together."""


def wrench_numbers(wrenches: Iterable[Wrench], com_offset: Array, begins: Array, ends: Array) -> Array:
    """Means over stretches of time, (21, n).

    Args:
        wrenches: what acts.
        com_offset: from where their places count to the CoM, base axes, (3,), m.
        begins, ends: of the stretches, (n,), s.
    """
    total = np.zeros((WRENCH_SIZE, begins.size))
    for wrench in wrenches:
        force, torque = np.array(wrench.force), np.array(wrench.torque)
        lever, none = np.array(wrench.at) - com_offset, np.zeros(3)
        if wrench.frame == "world":
            parts = [force, torque, np.outer(lever, force).ravel(), none, none]
        else:
            parts = [none, none, np.zeros(9), force, torque + np.cross(lever, force)]
        total += np.outer(np.concatenate(parts), wrench.share_of(begins, ends))
    return total


def mean_wrench(
    wrenches: Sequence[Wrench], com_offset: Array, begin: float, end: float
) -> list[float] | None:
    """`wrench_numbers` of one stretch of time, 21 numbers; None if there are no wrenches."""
    if not wrenches:
        return None
    found = wrench_numbers(wrenches, com_offset, np.array([begin]), np.array([end]))
    return [float(number) for number in found[:, 0]]


def external(numbers: Vector, R: Sequence[Vector]) -> tuple[list[Any], list[Any]]:
    """Force, N, and torque about the CoM, N·m, both 3 in world axes.

    Args:
        numbers: 21 of them.
        R: base to world, rows of 3.
    """
    levers = [numbers[6 + 3 * i : 9 + 3 * i] for i in range(3)]
    turned = [[sum(R[i][k] * levers[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    force, torque = [], []
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        force.append(numbers[i] + sum(R[i][a] * numbers[15 + a] for a in range(3)))
        own = sum(R[i][a] * numbers[18 + a] for a in range(3))
        torque.append(numbers[3 + i] + turned[j][k] - turned[k][j] + own)
    return force, torque
