"""Stage functions over all their repetitions, in buffers without a copy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rollgait.transcription.buffered import Buffered, repeated
from rollgait.transcription.nlp import Block, Nlp

Array = NDArray[np.float64]


class StageEvaluation:
    """A block's functions over all its repetitions, evaluated in buffers without a copy.

    Attributes:
        row_number, row_source: the NLP's rows and where they stand among the block's, flat.
        variable_number, variable_source: the NLP's variables and where they stand among the local ones, flat.
    """

    def __init__(self, nlp: Nlp, block: Block) -> None:
        f, count = block.function, block.stage.count
        self._position = nlp.positions(block).T.ravel()
        self._constants = nlp.fixed_values
        self._y = np.empty(self._position.size)
        self._p = np.ascontiguousarray(block.stage.parameters.T).ravel()
        number = nlp.row_numbers(block).T.ravel()
        self.row_source = np.flatnonzero(number >= 0)
        self.row_number = number[self.row_source]
        self._lam_index = np.where(number >= 0, number, nlp.rows)
        self._lam, self._lam_f = np.empty(number.size), np.empty(count)
        self.variable_source = np.flatnonzero(self._position < nlp.size)
        self.variable_number = self._position[self.variable_source]
        inputs = [self._y, self._p]
        self._value = Buffered(repeated(f.value, count), inputs)
        first = [array[: array.size // count] for array in inputs]
        self._first = Buffered(f.value, first)
        self._gradient = Buffered(repeated(f.gradient, count), inputs)
        self._jacobian = Buffered(repeated(f.jacobian, count), inputs)
        self._hessian = Buffered(repeated(f.hessian, count), [*inputs, self._lam_f, self._lam])

    def _load(self, w: Array) -> None:
        np.take(np.concatenate([w, self._constants]), self._position, out=self._y)

    def value(self, w: Array) -> tuple[Array, Array]:
        """Costs of the repetitions and their rows, flat."""
        self._load(w)
        cost, rows = self._value()
        return cost, rows

    def first_cost(self, w: Array) -> float:
        """Cost of the first repetition alone."""
        self._load(w)
        return float(self._first()[0][0])

    def gradient(self, w: Array) -> Array:
        """Local gradients of the cost, flat."""
        self._load(w)
        return self._gradient()[0]

    def jacobian(self, w: Array) -> Array:
        """Nonzeros of the local Jacobians, flat."""
        self._load(w)
        return self._jacobian()[0]

    def hessian(self, w: Array, scale: float, multipliers: Array) -> tuple[Array, Array]:
        """Nonzeros of the local Hessians of the Lagrangian and its local gradients, flat.

        Args:
            w: free variables.
            scale: multiplier of the cost.
            multipliers: of the NLP's rows, and a zero for rows that are none.
        """
        self._load(w)
        self._lam_f[:] = scale
        np.take(multipliers, self._lam_index, out=self._lam)
        second, first = self._hessian()
        return second, first
