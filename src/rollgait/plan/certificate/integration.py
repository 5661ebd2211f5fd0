"""Integration of many motions at once, as polynomials that obey their differential equation.

Over a short panel of time the solution of y' = f(t, y) is found by Picard's iteration y ← y(0) + ∫ f(t, y) dt
on Chebyshev points, for all motions and points in one evaluation of f; where that does not converge, or the
polynomials do not resolve the motion, the time is cut into more panels. (SciPy's integrators would do, and
take longer to load than a plan to solve. A test compares with them.)
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

Array = NDArray[np.float64]

POINTS = 12
"""Chebyshev points in a panel: the motion is a polynomial of degree 12, as inputs have one of 11."""
PANELS = (1, 4, 16)
"""Numbers of panels that are tried; what needs more (usual: one) is wild."""
ITERATIONS = 30
"""Most iterations in a panel; usual are 3, from the states of a plan."""
RELATIVE_ACCURACY = 1e-9
ABSOLUTE_ACCURACY = 1e-10
"""SI units; several orders below the tolerated defects."""


class TooWildError(Exception):
    """A motion is too wild to be integrated."""


def integrate(
    slope: Callable[[Array, Array], Array], begin: Array, times: Array, guess: Callable[[Array], Array]
) -> Array:
    """The solutions of y' = slope(t, y) from y(0) = begin.

    Args:
        slope: derivatives, (P, N, n), at times (P,) and states (P, N, n).
        begin: N states at time 0, (N, n).
        times: rising, (T,), from 0 on.
        guess: states at times (P,), (P, N, n), better if near the solution, which does not depend on it.

    Returns:
        The states at the times, (T, N, n).

    Raises:
        TooWildError: they change too fast to be found to the accuracy, or without end.
    """
    for count in PANELS:
        ends = np.linspace(0.0, times[-1], count + 1)
        states, found = begin, []
        for first, last in pairwise(ends):
            inside = times[(times >= first) & ((times < last) | (last == ends[-1]))]
            panel = _panel(slope, states, first, last, inside, guess)
            if panel is None:
                break
            states = panel[-1]
            found.append(panel[:-1])
        else:
            return np.concatenate(found)
    raise TooWildError


def _panel(
    slope: Callable[[Array, Array], Array],
    begin: Array,
    first: float,
    last: float,
    times: Array,
    guess: Callable[[Array], Array],
) -> Array | None:
    """The states at times of one panel and at its end, (T + 1, N, n); None if they are not accurate."""
    half = 0.5 * (last - first)
    points, to_coefficients = _chebyshev()
    integral = half * chebyshev.chebint(to_coefficients, lbnd=-1.0)
    to_points = chebyshev.chebvander(points, POINTS) @ integral
    at = first + half * (points + 1.0)
    states = guess(at)
    for _ in range(ITERATIONS):
        slopes = slope(at, states)
        better = begin + np.tensordot(to_points, slopes, axes=1)
        if not np.isfinite(better).all():
            return None
        change, states = np.abs(better - states), better
        allowed = ABSOLUTE_ACCURACY + RELATIVE_ACCURACY * np.abs(states)
        if (change <= allowed).all():
            break
    else:
        return None
    # the last coefficients tell what the polynomial leaves out
    left_out = half * np.abs(np.tensordot(to_coefficients[-2:], slopes, axes=1))
    if not (left_out <= allowed[-1]).all():
        return None
    wanted = np.append((times - first) / half - 1.0, 1.0)
    to_wanted = chebyshev.chebvander(wanted, POINTS) @ integral
    return np.asarray(begin + np.tensordot(to_wanted, slopes, axes=1))


@lru_cache(maxsize=1)
def _chebyshev() -> tuple[Array, Array]:
    """The points in [−1, 1], rising, and the matrix from values there to Chebyshev coefficients."""
    points = chebyshev.chebpts2(POINTS)
    return points, np.asarray(np.linalg.inv(chebyshev.chebvander(points, POINTS - 1)), dtype=float)
