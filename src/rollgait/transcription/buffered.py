"""CasADi functions on arrays that stay where they are: no copy, no object for a number."""

from __future__ import annotations

import ctypes
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@lru_cache(maxsize=64)
def repeated(function: ca.Function, count: int) -> ca.Function:
    """A function of the columns of its arguments. Making it takes longer than to evaluate it a few times."""
    return function.map(count)


class Buffered:
    """A CasADi function on fixed arrays; outputs are the nonzeros, flat, in the same memory each time."""

    def __init__(self, function: ca.Function, inputs: list[Array]) -> None:
        self._inputs = inputs
        self._outputs = [np.zeros(max(1, function.nnz_out(i))) for i in range(function.n_out())]
        self._sizes = [function.nnz_out(i) for i in range(function.n_out())]
        self._buffer, self._evaluate = function.buffer()
        buffer: Any = self._buffer  # (its stub asks for sizes)
        for i, array in enumerate(inputs):
            buffer.set_arg(i, array.data)
        for i, array in enumerate(self._outputs):
            buffer.set_res(i, array.data)

    def __call__(self) -> list[Array]:
        self._evaluate()
        return self.outputs

    @property
    def outputs(self) -> list[Array]:
        """Where the outputs stand."""
        return [array[:size] for array, size in zip(self._outputs, self._sizes, strict=True)]

    @property
    def address(self) -> int:
        """Of CasADi's buffer, for who evaluates it from C."""
        pointer = ctypes.pythonapi.PyCapsule_GetPointer
        pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
        return int(pointer(self._buffer._self(), None))
