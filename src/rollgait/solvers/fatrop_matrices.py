"""Where each derivative goes in fatrop's matrices: found once, used by index.

Fatrop writes nothing into these matrices but their last rows, the right-hand sides. So what is zero in all of
them is made zero once, and each evaluation touches only what is there.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.solvers import fatrop_library as c
from rollgait.solvers.fatrop_rows import Rows
from rollgait.transcription.nlp import Nlp

Array = NDArray[np.float64]
Index = NDArray[np.intp]


class JacobianFill:
    """Where each derivative and each row goes in fatrop's matrices of constraints.

    Args:
        nlp, rows: the problem.
        matrices: fatrop's three, by stage.
        like: another set of matrices of the same problem, which is laid out in the same way.
    """

    def __init__(
        self, nlp: Nlp, rows: Rows, matrices: Sequence[Any], like: JacobianFill | None = None
    ) -> None:
        self._nlp, self._rows = nlp, rows
        sizes = np.array(rows.nx) + np.array(rows.nu)
        columns = (np.array(rows.nx[1:]), np.array(rows.n_equal), np.array(rows.n_unequal))
        self._memories = [
            _Memory(matrix, sizes[: width.size] + 1, width)
            for matrix, width in zip(matrices, columns, strict=True)
        ]
        stage, bounded = rows.stage[rows.bounded], rows.local[rows.bounded]
        self._bound_entry = self._memories[2].index(stage, bounded, rows.bound_column)
        self._bound_row = self._memories[2].index(stage, sizes[stage], rows.bound_column)
        if like is None:
            self._parts = self._find(sizes)
        else:
            self._parts = [
                (derivative.in_memory(memory), source, below.in_memory(memory))
                for memory, (derivative, source, below) in zip(self._memories, like._parts, strict=True)
            ]

    def _find(self, sizes: Index) -> list[tuple[_Elements, Index, _Elements]]:
        """For each of the three: where its derivatives go, which they are, where its rows go."""
        nlp, rows = self._nlp, self._rows
        row, column = [], []
        for block in nlp.blocks:
            f = block.function
            row.append(_stage_after_stage(nlp.row_numbers(block), f.jacobian_rows))
            column.append(_stage_after_stage(nlp.positions(block), f.jacobian_cols))
        r, v = np.concatenate(row), np.concatenate(column)
        used = np.flatnonzero((r >= 0) & (v < nlp.size))
        used = used[rows.row_stage[r[used]] == rows.stage[v[used]]]  # not the x⁺ of x⁺ − F
        r, v = r[used], v[used]
        kind = np.zeros(nlp.rows, dtype=int)
        kind[rows.equal], kind[rows.unequal] = 1, 2
        kind = kind[r]
        parts = []
        for number, (memory, which) in enumerate(
            zip(self._memories, (rows.defining, rows.equal, rows.unequal), strict=True)
        ):
            mine = np.flatnonzero(kind == number)
            r_mine = r[mine]
            derivative = memory.index(rows.row_stage[r_mine], rows.local[v[mine]], rows.column[r_mine])
            stage = rows.row_stage[which]
            below = memory.index(stage, sizes[stage], rows.column[which])  # the row under the derivatives
            parts.append((derivative, used[mine], below))
        return parts

    def put(self, values: Array, g: Array, w: Array) -> None:
        """Puts the derivatives of all rows, and the rows themselves, in place."""
        nlp, rows = self._nlp, self._rows
        residuals = ((nlp.g_lower - g)[rows.defining], (g - nlp.g_lower)[rows.equal], g[rows.unequal])
        for memory, (target, source, below), negative, residual in zip(
            self._memories, self._parts, (True, False, False), residuals, strict=True
        ):
            memory.make_ready()
            mine = values[source]
            memory.data[target.place] = np.negative(mine, out=mine) if negative else mine
            memory.data[below.place] = residual
        unequal = self._memories[2].data
        unequal[self._bound_entry.place] = 1.0
        unequal[self._bound_row.place] = w[rows.bounded]

    def make_ready(self) -> None:
        """Sets what nobody writes to zero, unless that has been done."""
        for memory in self._memories:
            memory.make_ready()

    @property
    def parts(self) -> list[tuple[Array, Index, Index, Index]]:
        """Of each of the three: its memory, where its derivatives go, which they are, where its rows go."""
        return [
            (memory.data, derivative.place, source, below.place)
            for memory, (derivative, source, below) in zip(self._memories, self._parts, strict=True)
        ]

    @property
    def of_bounds(self) -> tuple[Index, Index]:
        """Where bounds of variables have their derivatives and their values, in the third memory."""
        return self._bound_entry.place, self._bound_row.place

    def untouched(self) -> list[Array]:
        """What nobody is to write to, of each of the three: neither derivatives nor rows stand there."""
        bounds = [np.empty(0, dtype=np.intp)] * 2 + [self._bound_entry.place]
        return [
            memory.beside(np.concatenate([derivative.place, bound]))
            for memory, (derivative, _, _), bound in zip(self._memories, self._parts, bounds, strict=True)
        ]

    def put_nothing(self) -> None:
        """All rows are zero and nothing depends on anything."""
        for memory in self._memories:
            memory.clear()


@dataclass(frozen=True)
class _HessianPlaces:
    """Where the stages' nonzeros go.

    Attributes:
        pairs: which second derivatives are of two free variables, `beside`: which of these not of one twice.
        slopes: which first derivatives are of a free variable of their stage.
        upper, lower, below: where they go.
        last_rows, diagonal: of all variables.
        bound: below each variable with bounds.
    """

    pairs: Index
    beside: Index
    slopes: Index
    upper: _Elements
    lower: _Elements
    below: _Elements
    last_rows: _Elements
    diagonal: _Elements
    bound: _Elements

    def in_memory(self, memory: _Memory) -> _HessianPlaces:
        """The same in another memory of matrices of the same sizes."""
        moved: dict[str, Any] = {
            field.name: value.in_memory(memory)
            for field in fields(self)
            if isinstance(value := getattr(self, field.name), _Elements)
        }
        return replace(self, **moved)


class HessianFill:
    """Where each second and first derivative of the Lagrangian goes in fatrop's matrices of costs.

    Args:
        nlp, rows: the problem.
        matrix: fatrop's, by stage.
        like: another set of the same problem, which is laid out in the same way.
    """

    def __init__(self, nlp: Nlp, rows: Rows, matrix: Any, like: HessianFill | None = None) -> None:
        sizes = np.array(rows.nx) + np.array(rows.nu)
        self._memory = _Memory(matrix, sizes + 1, sizes)
        if like is None:
            self._places = _hessian_places(nlp, rows, self._memory, sizes)
        else:
            self._places = like._places.in_memory(self._memory)

    def put(self, second: Array, first: Array, bound_multipliers: Array) -> None:
        """Puts the Hessian of the Lagrangian and its gradient in place."""
        self._memory.make_ready()
        data, place = self._memory.data, self._places
        pairs = second[place.pairs]
        data[place.upper.place] = pairs
        data[place.lower.place] = pairs[place.beside]
        data[place.last_rows.place] = 0.0
        data[place.below.place] = first[place.slopes]
        data[place.bound.place] += bound_multipliers

    def make_ready(self) -> None:
        """Sets what nobody writes to zero, unless that has been done."""
        self._memory.make_ready()

    @property
    def data(self) -> Array:
        """The memory."""
        return self._memory.data

    @property
    def places(self) -> _HessianPlaces:
        """Where what goes in it."""
        return self._places

    def untouched(self) -> list[Array]:
        """What nobody is to write to: neither derivatives nor the last rows stand there."""
        return [self._memory.beside(np.concatenate([self._places.upper.place, self._places.lower.place]))]

    def put_identity(self) -> None:
        """The Lagrangian of half the square of all variables."""
        self._memory.clear()
        self._memory.data[self._places.diagonal.place] = 1.0


def _hessian_places(nlp: Nlp, rows: Rows, memory: _Memory, sizes: Index) -> _HessianPlaces:
    first, second, variable = [], [], []
    for block in nlp.blocks:
        position, f = nlp.positions(block), block.function
        first.append(_stage_after_stage(position, f.hessian_rows))
        second.append(_stage_after_stage(position, f.hessian_cols))
        stage = np.broadcast_to(block.first + np.arange(position.shape[1]), position.shape)
        # the next node is among the local variables, but not in this stage's part of the Lagrangian
        inside = np.append(rows.stage, -1)[np.minimum(position, nlp.size)] == stage
        variable.append(np.where(inside, position, nlp.size).T.ravel())
    a, b, v = (np.concatenate(part) for part in (first, second, variable))
    pairs, slopes = np.flatnonzero((a < nlp.size) & (b < nlp.size)), np.flatnonzero(v < nlp.size)
    a, b, v = a[pairs], b[pairs], v[slopes]
    stage, a, b = rows.stage[a], rows.local[a], rows.local[b]
    beside = np.flatnonzero(a != b)

    def last_row(variables: Index) -> _Elements:
        stage = rows.stage[variables]
        return memory.index(stage, sizes[stage], rows.local[variables])

    return _HessianPlaces(
        pairs=pairs,
        beside=beside,
        slopes=slopes,
        upper=memory.index(stage, a, b),
        lower=memory.index(stage[beside], b[beside], a[beside]),
        below=last_row(v),
        last_rows=last_row(np.arange(nlp.size)),
        diagonal=memory.index(rows.stage, rows.local, rows.local),
        bound=last_row(rows.bounded),
    )


def _stage_after_stage(numbers: Index, which: Index) -> Index:
    """Some rows of (n, count), flat: all of the first column, then all of the second."""
    return np.ascontiguousarray(numbers.T)[:, which].ravel()


@dataclass(frozen=True)
class _Elements:
    """Elements of matrices: of which stage, where in the memory, and where the stages begin in it."""

    stage: Index
    place: Index
    offset: Index

    def in_memory(self, memory: _Memory) -> _Elements:
        """The same elements in another memory of matrices of the same sizes."""
        moved = self.place + (memory.offset - self.offset)[self.stage]
        return _Elements(self.stage, moved, memory.offset)


class _Memory:
    """The memory of one matrix per stage as one flat array, from the lowest address to the highest."""

    def __init__(self, matrices: Any, rows: Index, columns: Index) -> None:
        structs = [matrices[k] for k in range(rows.size)]
        for struct, m, n in zip(structs, rows, columns, strict=True):
            if struct.m < m or struct.n < n:
                raise c.InterfaceError(f"a matrix of fatrop is {struct.m} × {struct.n}, not {m} × {n}")
        address = np.array([struct.pA or 0 for struct in structs], dtype=np.int64)
        width = np.array([struct.cn for struct in structs], dtype=np.int64)
        length = np.array([struct.pm * struct.cn for struct in structs], dtype=np.int64)
        present = length > 0
        base = int(address[present].min()) if present.any() else 0
        self._width, self._offset = width, np.where(present, (address - base) // 8, 0)
        end = int((self._offset + length)[present].max()) if present.any() else 0
        self.data: Array = (
            np.ctypeslib.as_array((ctypes.c_double * end).from_address(base)) if end else np.empty(0)
        )
        panels = -(-rows // c.PANEL) * c.PANEL
        self._parts = [
            self.data[o : o + w * p] for o, w, p in zip(self._offset, width, panels, strict=True) if w and p
        ]
        self._sizes = list(zip(rows.tolist(), columns.tolist(), strict=True))
        self._is_ready = False

    @property
    def offset(self) -> Index:
        """Where the matrix of each stage begins in `data`."""
        return self._offset

    def index(self, stage: Index, row: Index, column: Index) -> _Elements:
        """Where elements of the stages' matrices stand in `data`."""
        inside = row % c.PANEL
        place = (row - inside) * self._width[stage]
        place += self._offset[stage]
        place += column * c.PANEL
        place += inside
        return _Elements(stage, place, self._offset)

    def beside(self, places: Index) -> Array:
        """All elements but those at some places and in the last rows of the stages."""
        is_ours = np.zeros(self.data.size, dtype=bool)
        for k, (rows, columns) in enumerate(self._sizes):
            row, column = np.divmod(np.arange((rows - 1) * columns), max(columns, 1))
            is_ours[self.index(np.full(row.size, k), row, column).place] = True
        is_ours[places] = False
        return self.data[is_ours]

    def make_ready(self) -> None:
        """Sets all elements to zero, unless nobody but the same evaluation has written anything."""
        if not self._is_ready:
            self.clear()
            self._is_ready = True

    def clear(self) -> None:
        """Sets all elements to zero."""
        for part in self._parts:
            part[:] = 0.0
        self._is_ready = False
