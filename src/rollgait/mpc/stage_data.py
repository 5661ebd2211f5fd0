"""A stage whose numbers stay open: named parameters and named rows, filled in place before each solve."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.transcription.stage import RowLabel, Stage

Array = NDArray[np.float64]


class LiveStage:
    """Collects symbols, costs and rows of one stage, then hands out their numbers by name."""

    def __init__(self, count: int) -> None:
        self.count = count
        self._symbols: list[ca.SX] = []
        self._places: dict[str, slice] = {}
        self._size = 0
        self._rows: list[ca.SX] = [ca.SX(0, 1)]
        self._row_places: dict[str, slice] = {}
        self._labels: list[RowLabel] = []
        self._fixed: list[bool] = []
        self.residuals: list[ca.SX] = []
        self._costs: dict[str, ca.SX] = {}

    def symbol(self, name: str, size: int) -> ca.SX:
        """A parameter of that many numbers in each repetition."""
        self._places[name] = slice(self._size, self._size + size)
        self._size += size
        symbol = ca.SX.sym(name, size)
        self._symbols.append(symbol)
        return symbol

    def add_cost(self, name: str, factor: ca.SX, residual: ca.SX) -> None:
        """factor · ‖residual‖²; the factor must not be negative."""
        column = ca.vec(residual)
        self._costs[name] = factor * ca.sumsqr(column)
        self.residuals.append(ca.sqrt(2.0 * factor) * column)

    def add_rows(self, name: str, expression: ca.SX, equation: bool = False, unit: str = "") -> None:
        """Rows with limits under this name; those of an equation are 0 = expression."""
        column = ca.vec(expression)
        begin = len(self._labels)
        self._labels += [RowLabel(name, None, "NODE", i, unit) for i in range(column.numel())]
        self._fixed += [equation] * column.numel()
        self._row_places[name] = slice(begin, len(self._labels))
        self._rows.append(column)

    def finish(self, y: ca.SX) -> Stage:
        """The stage. Its arrays are the ones that `numbers` and `limits` show."""
        fixed = np.array(self._fixed, dtype=bool)[:, None]
        shape = (len(self._labels), self.count)
        # Fortran order: the solver reads these very numbers, stage after stage
        self._parameters: Array = np.zeros((self._size, self.count), order="F")
        self._stage = Stage(
            y=y,
            p=ca.vertcat(*self._symbols),
            cost=sum(self._costs.values(), start=ca.SX(0)),
            costs=dict(self._costs),
            rows=ca.vertcat(*self._rows),
            parameters=self._parameters,
            lower=np.broadcast_to(np.where(fixed, 0.0, -1.0), shape).copy(),
            upper=np.broadcast_to(np.where(fixed, 0.0, 1.0), shape).copy(),
            holds=np.ones(shape, dtype=bool),
            labels=tuple(self._labels),
        )
        return self._stage

    def numbers(self, name: str) -> Array:
        """The numbers of a parameter, (size, count): a view to write to."""
        return self._parameters[self._places[name]]

    def has(self, name: str) -> bool:
        """Whether there is such a parameter."""
        return name in self._places

    def rows(self, name: str) -> slice:
        """Which rows of the stage have this name."""
        return self._row_places[name]
