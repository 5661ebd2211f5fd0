"""Stage functions over all their repetitions, in buffers without a copy."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rollgait.transcription.buffered import Buffered, repeated
from rollgait.transcription.nlp import Block, Nlp

Array = NDArray[np.float64]


class StageEvaluation:
    """A block's functions over all its repetitions, evaluated in buffers without a copy.

    Attributes:
        position: of each local variable in [free variables; `fixed_values`], flat.
        y, lam, lam_f: what the functions read: local variables, multipliers of rows and of the cost.
        lam_index: which of the NLP's rows the multipliers are of, flat.
        buffers: the functions, by name.
        row_number, row_source: the NLP's rows and where they stand among the block's, flat.
        variable_number, variable_source: the NLP's variables and where they stand among the local ones, flat.
    """

    def __init__(self, nlp: Nlp, block: Block) -> None:
        f, count = block.function, block.stage.count
        self.position = nlp.positions(block).T.ravel()
        self._constants = nlp.fixed_values
        self.y = np.empty(self.position.size)
        self._p = np.ascontiguousarray(block.stage.parameters.T).ravel()
        number = nlp.row_numbers(block).T.ravel()
        self.row_source = np.flatnonzero(number >= 0)
        self.row_number = number[self.row_source]
        self.lam_index = np.where(number >= 0, number, nlp.rows)
        self.lam, self.lam_f = np.empty(number.size), np.empty(count)
        self.variable_source = np.flatnonzero(self.position < nlp.size)
        self.variable_number = self.position[self.variable_source]
        inputs = [self.y, self._p]
        self.buffers = {
            "value": Buffered(repeated(f.value, count), inputs),
            "gradient": Buffered(repeated(f.gradient, count), inputs),
            "jacobian": Buffered(repeated(f.jacobian, count), inputs),
            "hessian": Buffered(repeated(f.hessian, count), [*inputs, self.lam_f, self.lam]),
        }
        self._value_of_one, self._count = f.value, count

    @cached_property
    def _first(self) -> Buffered:
        """The first repetition alone: only a controller asks for it."""
        return Buffered(
            self._value_of_one, [array[: array.size // self._count] for array in (self.y, self._p)]
        )

    def _load(self, w: Array) -> None:
        np.take(np.concatenate([w, self._constants]), self.position, out=self.y)

    def value(self, w: Array) -> tuple[Array, Array]:
        """Costs of the repetitions and their rows, flat."""
        self._load(w)
        cost, rows = self.buffers["value"]()
        return cost, rows

    def first_cost(self, w: Array) -> float:
        """Cost of the first repetition alone."""
        self._load(w)
        return float(self._first()[0][0])

    def gradient(self, w: Array) -> Array:
        """Local gradients of the cost, flat."""
        self._load(w)
        return self.buffers["gradient"]()[0]

    def jacobian(self, w: Array) -> Array:
        """Nonzeros of the local Jacobians, flat."""
        self._load(w)
        return self.buffers["jacobian"]()[0]

    def hessian(self, w: Array, scale: float, multipliers: Array) -> tuple[Array, Array]:
        """Nonzeros of the local Hessians of the Lagrangian and its local gradients, flat.

        Args:
            w: free variables.
            scale: multiplier of the cost.
            multipliers: of the NLP's rows, and a zero for rows that are none.
        """
        self._load(w)
        self.lam_f[:] = scale
        np.take(multipliers, self.lam_index, out=self.lam)
        second, first = self.buffers["hessian"]()
        return second, first
