"""What no solver is asked: limits that cross, numbers that are none or beyond all use.

Interior-point methods need room between their limits and finite numbers. Fatrop regularises its matrices
again and again until they can be factorised, and with such numbers they never can.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import NotSolvedError
from rollgait.transcription.base import Program

Array = NDArray[np.float64]

LARGEST = 1e9
"""Largest number (in the problem's own units and scales) from which derivatives keep any digits."""


def refuse_unsolvable(nlp: Program, guess: Array) -> None:
    """Looks at the numbers of a program as they are now.

    Raises:
        NotSolvedError: they are such that a solver might never come back.
    """
    lower, upper = np.concatenate([nlp.g_lower, nlp.lower]), np.concatenate([nlp.g_upper, nlp.upper])
    # (NaN is in no order: what does not hold is refused)
    wrong = np.flatnonzero(~((lower <= upper) & (lower < np.inf) & (upper > -np.inf)))
    if wrong.size:
        i = int(wrong[0])
        raise NotSolvedError(
            f"no solution exists: {nlp.limit_name(i)} would have to lie between {lower[i]:.6g} "
            f"and {upper[i]:.6g}"
        )
    for limits in (lower, upper):
        large = np.flatnonzero(np.isfinite(limits) & (np.abs(limits) > LARGEST))
        if large.size:
            raise _beyond(f"a limit of {nlp.limit_name(int(large[0]))}", limits[large[0]])
    for name, numbers in (("a variable of the initial guess", guess), ("a parameter", nlp.parameters)):
        beyond = np.flatnonzero(~(np.abs(numbers) <= LARGEST))
        if beyond.size:
            raise _beyond(name, numbers[beyond[0]])


def _beyond(name: str, value: float) -> NotSolvedError:
    return NotSolvedError(
        f"no solver was asked: {name} is {value:.6g}, and must be a finite number of at most {LARGEST:g}"
    )
