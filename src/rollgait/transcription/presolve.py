"""What a nonlinear program knows before it is solved: bounds and constants, found by propagation.

A row of one free variable, linear in it, is a bound of it; a variable whose bounds meet is a constant, and
rows that read it may have one free variable less. Each row is looked at when that happens to it and not
before, so that the work is that of one pass over the nonzeros, however long the chain of constants (a point
foot that does not move fixes its place node after node).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rollgait.transcription.buffered import Buffered, repeated
from rollgait.transcription.code import StageCode
from rollgait.transcription.stage import Stage

Array = NDArray[np.float64]
Index = NDArray[np.intp]
Mask = NDArray[np.bool_]

FIXED_TOLERANCE = 1e-12
"""Limits closer than this fix a variable."""
CONTRADICTION_TOLERANCE = 1e-6
"""A row without variables may miss its limits by this much (in its scaling) before it is a contradiction."""


class Repeated(Protocol):
    """A stage and which variables its repetitions read, as `nlp.Block` has them."""

    @property
    def stage(self) -> Stage:
        """Code, parameters and limits."""

    @property
    def variables(self) -> Index:
        """Which variable each local one is, (n_y, count); −1 stands for zero."""

    @property
    def function(self) -> StageCode:
        """The functions of the stage."""


@dataclass(frozen=True)
class BoundSources:
    """Block, row, repetition and slope behind the lower (0) and upper (1) bound of each variable."""

    index: Index
    slope: Array

    @classmethod
    def none(cls, total: int) -> BoundSources:
        """Nothing bounds anything yet."""
        return cls(np.full((2, total, 3), -1, dtype=np.intp), np.ones((2, total)))

    def of(self, side: int, variables: Index) -> Iterator[tuple[int, int, int, float]]:
        """Block (−1 if there is no bound), row, repetition, slope for each of the variables."""
        for (block, row, stage), slope in zip(
            self.index[side, variables].tolist(), self.slope[side, variables].tolist(), strict=True
        ):
            yield block, row, stage, slope


class Presolve:
    """Bounds and constants of a program, and which rows are left.

    Attributes:
        low, high: bounds of all variables; a constant's are equal, or nearly.
        kept: for each block which rows are constraints still, (n_rows, count).
        sources: where the bounds come from.
        contradictions: rows that no variable can satisfy: block, row, repetition, by how much.
    """

    def __init__(
        self,
        blocks: Sequence[Repeated],
        kept: Sequence[Mask],
        total: int,
        initial: Array,
        again: bool = False,
    ) -> None:
        """`kept` are the rows to begin with; `initial` are the values of the first variables.

        With `again`, it is looked once more with what is known by then: a row may bend with a variable by
        which only constants of zero are multiplied.
        """
        self._blocks, self.kept = blocks, [mask.copy() for mask in kept]
        self.low, self.high = np.full(total, -np.inf), np.full(total, np.inf)
        self.low[: initial.size] = self.high[: initial.size] = initial
        self.sources = BoundSources.none(total)
        self.contradictions: list[tuple[int, int, int, float]] = []
        self._values = [_StageValues(block) for block in blocks]
        self._known = np.zeros(total + 1)  # constants; free variables, and those that are none, are zero
        self._entries = _Entries(blocks, self.kept, total)
        fixed = np.flatnonzero(self._is_fixed(np.arange(total)))
        self._propagate(fixed)
        while again:
            before, fixed = fixed.size, np.flatnonzero(self._is_fixed(np.arange(total)))
            if fixed.size == before:
                break
            self._entries = _Entries(blocks, self.kept, total, self._places_known(fixed))
            self._propagate(fixed)
        self._drop_empty()

    def _places_known(self, fixed: Index) -> Array:
        """Values of the constants, not a number where a variable is free; a zero at the end."""
        result = np.full(self._known.size, np.nan)
        result[fixed], result[-1] = self._known[fixed], 0.0
        return result

    def _is_fixed(self, variables: Index) -> Mask:
        return np.asarray(self.high[variables] - self.low[variables] <= FIXED_TOLERANCE)

    def _propagate(self, fixed: Index) -> None:
        """From variables that are fixed to rows of one variable, to bounds, to further fixed variables."""
        entries = self._entries
        self._fix(fixed)
        rows = entries.all_rows
        while (single := entries.singles(rows)).size:
            touched = [self._take(number, part) for number, part in entries.by_block(single)]
            variables = _distinct(np.concatenate(touched), self._known.size)
            rows = self._fix(variables[self._is_fixed(variables)])

    def _fix(self, variables: Index) -> Index:
        """These variables are constants from now on; which rows that changes."""
        # (two bounds may differ by rounding: a constant is half-way)
        self._known[variables] = 0.5 * (self.low[variables] + self.high[variables])
        return self._entries.fix(variables)

    def _take(self, number: int, entry: Index) -> Index:
        """Turns the rows of a block's entries into bounds of their variables; which variables they are."""
        entries, stage = self._entries, self._blocks[number].stage
        row, k = entries.local_row[entry], entries.repetition[entry]
        variable, slope = entries.variable[entry], entries.slope[entry]
        value = self._values[number].rows(self._known, row, k)
        limits = np.stack([stage.lower[row, k], stage.upper[row, k]])
        ends = (limits - value) / slope
        ends = np.where(slope > 0.0, ends, ends[::-1])
        np.maximum.at(self.low, variable, ends[0])
        np.minimum.at(self.high, variable, ends[1])
        for side, (end, bound) in enumerate(zip(ends, (self.low, self.high), strict=True)):
            here = np.isfinite(end) & (end == bound[variable])
            self.sources.index[side, variable[here]] = np.stack(
                [np.full(row.shape, number), row, k], axis=-1
            )[here]
            self.sources.slope[side, variable[here]] = np.abs(slope[here])
        self.kept[number][row, k] = False
        for i in np.flatnonzero(self.low[variable] > self.high[variable] + FIXED_TOLERANCE):
            crossing = (self.low[variable[i]] - self.high[variable[i]]) * abs(slope[i])
            self.contradictions.append((number, int(row[i]), int(k[i]), float(crossing)))
        return variable

    def _drop_empty(self) -> None:
        """Rows in which no variable is free are dropped, after a look whether they are satisfied."""
        for number, (block, keep) in enumerate(zip(self._blocks, self.kept, strict=True)):
            stage = block.stage
            row, k = np.nonzero(keep & ~self._entries.has_free(number))
            if not row.size:
                continue
            value = self._values[number].rows(self._known, row, k)
            excess = np.maximum(stage.lower[row, k] - value, value - stage.upper[row, k])
            for i in np.flatnonzero(~(excess <= CONTRADICTION_TOLERANCE)):
                self.contradictions.append((number, int(row[i]), int(k[i]), float(excess[i])))
            keep[row, k] = False


class _Entries:
    """The nonzeros of all rows' Jacobians, and how many of each row are of free variables.

    Attributes:
        local_row, repetition: of each entry, its row in the stage and its repetition.
        variable, slope: of each entry; the slope says nothing where it changes with the variables.
        all_rows: numbers of all rows, block after block, row after row.
    """

    def __init__(
        self, blocks: Sequence[Repeated], kept: Sequence[Mask], total: int, known: Array | None = None
    ) -> None:
        parts: list[tuple[Any, ...]] = []
        self._shapes = [mask.shape for mask in kept]
        self._begins = np.cumsum([0, *(mask.size for mask in kept)])
        self._entry_begins = [0]
        somewhere = np.random.default_rng(0)
        for block, keep, begin in zip(blocks, kept, self._begins, strict=False):
            f, count = block.function, block.stage.count
            slope, variable = _slopes(block, somewhere, known), block.variables[f.jacobian_cols]
            bends = ~f.linear
            used = keep[f.jacobian_rows] & (variable >= 0) & (slope != 0.0)
            nonzero, repetition = np.nonzero(used)
            row = f.jacobian_rows[nonzero]
            parts.append(
                (
                    row,
                    repetition,
                    begin + row * count + repetition,
                    variable[used],
                    slope[used],
                    bends[nonzero],
                )
            )
            self._entry_begins.append(self._entry_begins[-1] + row.size)
        columns = [np.concatenate(column) for column in zip(*parts, strict=True)]
        self.local_row, self.repetition, self._row, self.variable, self.slope, bends = columns
        rows = int(self._begins[-1])
        self.all_rows = np.arange(rows)
        self._count = np.bincount(self._row, minlength=rows)
        self._bends = np.bincount(self._row[bends], minlength=rows)
        self._bent = bends
        # the sum of the numbers of a row's entries: once a single one is left, its number
        numbers = np.arange(self._row.size, dtype=float)
        self._sum = np.bincount(self._row, weights=numbers, minlength=rows).astype(np.intp)
        self._alive = np.concatenate([mask.ravel() for mask in kept])
        self._of_variable = np.argsort(self.variable, kind="stable")
        self._first = np.searchsorted(self.variable[self._of_variable], np.arange(total + 1))

    def fix(self, variables: Index) -> Index:
        """These variables are free no more: which rows that changes."""
        begin, size = self._first[variables], self._first[variables + 1] - self._first[variables]
        inside = np.arange(size.sum()) - np.repeat(np.cumsum(size) - size, size)
        entry = self._of_variable[np.repeat(begin, size) + inside]
        row = self._row[entry]
        np.subtract.at(self._count, row, 1)
        np.subtract.at(self._bends, row, self._bent[entry].astype(np.intp))
        np.subtract.at(self._sum, row, entry)
        return _distinct(row, self._count.size)

    def singles(self, rows: Index) -> Index:
        """The entries that are the only free ones of their rows, linear; the rows are done with then."""
        rows = rows[self._alive[rows] & (self._count[rows] == 1) & (self._bends[rows] == 0)]
        self._alive[rows] = False
        return np.sort(self._sum[rows])

    def by_block(self, entries: Index) -> Iterator[tuple[int, Index]]:
        """Numbers of the blocks and their part of the entries, which rise."""
        cuts = np.searchsorted(entries, self._entry_begins)
        for number, (begin, end) in enumerate(pairwise(cuts.tolist())):
            if begin < end:
                yield number, entries[begin:end]

    def has_free(self, number: int) -> Mask:
        """Which rows of a block read a free variable, (n_rows, count)."""
        part = self._count[self._begins[number] : self._begins[number + 1]]
        return np.asarray(part.reshape(self._shapes[number]) > 0)


def _distinct(numbers: Index, size: int) -> Index:
    """Numbers below `size`, each once, rising. (`np.unique` loads masked arrays, which nobody needs here.)"""
    marked = np.zeros(size, dtype=bool)
    marked[numbers] = True
    return np.flatnonzero(marked)


class _StageValues:
    """Rows of a block's single repetitions."""

    def __init__(self, block: Repeated) -> None:
        self._variables, self._parameters = block.variables.T, block.stage.parameters.T
        self._y, self._p = np.empty(self._variables.shape[1]), np.empty(self._parameters.shape[1])
        self._function = Buffered(block.function.value, [self._y, self._p])

    def rows(self, variables: Array, row: Index, repetition: Index) -> Array:
        """Values of rows at all variables and a zero, (n,)."""
        result = np.empty(row.size)
        order = np.argsort(repetition, kind="stable")
        different, first = np.unique(repetition[order], return_index=True)
        for k, part in zip(different.tolist(), np.split(order, first[1:]), strict=True):
            self._y[:] = variables[self._variables[k]]
            self._p[:] = self._parameters[k]
            result[part] = self._function()[1][row[part]]
        return result


def _slopes(block: Repeated, somewhere: np.random.Generator, known: Array | None = None) -> Array:
    """Nonzeros of the Jacobians at random places, where nothing else is known, (nnz, count).

    What is linear has these slopes everywhere; of the rest it is told whether they are always zero.
    """
    f, count = block.function, block.stage.count
    y = somewhere.uniform(0.5, 1.5, block.variables.shape)
    if known is not None:
        there = known[block.variables]
        y = np.where(np.isnan(there), y, there)
    y = np.ascontiguousarray(y.T).ravel()
    p = np.ascontiguousarray(block.stage.parameters.T).ravel()
    (slopes,) = Buffered(repeated(f.jacobian, count), [y, p])()
    return slopes.reshape(count, -1).T
