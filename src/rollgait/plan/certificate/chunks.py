"""Work on many rows at once, but not on so many that memory runs short."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

ROWS: Final = 4000
"""Feet at a time: with a thousand probes each their arrays take 32 MB."""


def in_chunks(
    function: Callable[..., tuple[NDArray[Any], ...]], *arrays: NDArray[Any]
) -> tuple[NDArray[Any], ...]:
    """What a function of arrays (n, …) gives, arrays (n, …), asked for `ROWS` of them at a time."""
    count = max(1, -(-len(arrays[0]) // ROWS))
    parts = [function(*(array[k * ROWS : (k + 1) * ROWS] for array in arrays)) for k in range(count)]
    return tuple(np.concatenate(columns) for columns in zip(*parts, strict=True))
