"""Names for the entries of a vector of variables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


class Layout:
    """Consecutive groups of entries by name.

    >>> layout = Layout([("base", 6), ("force", 12)])
    >>> layout.size, layout["force"]
    (18, slice(6, 18, None))
    """

    def __init__(self, groups: Sequence[tuple[str, int]]) -> None:
        self._slices: dict[str, slice] = {}
        begin = 0
        for name, size in groups:
            self._slices[name] = slice(begin, begin + size)
            begin += size
        self.size = begin

    def __getitem__(self, name: str) -> slice:
        return self._slices[name]

    def parts(self, values: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
        """Views of the groups of a vector, by name."""
        return {name: values[place] for name, place in self._slices.items()}

    def index(self, name: str) -> NDArray[np.intp]:
        """Numbers of the entries of a group."""
        return np.arange(self.size)[self._slices[name]]


@dataclass(frozen=True)
class StageLayout:
    """Order of the variables where intervals follow one another: a node, then the inputs of its interval.

    Attributes:
        node: the state, then what the stage must know of the inputs before.
        inputs: those of an interval.
        steerable: legs whose heading is part of the state.
        last: size of the state; the last node has nothing else.
    """

    node: Layout
    inputs: Layout
    steerable: tuple[int, ...]
    last: int

    @property
    def stage(self) -> int:
        """Variables of an interval."""
        return self.node.size + self.inputs.size

    def total(self, count: int) -> int:
        """Variables of `count` intervals and the last node."""
        return count * self.stage + self.last

    def rows(self, variables: NDArray[np.float64], count: int) -> NDArray[np.float64]:
        """The variables of each interval, (count, stage)."""
        return variables[: count * self.stage].reshape(count, self.stage)

    def variables(self, count: int) -> NDArray[np.intp]:
        """Numbers of the variables of each interval: node, inputs, next node; −1 for what is not there."""
        result = np.arange(count) * self.stage + np.arange(self.stage + self.node.size)[:, None]
        result[self.stage + self.last :, -1] = -1  # nothing follows that would need the last inputs
        return result

    def last_variables(self, count: int) -> NDArray[np.intp]:
        """Numbers of the variables of the last node."""
        return (count * self.stage + np.arange(self.last))[:, None]

    def defined(self, rows: int) -> NDArray[np.intp]:
        """Which local variable each row of a stage defines: the first rows the next node, the others none."""
        result = np.full(rows, -1, dtype=np.intp)
        result[: self.node.size] = self.stage + np.arange(self.node.size)
        return result
