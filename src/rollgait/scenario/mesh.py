"""The mesh of the horizon: the intervals into which it is cut, equal or not. Frozen data."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.errors import InputError

Array = NDArray[np.float64]
Index = NDArray[np.intp]

MAX_INTERVALS = 10_000
"""More than any planner here can hold in memory: a slip of the pen, not a wish."""

BORDER = 1e-9
"""Part of an interval: a time so little before its end belongs to the next one, as nodes carry round-off."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """How the horizon is cut into N intervals; it begins at t = 0.

    Attributes:
        lengths: of the intervals, shape (N,), s; read-only.

    Raises:
        InputError: there is no interval, there are too many, or a length is no positive number.
    """

    lengths: Array

    def __post_init__(self) -> None:
        lengths = np.array(self.lengths, dtype=np.float64)
        if lengths.ndim != 1 or not 1 <= lengths.size <= MAX_INTERVALS:
            rule = f"must be an array of shape (N,) with N from 1 to {MAX_INTERVALS}"
            raise InputError("mesh.lengths", lengths.shape, rule)
        bad = lengths[~(np.isfinite(lengths) & (lengths > 0.0))]
        if bad.size:
            raise InputError("mesh.lengths", float(bad[0]), "must be a positive number of seconds")
        lengths.setflags(write=False)
        object.__setattr__(self, "lengths", lengths)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Mesh):
            return NotImplemented
        return np.array_equal(self.lengths, other.lengths)

    def __hash__(self) -> int:
        return hash(self.lengths.tobytes())

    @classmethod
    def equal(cls, horizon: float, count: int) -> Mesh:
        """`count` intervals of one length that together last `horizon` s."""
        return cls(np.full(count, horizon / count))

    @property
    def intervals(self) -> int:
        """N."""
        return int(self.lengths.size)

    @property
    def is_equal(self) -> bool:
        """Whether all intervals have the same length."""
        return bool((self.lengths == self.lengths[0]).all())

    @cached_property
    def times(self) -> Array:
        """Times of the nodes, shape (N + 1,), s."""
        if self.is_equal:  # products carry less round-off than sums
            return np.asarray(np.arange(self.intervals + 1) * self.lengths[0], dtype=np.float64)
        return np.concatenate([[0.0], np.cumsum(self.lengths)])

    @property
    def horizon(self) -> float:
        """T, s: the time of the last node."""
        return float(self.times[-1])

    @property
    def middles(self) -> Array:
        """Times of the middles of the intervals, shape (N,), s."""
        return np.asarray(self.times[:-1] + 0.5 * self.lengths)

    @property
    def lengths_before(self) -> Array:
        """Length of the interval before each, shape (N,), s; before the first lies one like it, at rest."""
        return np.concatenate([self.lengths[:1], self.lengths[:-1]])

    @property
    def between_middles(self) -> Array:
        """Time from the middle of the interval before to the middle of each, shape (N,), s.

        What is constant in an interval is its value at the middle: a rate of change is over this time.
        """
        return np.asarray(0.5 * (self.lengths_before + self.lengths))

    def interval_at(self, times: ArrayLike) -> Index:
        """Number of the interval in which each time lies, in the shape of `times`.

        At a node it is the later interval, before and after the horizon the first and the last.
        """
        borders = self.times[1:-1] - BORDER * self.lengths[:-1]
        return np.asarray(np.searchsorted(borders, times, side="right"))

    def place_of(self, times: Array) -> tuple[Index, Array]:
        """Number of the interval in which each time lies, and the part of it that has passed; both (n,)."""
        k = self.interval_at(times)
        return k, np.asarray((times - self.times[k]) / self.lengths[k])

    def cut_at(self, times: ArrayLike) -> Mesh:
        """The mesh with further nodes at times within it, (n,), s. Raises `InputError` for any other time."""
        inside = np.setdiff1d(times, self.times[1:-1])
        outside = inside[~((inside > 0.0) & (inside < self.horizon))]
        if outside.size:
            raise InputError("times", float(outside[0]), f"must be between 0 and {self.horizon:g} s")
        return Mesh(np.diff(np.sort(np.concatenate([self.times, inside])))) if inside.size else self

    def refined(self, which: ArrayLike, parts: ArrayLike = 2) -> Mesh:
        """The mesh with some intervals cut into equal parts.

        Args:
            which: numbers of the intervals that are cut, shape (n,), or a mask of shape (N,).
            parts: into how many, for all of them or shape (n,).

        Raises:
            InputError: there is no such interval, or it cannot be cut into so many parts.
        """
        numbers = np.atleast_1d(np.asarray(which))
        numbers = np.flatnonzero(numbers) if numbers.dtype == np.bool_ else numbers.astype(np.intp)
        outside = numbers[(numbers < 0) | (numbers >= self.intervals)]
        if outside.size:
            rule = f"must be the number of an interval, 0 to {self.intervals - 1}"
            raise InputError("which", int(outside[0]), rule)
        counts = np.ones(self.intervals, dtype=np.intp)
        counts[numbers] = parts
        if counts.min() < 1 or counts.sum() > MAX_INTERVALS:
            rule = f"must be at least 1 and make at most {MAX_INTERVALS} intervals in all"
            raise InputError("parts", np.asarray(parts).tolist(), rule)
        return Mesh(np.repeat(self.lengths / counts, counts))
