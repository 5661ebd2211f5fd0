"""CasADi expressions as numbers."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray


def value(expression: Any) -> NDArray[np.float64]:
    """An expression without symbols as an array; a column becomes one-dimensional."""
    array = np.asarray(ca.evalf(ca.SX(expression)))
    return array[:, 0] if array.shape[1] == 1 else array


def numbers(size: float) -> st.SearchStrategy[float]:
    """Numbers of at most this size, none of them too small to matter."""
    return st.floats(-size, size).map(lambda x: round(x, 6))


def vectors(count: int, size: float) -> st.SearchStrategy[NDArray[np.float64]]:
    """Vectors of `count` numbers."""
    return st.lists(numbers(size), min_size=count, max_size=count).map(lambda x: np.array(x, dtype=float))
