"""Many places, ordered so that those in a box are found without looking at all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rollgait.terrain.polygons import Array


class Places:
    """Points in the plane; one that is NaN lies in no box.

    Attributes:
        points: (n, 2), m.
    """

    def __init__(self, points: Array) -> None:
        self.points = points
        self._order = [np.argsort(points[:, axis], kind="stable") for axis in (0, 1)]
        self._sorted = [points[order, axis] for axis, order in enumerate(self._order)]

    @property
    def low(self) -> Array:
        """Smallest coordinates, (2,), m; NaN if there is no point."""
        return np.array([np.fmin.reduce(values, initial=np.nan) for values in self._sorted])

    @property
    def high(self) -> Array:
        """Largest coordinates, (2,), m; NaN if there is no point."""
        return np.array([np.fmax.reduce(values, initial=np.nan) for values in self._sorted])

    def within(self, low: Array, high: Array) -> NDArray[np.intp]:
        """Numbers of the points in a box, its border too, in their order."""
        slices = [
            order[np.searchsorted(values, low[axis], "left") : np.searchsorted(values, high[axis], "right")]
            for axis, (order, values) in enumerate(zip(self._order, self._sorted, strict=True))
        ]
        axis = 1 if len(slices[0]) <= len(slices[1]) else 0  # the one that is left to look at
        few = slices[1 - axis]
        across = self.points[few, axis]
        return np.sort(few[(across >= low[axis]) & (across <= high[axis])])
