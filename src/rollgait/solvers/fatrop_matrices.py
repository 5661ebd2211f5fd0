"""Where each derivative goes in fatrop's matrices: found once, used by index."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.solvers import fatrop_library as c
from rollgait.solvers.fatrop_rows import Rows
from rollgait.transcription.nlp import Nlp

Array = NDArray[np.float64]
Index = NDArray[np.intp]


class JacobianFill:
    """Where each derivative and each row goes in fatrop's matrices of constraints."""

    def __init__(self, nlp: Nlp, rows: Rows, matrices: Sequence[Any]) -> None:
        self._nlp, self._rows = nlp, rows
        sizes = np.array(rows.nx) + np.array(rows.nu)
        below = sizes  # the row under the derivatives
        columns = (np.array(rows.nx[1:]), np.array(rows.n_equal), np.array(rows.n_unequal))
        self._memories = [
            _Memory(matrix, sizes[: width.size] + 1, width)
            for matrix, width in zip(matrices, columns, strict=True)
        ]
        row, column = [], []
        for block in nlp.blocks:
            f = block.function
            row.append(nlp.row_numbers(block)[f.jacobian_rows].T.ravel())
            column.append(nlp.positions(block)[f.jacobian_cols].T.ravel())
        r, v = np.concatenate(row), np.concatenate(column)
        used = np.flatnonzero((r >= 0) & (v < nlp.size))
        used = used[rows.row_stage[r[used]] == rows.stage[v[used]]]  # not the x⁺ of x⁺ − F
        r, v = r[used], v[used]
        kind = np.zeros(nlp.rows, dtype=int)
        kind[rows.equal], kind[rows.unequal] = 1, 2
        self._parts = []
        for number, (memory, which) in enumerate(
            zip(self._memories, (rows.defining, rows.equal, rows.unequal), strict=True)
        ):
            mine = kind[r] == number
            derivative = memory.index(rows.row_stage[r[mine]], rows.local[v[mine]], rows.column[r[mine]])
            stage = rows.row_stage[which]
            self._parts.append(
                (derivative, used[mine], memory.index(stage, below[stage], rows.column[which]))
            )
        stage = rows.stage[rows.bounded]
        memory = self._memories[2]
        self._bound_entry = memory.index(stage, rows.local[rows.bounded], rows.bound_column)
        self._bound_row = memory.index(stage, below[stage], rows.bound_column)

    def put(self, values: Array, g: Array, w: Array) -> None:
        """Puts the derivatives of all rows, and the rows themselves, in place."""
        nlp, rows = self._nlp, self._rows
        residuals = ((nlp.g_lower - g)[rows.defining], (g - nlp.g_lower)[rows.equal], g[rows.unequal])
        for memory, (target, source, below), sign, residual in zip(
            self._memories, self._parts, (-1.0, 1.0, 1.0), residuals, strict=True
        ):
            memory.clear()
            memory.data[target] = sign * values[source]
            memory.data[below] = residual
        unequal = self._memories[2].data
        unequal[self._bound_entry] = 1.0
        unequal[self._bound_row] = w[rows.bounded]

    def put_nothing(self) -> None:
        """All rows are zero and nothing depends on anything."""
        for memory in self._memories:
            memory.clear()


class HessianFill:
    """Where each second and first derivative of the Lagrangian goes in fatrop's matrices of costs."""

    def __init__(self, nlp: Nlp, rows: Rows, matrix: Any) -> None:
        sizes = np.array(rows.nx) + np.array(rows.nu)
        self._memory = _Memory(matrix, sizes + 1, sizes)
        first, second, variable = [], [], []
        for block in nlp.blocks:
            position, f = nlp.positions(block), block.function
            first.append(position[f.hessian_rows].T.ravel())
            second.append(position[f.hessian_cols].T.ravel())
            stage = np.broadcast_to(block.first + np.arange(position.shape[1]), position.shape)
            # the next node is among the local variables, but not in this stage's part of the Lagrangian
            inside = np.append(rows.stage, -1)[np.minimum(position, nlp.size)] == stage
            variable.append(np.where(inside, position, nlp.size).T.ravel())
        a, b = np.concatenate(first), np.concatenate(second)
        self._pairs = np.flatnonzero((a < nlp.size) & (b < nlp.size))
        a, b = a[self._pairs], b[self._pairs]
        self._upper = self._memory.index(rows.stage[a], rows.local[a], rows.local[b])
        self._lower = self._memory.index(rows.stage[a], rows.local[b], rows.local[a])
        v = np.concatenate(variable)
        self._slopes = np.flatnonzero(v < nlp.size)
        v = v[self._slopes]
        self._below = self._memory.index(rows.stage[v], sizes[rows.stage[v]], rows.local[v])
        stage = rows.stage[rows.bounded]
        self._bound = self._memory.index(stage, sizes[stage], rows.local[rows.bounded])
        self._diagonal = self._memory.index(rows.stage, rows.local, rows.local)

    def put(self, second: Array, first: Array, bound_multipliers: Array) -> None:
        """Puts the Hessian of the Lagrangian and its gradient in place."""
        self._memory.clear()
        data = self._memory.data
        data[self._upper] = data[self._lower] = second[self._pairs]
        data[self._below] = first[self._slopes]
        data[self._bound] += bound_multipliers

    def put_identity(self) -> None:
        """The Lagrangian of half the square of all variables."""
        self._memory.clear()
        self._memory.data[self._diagonal] = 1.0


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

    def index(self, stage: Index, row: Index, column: Index) -> Index:
        """Where an element of a stage's matrix stands in `data`."""
        panel, inside = row // c.PANEL, row % c.PANEL
        place = self._offset[stage] + panel * c.PANEL * self._width[stage] + column * c.PANEL + inside
        return np.asarray(place)

    def clear(self) -> None:
        """Sets all elements to zero."""
        for part in self._parts:
            part[:] = 0.0
