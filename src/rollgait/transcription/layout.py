"""Names for the entries of a vector of variables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


class Layout:
    """Consecutive groups of entries by name.

    >>> layout = Layout([("base", 6), ("force", 12)])
    >>> layout.size, layout["force"]
    (18, slice(6, 18, None))
    """

    def __init__(self, groups: Sequence[tuple[str, int]]) -> None:
        self._slices: dict[str, slice] = {}
        begin = 0
        for name, size in groups:
            self._slices[name] = slice(begin, begin + size)
            begin += size
        self.size = begin

    def __getitem__(self, name: str) -> slice:
        return self._slices[name]

    def index(self, name: str) -> NDArray[np.intp]:
        """Numbers of the entries of a group."""
        return np.arange(self.size)[self._slices[name]]
