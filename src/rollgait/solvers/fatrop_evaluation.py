"""What fatrop asks of a problem, answered by NumPy: values and derivatives, put where fatrop wants them.

Fatrop hands in addresses: x of its variables, and where a result is to go. `compiled_evaluation.py` has the
same in C, which takes a tenth of the time where a problem is small.
"""

from __future__ import annotations

import ctypes
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.solvers import fatrop_library as c
from rollgait.solvers.fatrop_matrices import HessianFill, JacobianFill
from rollgait.solvers.fatrop_rows import Rows
from rollgait.solvers.stage_evaluation import StageEvaluation
from rollgait.transcription.nlp import Nlp

Array = NDArray[np.float64]

DOUBLE: Final = ctypes.sizeof(ctypes.c_double)


class NotFiniteError(Exception):
    """A derivative is no number: in fatrop's matrices it could keep it from ever finding a factorisation."""


class Evaluation:
    """One NLP at the iterates of fatrop.

    Args:
        nlp, rows: the problem.
        dims: how fatrop numbers constraints.

    Attributes:
        stages: the functions.
        jacobians, hessians: where derivatives go in each set of fatrop's matrices, by its memory. Fatrop
            keeps more than one set and passes now one, now another.
    """

    def __init__(self, nlp: Nlp, rows: Rows, dims: c.Dims) -> None:
        self.nlp, self._rows, self._places = nlp, rows, rows.places(dims)
        self.stages = [StageEvaluation(nlp, block) for block in nlp.blocks]
        self.jacobians: dict[int, JacobianFill] = {}
        self.hessians: dict[int, HessianFill] = {}
        self._given: Array = np.zeros(rows.total)
        self._row_multipliers: Array = np.zeros(nlp.rows + 1)
        self._last_multipliers: tuple[float, Array, Array] | None = None
        self._numbers = b""
        self._known: tuple[bytes, float, Array] = (b"", 0.0, np.empty(0))

    def begin(self) -> None:
        """Of a solve: fixed variables, parameters and limits are those of now."""
        self._last_multipliers = None
        self._take_numbers()

    def _take_numbers(self) -> None:
        """What is known of the last iterate holds only with the fixed variables and parameters of then."""
        numbers = (self.nlp.fixed_values, *(block.stage.parameters for block in self.nlp.blocks))
        bits = b"".join(array.tobytes("A") for array in numbers)
        if bits != self._numbers:
            self._numbers = bits
            self._forget()

    def _forget(self) -> None:
        self._known = (b"", 0.0, np.empty(0))

    # -- values ------------------------------------------------------------------------------------------

    def values(self, w: Array) -> tuple[float, Array]:
        """Cost and constraints at the free variables, for the NLP as it is now."""
        self._take_numbers()
        return self._values(w)

    def _values(self, w: Array) -> tuple[float, Array]:
        """Fatrop asks for both at once, and again with the Jacobian."""
        if (bits := w.tobytes()) != self._known[0]:
            cost, g = 0.0, np.empty(self.nlp.rows)
            for stage in self.stages:
                value, rows = stage.value(w)
                cost += float(value.sum())
                g[stage.row_number] = rows[stage.row_source]
            self._known = (bits, cost, g)
        return self._known[1:]

    def variables(self, x: int) -> Array:
        """The free variables of the NLP."""
        w = np.empty(self.nlp.size)
        w[self._rows.order] = read(x, self.nlp.size)
        return w

    def cost(self, x: int) -> float:
        """The cost."""
        return self._values(self.variables(x))[0]

    def worst(self, x: int) -> float:
        """Largest violation of a constraint, scaled as fatrop sees it; may be NaN."""
        w = self.variables(x)
        return float(self.nlp.violations(self._values(w)[1], w).max(initial=0.0))

    @property
    def multipliers(self) -> tuple[Array, Array] | None:
        """Of rows and of bounds where the Hessian was evaluated last; None if it was not."""
        if self._last_multipliers is None:
            return None
        scale, of_rows, given = self._last_multipliers
        of_bounds = np.zeros(self.nlp.size)
        of_bounds[self._rows.bounded] = given[self._places.bounded]
        return of_rows[:-1] / scale, of_bounds / scale

    def _keep_multipliers(self, scale: float) -> None:
        if scale:  # a restoration of the constraints knows no cost
            self._last_multipliers = (scale, self._row_multipliers.copy(), self._given.copy())

    # -- what fatrop asks for ----------------------------------------------------------------------------

    def put_cost(self, scale: float, x: int, result: int) -> None:
        """The cost, times a scale."""
        write(result, np.array([scale * self.cost(x)]))

    def put_gradient(self, scale: float, x: int, result: int) -> None:
        """The gradient of the cost, times a scale."""
        w, total = self.variables(x), np.zeros(self.nlp.size)
        for stage in self.stages:
            parts = stage.gradient(w)[stage.variable_source]
            total += np.bincount(stage.variable_number, parts, minlength=self.nlp.size)
        write(result, scale * total[self._rows.order])

    def put_violation(self, x: int, result: int) -> None:
        """All constraints, less the right sides of equations."""
        rows, place, w = self._rows, self._places, self.variables(x)
        _, g = self._values(w)
        found = np.zeros(rows.total)
        found[place.equal] = (g - self.nlp.g_lower)[rows.equal]
        found[place.unequal] = g[rows.unequal]
        found[place.bounded] = w[rows.bounded]
        found[place.defining] = (self.nlp.g_lower - g)[rows.defining]
        write(result, found)

    def put_jacobian(self, x: int, matrices: tuple[int, int, int]) -> None:
        """The Jacobian. Raises `NotFiniteError`."""
        w = self.variables(x)
        _, g = self._values(w)
        values = np.concatenate([stage.jacobian(w) for stage in self.stages])
        _check_finite(values)
        self.jacobian_fill(matrices).put(values, g, w)

    def put_hessian(self, scale: float, x: int, lam: int, matrix: int) -> None:
        """The Hessian of the Lagrangian. Raises `NotFiniteError`."""
        rows, place, w = self._rows, self._places, self.variables(x)
        given, multipliers = read(lam, rows.total), self._row_multipliers
        self._given[:] = given
        multipliers[rows.equal] = given[place.equal]
        multipliers[rows.unequal] = given[place.unequal]
        multipliers[rows.defining] = -given[place.defining]
        parts = zip(*(stage.hessian(w, scale, multipliers) for stage in self.stages), strict=True)
        second, first = (np.concatenate(part) for part in parts)
        _check_finite(second)
        self.hessian_fill(matrix).put(second, first, given[place.bounded])
        self._keep_multipliers(scale)

    # -- where it goes -----------------------------------------------------------------------------------

    def jacobian_fill(self, matrices: tuple[int, int, int]) -> JacobianFill:
        """Where derivatives go in a set of matrices."""
        if (key := memory_of(matrices[0])) not in self.jacobians:
            like = next(iter(self.jacobians.values()), None)
            pointers = [_matrices(address) for address in matrices]
            self.jacobians[key] = JacobianFill(self.nlp, self._rows, pointers, like)
        return self.jacobians[key]

    def hessian_fill(self, matrix: int) -> HessianFill:
        """Where derivatives go in a set of matrices."""
        if (key := memory_of(matrix)) not in self.hessians:
            like = next(iter(self.hessians.values()), None)
            self.hessians[key] = HessianFill(self.nlp, self._rows, _matrices(matrix), like)
        return self.hessians[key]


class StagewiseCalls:
    """What fatrop asks for stage by stage, in every solve: limits and the guess, always in the same memory.

    Args:
        rows: where limits are.
        guess: of the free variables.

    Attributes:
        bounds, states, inputs: the functions.
        user_data: what fatrop is to hand to them.
    """

    user_data: int | None = None

    def __init__(self, rows: Rows, guess: Array) -> None:
        begin, low, high = (array.ctypes.data for array in (guess, *rows.limits))

        def put(target: int, source: int, part: slice) -> int:
            ctypes.memmove(target, source + DOUBLE * part.start, DOUBLE * (part.stop - part.start))
            return 0

        def put_bounds(to_low: int, to_high: int, k: int, _u: Any) -> int:
            return put(to_low, low, rows.bounds(k)) or put(to_high, high, rows.bounds(k))

        self.bounds = c.GetBounds(put_bounds)
        self.states = c.GetStageValues(lambda x, k, _: put(x, begin, rows.states(k)))
        self.inputs = c.GetStageValues(lambda u, k, _: put(u, begin, rows.inputs(k)))


def memory_of(matrices: int) -> int:
    """Where the first of some matrices keeps its numbers; they themselves have one address for all sets."""
    return int(ctypes.c_void_p.from_address(matrices + c.Matrix.pA.offset).value or 0)


def _matrices(address: int) -> Any:
    return ctypes.cast(address, ctypes.POINTER(c.Matrix))


def _check_finite(derivatives: Array) -> None:
    if not np.isfinite(derivatives).all():
        raise NotFiniteError


# NumPy's own view of a pointer would leave a cycle for the garbage collector, a dozen in each solve


def read(address: int, count: int) -> Array:
    """Numbers at an address."""
    values: Array = np.empty(count)
    ctypes.memmove(values.ctypes.data, address, DOUBLE * count)
    return values


def write(address: int, values: Array) -> None:
    """Puts numbers at an address."""
    ctypes.memmove(address, np.ascontiguousarray(values).ctypes.data, DOUBLE * values.size)
