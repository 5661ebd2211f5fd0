"""Many places, ordered so that those in a box are found without looking at all."""

from __future__ import annotations

from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.terrain.polygons import Array

FEW: Final = 8
"""Boxes that are asked for before it pays to sort the points."""


class Places:
    """Points in the plane; one that is NaN lies in no box.

    Attributes:
        points: (n, 2), m.
    """

    def __init__(self, points: Array) -> None:
        self.points = points
        self._columns = np.ascontiguousarray(points.T)  # NumPy is slow along the long axis of pairs
        self._asked = 0

    @cached_property
    def _order(self) -> list[NDArray[np.intp]]:
        return [np.argsort(column, kind="stable") for column in self._columns]

    @cached_property
    def _sorted(self) -> list[Array]:
        return [column[order] for column, order in zip(self._columns, self._order, strict=True)]

    @property
    def low(self) -> Array:
        """Smallest coordinates, (2,), m; NaN if there is no point."""
        return np.asarray(np.fmin.reduce(self._columns, axis=1, initial=np.nan))

    @property
    def high(self) -> Array:
        """Largest coordinates, (2,), m; NaN if there is no point."""
        return np.asarray(np.fmax.reduce(self._columns, axis=1, initial=np.nan))

    def within(self, low: Array, high: Array) -> NDArray[np.intp]:
        """Numbers of the points in a box, its border too, in their order."""
        self._asked += 1
        if self._asked <= FEW:
            (x0, y0), (x1, y1), (x, y) = low, high, self._columns
            return np.flatnonzero((x >= x0) & (x <= x1) & (y >= y0) & (y <= y1))
        slices = [
            order[np.searchsorted(values, low[axis], "left") : np.searchsorted(values, high[axis], "right")]
            for axis, (order, values) in enumerate(zip(self._order, self._sorted, strict=True))
        ]
        axis = 1 if len(slices[0]) <= len(slices[1]) else 0  # the one that is left to look at
        few = slices[1 - axis]
        across = self._columns[axis, few]
        return np.sort(few[(across >= low[axis]) & (across <= high[axis])])
