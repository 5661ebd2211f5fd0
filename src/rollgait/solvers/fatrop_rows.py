"""Which variables, rows and bounds of an NLP fatrop keeps where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollgait.solvers import fatrop_library as c
from rollgait.transcription.base import Structure
from rollgait.transcription.nlp import Nlp

Array = NDArray[np.float64]
Index = NDArray[np.intp]


@dataclass(frozen=True)
class Places:
    """Where fatrop keeps equations, inequalities, bounds and defining rows in its vector of constraints."""

    equal: Index
    unequal: Index
    bounded: Index
    defining: Index


class Rows:
    """Stage and column of the rows and bounds of an NLP, and the order of its variables.

    Attributes:
        order: for each of fatrop's variables its number in the NLP.
        stage, local: of each variable of the NLP its stage and its number in the stage's (u, x).
        equal, unequal, defining: rows that are equations, inequalities, definitions of the next state.
        bounded: variables with bounds.
    """

    def __init__(self, nlp: Nlp, structure: Structure) -> None:
        self.nx, self.nu = structure.nx, structure.nu
        nx, nu = np.array(structure.nx), np.array(structure.nu)
        stages = nx.size
        self._nlp = nlp
        self._begin = [0, *np.cumsum(nx + nu).tolist()]
        begin = np.array(self._begin, dtype=np.intp)
        stage = np.repeat(np.arange(stages), nx + nu)
        inside = np.arange(nlp.size) - begin[stage]
        self.stage = stage
        self.local = np.where(inside < nx[stage], inside + nu[stage], inside - nx[stage])
        self.order = np.empty(nlp.size, dtype=np.intp)
        self.order[begin[stage] + self.local] = np.arange(nlp.size)
        row_stage, defines = np.zeros(nlp.rows, dtype=np.intp), np.zeros(nlp.rows, dtype=bool)
        for block in nlp.blocks:
            number, kept = nlp.row_numbers(block), nlp.kept(block)
            row_stage[number[kept]] = np.broadcast_to(block.first + np.arange(kept.shape[1]), kept.shape)[
                kept
            ]
            defines[number[kept]] = nlp.defines_next(block)[kept]
        is_equal = nlp.g_lower == nlp.g_upper
        self.defining = np.flatnonzero(defines)
        self.equal = np.flatnonzero(is_equal & ~defines)
        self.unequal = np.flatnonzero(~is_equal)
        self.bounded = np.flatnonzero(np.isfinite(nlp.lower) | np.isfinite(nlp.upper))
        self.row_stage = row_stage
        self.n_equal = np.bincount(row_stage[self.equal], minlength=stages).tolist()
        rows, bounds = (
            np.bincount(s, minlength=stages) for s in (row_stage[self.unequal], stage[self.bounded])
        )
        self.n_unequal = (rows + bounds).tolist()
        self.column = np.empty(nlp.rows, dtype=np.intp)
        self.column[self.defining] = _count_within(row_stage[self.defining])
        self.column[self.equal] = _count_within(row_stage[self.equal])
        self.column[self.unequal] = _count_within(row_stage[self.unequal])
        self.bound_column = rows[stage[self.bounded]] + _count_within(stage[self.bounded])
        self._places: Places | None = None
        self._first = [0, *np.cumsum(self.n_unequal).tolist()]
        self._limits: Array = np.empty((2, self._first[-1]))
        first = np.array(self._first, dtype=np.intp)
        self._limit_of_row = first[row_stage[self.unequal]] + self.column[self.unequal]
        self._limit_of_bound = first[stage[self.bounded]] + self.bound_column
        self.load_bounds()

    def load_bounds(self) -> None:
        """Takes the limits of rows and variables from the NLP as they are now."""
        nlp = self._nlp
        for side, (of_rows, of_variables) in enumerate(((nlp.g_lower, nlp.lower), (nlp.g_upper, nlp.upper))):
            self._limits[side, self._limit_of_row] = of_rows[self.unequal]
            self._limits[side, self._limit_of_bound] = of_variables[self.bounded]

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lower and upper limits of all inequalities, stage after stage: always the same memory."""
        return self._limits[0], self._limits[1]

    @property
    def begins(self) -> tuple[list[int], list[int]]:
        """How many limits and how many variables come before each stage, and altogether."""
        return self._first, self._begin

    def bounds(self, k: int) -> slice:
        """Which of the limits are those of a stage."""
        return slice(self._first[k], self._first[k + 1])

    def states(self, k: int) -> slice:
        """The NLP's variables that are states of a stage."""
        return slice(self._begin[k], self._begin[k] + self.nx[k])

    def inputs(self, k: int) -> slice:
        """The NLP's variables that are inputs of a stage."""
        return slice(self._begin[k] + self.nx[k], self._begin[k + 1])

    @property
    def total(self) -> int:
        """Length of fatrop's vector of constraints."""
        return self.equal.size + self.unequal.size + self.bounded.size + self.defining.size

    def places(self, dims: c.Dims) -> Places:
        """Where fatrop keeps what."""
        if self._places is None:
            stages = len(self.nx)
            g, ineq = (
                np.ctypeslib.as_array(offset, (stages,)).astype(np.intp)
                for offset in (dims.g_offs, dims.g_ineq_offs)
            )
            dyn = np.ctypeslib.as_array(dims.dyn_eq_offs, (stages - 1,)).astype(np.intp)
            self._places = Places(
                equal=g[self.row_stage[self.equal]] + self.column[self.equal],
                unequal=ineq[self.row_stage[self.unequal]] + self.column[self.unequal],
                bounded=ineq[self.stage[self.bounded]] + self.bound_column,
                defining=dyn[self.row_stage[self.defining]] + self.column[self.defining],
            )
        return self._places


def _count_within(group: Index) -> Index:
    """Running number of each element among those of the same group (equal groups need not stand together)."""
    order = np.argsort(group, kind="stable")
    sorted_group = group[order]
    begins = np.searchsorted(sorted_group, sorted_group, side="left")
    result = np.empty(group.size, dtype=np.intp)
    result[order] = np.arange(group.size) - begins
    return result
