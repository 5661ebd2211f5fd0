"""Fatrop called directly, with the stage functions evaluated all at once and put in its matrices by index.

Fatrop numbers a stage's variables (u, x), minimises over stages k = 0 … N with x⁺ = F(x, u), and wants

    BAbt[k]      (∂F/∂(u, x) | F − x⁺)ᵀ                 of the rows that define the next state
    Ggt[k]       (∂g/∂(u, x) | g)ᵀ                      of the other equations
    Ggt_ineq[k]  (∂g/∂(u, x) | g)ᵀ                      of inequalities, bounds of variables among them
    RSQrqt[k]    (∂²L/∂(u, x)² | ∂L/∂(u, x))            L without the x⁺ of x⁺ = F

Rows of the NLP that define the next state read x⁺ − F, so their multipliers change sign on the way.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.solvers import fatrop_library as c
from rollgait.solvers.interrupt import deferred_interrupt
from rollgait.solvers.solution import Iteration, Progress, Solution
from rollgait.transcription.base import Structure
from rollgait.transcription.nlp import Block, Nlp

Array = NDArray[np.float64]
Index = NDArray[np.intp]

Options = dict[str, float | int]
STATUS = {0: "Solve_Succeeded", 1: "Unknown", 2: "Maximum_Iterations_Exceeded"}


class DirectFatrop:
    """A solver for one NLP with stages, built once, solved as often as needed.

    Raises:
        InterfaceError: the library is not the expected one.
    """

    name = "fatrop"

    def __init__(self, nlp: Nlp, structure: Structure, options: Options, warm_options: Options) -> None:
        self.nlp, self._options, self._warm_options = nlp, options, warm_options
        self._library = c.library()
        self._rows = _Rows(nlp, structure)
        self._stages = [_StageEvaluation(nlp, block) for block in nlp.blocks]
        self._guess = np.zeros(nlp.size)
        self._known: tuple[Array, float, Array] = (np.empty(0), 0.0, np.empty(0))
        self._progress: Progress | None = None
        self._stop: Callable[[], bool] = lambda: False
        self._error: BaseException | None = None
        self._iteration = 0
        self._jacobians: dict[int, _JacobianFill] = {}
        self._hessians: dict[int, _HessianFill] = {}
        self._interface = self._make_interface()
        self._solver = ctypes.c_void_p(
            self._library.fatrop_ocp_c_create(ctypes.byref(self._interface), None, None)
        )
        if not self._solver:
            raise c.InterfaceError("fatrop could not be set up")
        self._check_dimensions()

    def __del__(self) -> None:
        if getattr(self, "_solver", None):
            self._library.fatrop_ocp_c_destroy(self._solver)

    def solve(self, guess: Array, progress: Progress | None = None, warm: bool = False) -> Solution:
        """The solution from a guess of the free variables; `warm` says that the guess is near a solution.

        Raises:
            KeyboardInterrupt: the user interrupted it.
        """
        self._guess, self._progress, self._error, self._iteration = (
            np.asarray(guess, float),
            progress,
            None,
            0,
        )
        for name, value in (self._options | (self._warm_options if warm else {})).items():
            kind = "double" if isinstance(value, float) else "int"
            getattr(self._library, f"fatrop_ocp_c_set_option_{kind}")(self._solver, name.encode(), value)
        with deferred_interrupt() as self._stop:
            flag = int(self._library.fatrop_ocp_c_solve(self._solver))
        if self._error is not None:
            raise self._error
        primal = self._library.fatrop_ocp_c_get_primal(self._solver).contents
        w = np.empty(self.nlp.size)
        w[self._rows.order] = np.ctypeslib.as_array(primal.pa, (self.nlp.size,))
        f, g = self._values(w)
        stats = self._library.fatrop_ocp_c_get_stats(self._solver).contents
        return Solution(
            w=w,
            g=g,
            cost=f,
            solved=flag == 0 and bool(np.isfinite(w).all()),
            status=STATUS.get(flag, f"status {flag}"),
            iterations=int(stats.iterations_count),
        )

    # -- values -----------------------------------------------------------------------------------------

    def _values(self, w: Array) -> tuple[float, Array]:
        """Cost and constraints at the free variables; fatrop asks for both, and again with the Jacobian."""
        if not np.array_equal(w, self._known[0]):
            cost, g = 0.0, np.empty(self.nlp.rows)
            for stage in self._stages:
                value, rows = stage.value(w)
                cost += float(value.sum())
                g[stage.row_number] = rows[stage.row_source]
            self._known = (w, cost, g)
        return self._known[1:]

    def _gradient(self, w: Array) -> Array:
        total = np.zeros(self.nlp.size)
        for stage in self._stages:
            parts = stage.gradient(w)[stage.variable_source]
            total += np.bincount(stage.variable_number, parts, minlength=self.nlp.size)
        return total

    # -- callbacks --------------------------------------------------------------------------------------

    def _make_interface(self) -> c.Interface:
        rows, nlp = self._rows, self.nlp
        primal = self._from_primal

        def copy(target: Any, values: Array) -> int:
            if values.size:
                np.ctypeslib.as_array(target, (values.size,))[:] = values
            return 0

        def objective(scale: float, x: Any, _s: Any, _g: Any, result: Any, _d: Any, _u: Any) -> int:
            result[0] = scale * self._guarded(lambda: self._values(primal(x))[0], np.nan)
            return c.SKIP

        def gradient(scale: float, x: Any, _s: Any, _g: Any, result: Any, _d: Any, _u: Any) -> int:
            nothing = np.full(nlp.size, np.nan)
            value = self._guarded(lambda: self._gradient(primal(x)), nothing)
            copy(result, scale * value[rows.order])
            return c.SKIP

        def violation(x: Any, _s: Any, _g: Any, result: Any, dims: Any, _u: Any) -> int:
            nothing = np.full(rows.total, np.nan)
            copy(result, self._guarded(lambda: self._violation(primal(x), dims.contents), nothing))
            return c.SKIP

        def jacobian(x: Any, _s: Any, _g: Any, BAbt: Any, Ggt: Any, Ggt_ineq: Any, dims: Any, _u: Any) -> int:
            self._guarded(lambda: self._put_jacobian(primal(x), (BAbt, Ggt, Ggt_ineq)), None)
            return c.SKIP

        def hessian(scale: float, x: Any, lam: Any, _s: Any, _g: Any, out: Any, dims: Any, _u: Any) -> int:
            self._guarded(lambda: self._put_hessian(scale, primal(x), lam, out, dims.contents), None)
            return c.SKIP

        def bounds(low: Any, high: Any, k: int, _u: Any) -> int:
            lower, upper = rows.bounds(k)
            return copy(low, lower) or copy(high, upper)

        return c.Interface(
            get_nx=c.GetDimension(lambda k, _: rows.nx[k]),
            get_nu=c.GetDimension(lambda k, _: rows.nu[k]),
            get_ng=c.GetDimension(lambda k, _: rows.n_equal[k]),
            get_ng_ineq=c.GetDimension(lambda k, _: rows.n_unequal[k]),
            get_n_stage_params=c.GetDimension(lambda k, _: 0),
            get_n_global_params=c.GetNumber(lambda _: 0),
            get_default_stage_params=c.GetStageValues(lambda *_: 0),
            get_default_global_params=c.GetValues(lambda *_: 0),
            get_horizon_length=c.GetNumber(lambda _: len(rows.nx)),
            get_bounds=c.GetBounds(bounds),
            get_initial_xk=c.GetStageValues(lambda x, k, _: copy(x, self._guess[rows.states(k)])),
            get_initial_uk=c.GetStageValues(lambda u, k, _: copy(u, self._guess[rows.inputs(k)])),
            full_eval_lag_hess=c.FullHessian(hessian),
            full_eval_constr_jac=c.FullJacobian(jacobian),
            full_eval_contr_viol=c.FullViolation(violation),
            full_eval_obj_grad=c.FullObjective(gradient),
            full_eval_obj=c.FullObjective(objective),
        )

    def _guarded(self, evaluate: Callable[[], Any], otherwise: Any) -> Any:
        """An exception cannot pass through foreign code: it is kept, and the solver is made to give up."""
        try:
            if self._error is None:
                if self._stop():
                    raise KeyboardInterrupt
                return evaluate()
        except BaseException as error:
            self._error = error
            self._library.fatrop_ocp_c_set_option_int(self._solver, b"max_iter", 0)
        return otherwise

    def _from_primal(self, x: Any) -> Array:
        w = np.empty(self.nlp.size)
        w[self._rows.order] = np.ctypeslib.as_array(x, (self.nlp.size,))
        return w

    def _violation(self, w: Array, dims: c.Dims) -> Array:
        rows = self._rows
        _, g = self._values(w)
        result = np.zeros(rows.total)
        place = rows.places(dims)
        result[place.equal] = (g - self.nlp.g_lower)[rows.equal]
        result[place.unequal] = g[rows.unequal]
        result[place.bounded] = w[rows.bounded]
        result[place.defining] = (self.nlp.g_lower - g)[rows.defining]
        return result

    def _put_jacobian(self, w: Array, matrices: Sequence[Any]) -> None:
        # fatrop keeps more than one set of matrices and passes now one, now another
        key = matrices[0][0].pA
        if key not in self._jacobians:
            self._jacobians[key] = _JacobianFill(self.nlp, self._rows, matrices)
        _, g = self._values(w)
        self._jacobians[key].put(np.concatenate([stage.jacobian(w) for stage in self._stages]), g, w)

    def _put_hessian(self, scale: float, w: Array, lam: Any, matrix: Any, dims: c.Dims) -> None:
        rows, place = self._rows, self._rows.places(dims)
        given = np.ctypeslib.as_array(lam, (rows.total,))
        multipliers = np.zeros(self.nlp.rows + 1)
        multipliers[rows.equal] = given[place.equal]
        multipliers[rows.unequal] = given[place.unequal]
        multipliers[rows.defining] = -given[place.defining]
        key = matrix[0].pA
        if key not in self._hessians:
            self._hessians[key] = _HessianFill(self.nlp, self._rows, matrix)
        second, first = zip(*(stage.hessian(w, scale, multipliers) for stage in self._stages), strict=True)
        self._hessians[key].put(np.concatenate(second), np.concatenate(first), given[place.bounded])
        self._report(w)

    def _report(self, w: Array) -> None:
        self._iteration += 1
        if self._progress is not None:
            cost, g = self._values(w)
            worst = float(self.nlp.violations(g, w).max(initial=0.0))
            self._progress(Iteration(self._iteration, cost, worst))

    def _check_dimensions(self) -> None:
        """The sizes that fatrop reports back must be ours, or its structures are not those of this adapter."""
        dims, rows = self._library.fatrop_ocp_c_get_dims(self._solver).contents, self._rows
        stages = len(rows.nx)
        if stages != dims.K or any(
            [getattr(dims, name)[k] for k in range(stages)] != list(sizes)
            for name, sizes in (
                ("nx", rows.nx),
                ("nu", rows.nu),
                ("ng", rows.n_equal),
                ("ng_ineq", rows.n_unequal),
            )
        ):
            raise c.InterfaceError("fatrop's C interface is not the expected one: it reports other sizes")


@dataclass(frozen=True)
class _Places:
    """Where fatrop keeps the equations, inequalities, bounds and defining rows in its vector of constraints."""

    equal: Index
    unequal: Index
    bounded: Index
    defining: Index


class _Rows:
    """Which rows and bounds of the NLP belong to which stage, in which column, and the order of the variables.

    Attributes:
        order: for each of fatrop's variables its number in the NLP.
        stage, local: of each variable of the NLP its stage and its number in the stage's (u, x).
        equal, unequal, defining: rows of the NLP that are equations, inequalities, definitions of the next state.
        bounded: variables with bounds.
    """

    def __init__(self, nlp: Nlp, structure: Structure) -> None:
        self.nx, self.nu = structure.nx, structure.nu
        nx, nu = np.array(structure.nx), np.array(structure.nu)
        stages = nx.size
        self._nlp = nlp
        self._begin = np.concatenate([[0], np.cumsum(nx + nu)])
        stage = np.repeat(np.arange(stages), nx + nu)
        inside = np.arange(nlp.size) - self._begin[stage]
        self.stage = stage
        self.local = np.where(inside < nx[stage], inside + nu[stage], inside - nx[stage])
        self.order = np.empty(nlp.size, dtype=np.intp)
        self.order[self._begin[stage] + self.local] = np.arange(nlp.size)
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
        self._places: _Places | None = None
        self._bounds = self._sorted_bounds(stages)

    def _sorted_bounds(self, stages: int) -> list[tuple[Array, Array]]:
        nlp = self._nlp
        result = [(np.empty(n), np.empty(n)) for n in self.n_unequal]
        for row in self.unequal:
            low, high = result[self.row_stage[row]]
            low[self.column[row]], high[self.column[row]] = nlp.g_lower[row], nlp.g_upper[row]
        for variable, column in zip(self.bounded, self.bound_column, strict=True):
            low, high = result[self.stage[variable]]
            low[column], high[column] = nlp.lower[variable], nlp.upper[variable]
        return result

    def bounds(self, k: int) -> tuple[Array, Array]:
        """Limits of the inequalities of a stage."""
        return self._bounds[k]

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

    def places(self, dims: c.Dims) -> _Places:
        """Where fatrop keeps what."""
        if self._places is None:
            stages = len(self.nx)
            g, ineq = (
                np.ctypeslib.as_array(offset, (stages,)).astype(np.intp)
                for offset in (dims.g_offs, dims.g_ineq_offs)
            )
            dyn = np.ctypeslib.as_array(dims.dyn_eq_offs, (stages - 1,)).astype(np.intp)
            self._places = _Places(
                equal=g[self.row_stage[self.equal]] + self.column[self.equal],
                unequal=ineq[self.row_stage[self.unequal]] + self.column[self.unequal],
                bounded=ineq[self.stage[self.bounded]] + self.bound_column,
                defining=dyn[self.row_stage[self.defining]] + self.column[self.defining],
            )
        return self._places


class _StageEvaluation:
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
        self._value = _Buffered(f.value.map(count), inputs)
        self._gradient = _Buffered(f.gradient.map(count), inputs)
        self._jacobian = _Buffered(f.jacobian.map(count), inputs)
        self._hessian = _Buffered(f.hessian.map(count), [*inputs, self._lam_f, self._lam])

    def _load(self, w: Array) -> None:
        np.take(np.concatenate([w, self._constants]), self._position, out=self._y)

    def value(self, w: Array) -> tuple[Array, Array]:
        """Costs of the repetitions and their rows, flat."""
        self._load(w)
        cost, rows = self._value()
        return cost, rows

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


class _Buffered:
    """A CasADi function on fixed arrays."""

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
        return [array[:size] for array, size in zip(self._outputs, self._sizes, strict=True)]


class _JacobianFill:
    """Where each derivative and each row goes in fatrop's matrices of constraints, found once, used by index."""

    def __init__(self, nlp: Nlp, rows: _Rows, matrices: Sequence[Any]) -> None:
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


class _HessianFill:
    """Where each second derivative of the Lagrangian, and each first one, goes in fatrop's matrices of costs."""

    def __init__(self, nlp: Nlp, rows: _Rows, matrix: Any) -> None:
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

    def put(self, second: Array, first: Array, bound_multipliers: Array) -> None:
        """Puts the Hessian of the Lagrangian and its gradient in place."""
        self._memory.clear()
        data = self._memory.data
        data[self._upper] = data[self._lower] = second[self._pairs]
        data[self._below] = first[self._slopes]
        data[self._bound] += bound_multipliers


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


def _count_within(group: Index) -> Index:
    """Running number of each element among those of the same group (equal groups need not stand together)."""
    order = np.argsort(group, kind="stable")
    sorted_group = group[order]
    begins = np.searchsorted(sorted_group, sorted_group, side="left")
    result = np.empty(group.size, dtype=np.intp)
    result[order] = np.arange(group.size) - begins
    return result
