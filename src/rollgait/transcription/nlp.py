"""A nonlinear program made of few stage functions, each repeated many times.

    minimise Σ_b Σ_k cost_b(y_bk, p_bk)   subject to   lower ≤ rows_b(y_bk, p_bk) ≤ upper

where y_bk picks its entries out of the vector of all variables. Derivatives are those of the stage functions,
mapped over the repetitions and put in their places by index: nothing grows with the horizon but the arrays.

Variables that a row fixes (the initial state, forces in swing, heights in stance) are constants here,
rows that bound one variable are bounds, and rows without a variable are gone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.transcription.buffered import repeated
from rollgait.transcription.code import StageCode
from rollgait.transcription.presolve import FIXED_TOLERANCE, BoundSources, Presolve
from rollgait.transcription.stage import RowLabel, Stage

Array = NDArray[np.float64]
Index = NDArray[np.intp]

INPUTS = ("x", "p", "lam_f", "lam_g")
"""What `nlpsol` calls the variables, the parameters and the multipliers of cost and constraints."""
OF_MULTIPLIERS = ("nlp_grad", "nlp_hess_l")
"""Functions of all inputs; the others take x and p."""
OUTPUTS = {
    "nlp": ("f", "g"),
    "nlp_f": ("f",),
    "nlp_g": ("g",),
    "nlp_grad_f": ("f", "grad_f_x"),
    "nlp_jac_g": ("g", "jac_g_x"),
    "nlp_grad": ("f", "g", "grad_gamma_x", "grad_gamma_p"),  # the last is asked for, and nobody needs it
    "nlp_hess_l": ("triu_hess_gamma_x_x",),
}
"""What `nlpsol` calls the functions of a program, and what it calls their outputs."""


@dataclass(frozen=True, eq=False)
class Block:
    """A stage function and the variables of its repetitions.

    Attributes:
        stage: the stage with its code, parameters and limits.
        variables: which variable of the whole problem each local one is, (n_y, count); −1 stands for zero.
        first: number of the first repetition on the mesh (for messages).
        next_state: for each row the local variable of the next stage that it defines, −1 if none, (n_rows,).
    """

    stage: Stage
    variables: Index
    first: int = 0
    next_state: Index | None = None

    @property
    def function(self) -> StageCode:
        """The functions of the stage."""
        return self.stage.code


@dataclass(frozen=True)
class RowOrigin:
    """Where a constraint of the whole problem comes from."""

    label: RowLabel
    interval: int


@dataclass(frozen=True)
class BoundOrigin(RowOrigin):
    """Where a bound of a variable comes from: a row that changes by `slope` with the variable."""

    slope: float


@dataclass(frozen=True)
class _Patterns:
    """Sparsities of the whole problem.

    Attributes:
        jacobian: of the constraints.
        jacobian_source: which nonzero of the stages' Jacobians, one after the other, each of its nonzeros is.
        hessian: of the Lagrangian, upper triangle.
        hessian_sum: adds the nonzeros of the stages' Hessians into its nonzeros.
    """

    jacobian: ca.Sparsity
    jacobian_source: Index
    hessian: ca.Sparsity
    hessian_sum: ca.DM


class Nlp:
    """The whole problem, ready for a solver.

    Attributes:
        size: number of free variables.
        rows: number of constraints.
        free: which of all variables are free, in the order of the solver.
        lower, upper: bounds of the free variables.
        g_lower, g_upper: limits of the constraints.
        constants: values of the fixed variables, by their number among all (nan where free).
        contradictions: rows that no variable can satisfy, with by how much.
    """

    def __init__(
        self, blocks: Sequence[Block], total: int, initial: Array, live: bool = False, again: bool = False
    ) -> None:
        """`initial` holds the values of the first variables: the state from which the motion starts.

        With `live`, all numbers may change between solves: only what holds for all of them is left out (the
        first state, rows without a free variable), and nothing is turned into bounds. `again`: see
        `Presolve`.
        """
        self.blocks = tuple(blocks)
        self.total = total
        self._presolve(initial, live, again)
        self._number_rows()

    # -- presolve ----------------------------------------------------------------------------------------

    def _presolve(self, initial: Array, live: bool, again: bool) -> None:
        """Rows of one free variable become bounds, variables with equal bounds constants, until none is."""
        kept = [block.stage.holds & (_limits_something(block.stage) | live) for block in self.blocks]
        self.contradictions: list[tuple[RowOrigin, float]] = []
        if live:
            low, high = np.full(self.total, -np.inf), np.full(self.total, np.inf)
            low[: initial.size] = high[: initial.size] = initial
            self._bound_sources = BoundSources.none(self.total)
            self._split(low, high)
            self._kept = [keep & self._has_free(block) for block, keep in zip(self.blocks, kept, strict=True)]
            return
        known = Presolve(self.blocks, kept, self.total, initial, again)
        self._kept, self._bound_sources = known.kept, known.sources
        self._split(known.low, known.high)
        for number, row, k, excess in known.contradictions:
            self.contradictions.append((self._origin(number, row, k), excess))

    def _split(self, low: Array, high: Array) -> None:
        """Tells free variables from fixed ones."""
        fixed = high - low <= FIXED_TOLERANCE
        middle = 0.5 * (np.where(fixed, low, 0.0) + np.where(fixed, high, 0.0))
        self.constants = np.where(fixed, middle, np.nan)
        self.free = np.flatnonzero(~fixed)
        self.size = self.free.size
        self.lower, self.upper = low[self.free], high[self.free]
        # position of each variable in [free; constants; 0]
        fixed_index = np.flatnonzero(fixed)
        self._position = np.empty(self.total + 1, dtype=np.intp)
        self._position[self.free] = np.arange(self.size)
        self._position[fixed_index] = self.size + np.arange(fixed_index.size)
        self._position[-1] = self.size + fixed_index.size
        self._fixed_values = np.concatenate([self.constants[fixed_index], [0.0]])

    def _has_free(self, block: Block) -> NDArray[np.bool_]:
        """Which rows of a block may depend on a free variable, (n_rows, count)."""
        f, result = block.function, np.zeros((block.function.rows, block.stage.count), dtype=bool)
        is_free = self._position[block.variables] < self.size
        np.logical_or.at(result, f.jacobian_rows, is_free[f.jacobian_cols])
        return result

    def _origin(self, number: int, row: int, k: int) -> RowOrigin:
        block = self.blocks[number]
        return RowOrigin(block.stage.labels[row], block.first + k)

    # -- numbering ---------------------------------------------------------------------------------------

    def _number_rows(self) -> None:
        """Numbers the rows stage after stage; in each, those that define the next state come first."""
        self._order: list[Index] = []
        self._row_number: list[Index] = []
        begin = 0
        lower, upper = [], []
        for block, keep in zip(self.blocks, self._kept, strict=True):
            stage, row = np.nonzero(keep.T)
            defines = self.defines_next(block)[row, stage]
            order = np.lexsort((row, ~defines, stage))
            stage, row = stage[order], row[order]
            number = np.full(keep.shape, -1, dtype=np.intp)
            number[row, stage] = begin + np.arange(row.size)
            begin += row.size
            self._order.append(stage * keep.shape[0] + row)  # in rows written stage after stage
            self._row_number.append(number)
            lower.append(block.stage.lower[row, stage])
            upper.append(block.stage.upper[row, stage])
        self.rows = begin
        self.g_lower, self.g_upper = np.concatenate(lower), np.concatenate(upper)

    def kept(self, block: Block) -> NDArray[np.bool_]:
        """Which rows of a block are constraints of the problem, (n_rows, count)."""
        return self._kept[self.blocks.index(block)]

    def row_numbers(self, block: Block) -> Index:
        """Number of each row of a block among all constraints, −1 if it is none, (n_rows, count)."""
        return self._row_number[self.blocks.index(block)]

    def positions(self, block: Block) -> Index:
        """Where each local variable of a block stands in [free variables; `fixed_values`], (n_y, count)."""
        return self._position[block.variables]

    @property
    def fixed_values(self) -> Array:
        """Values of the variables that are not free, and a zero for those that do not exist."""
        return self._fixed_values

    def defines_next(self, block: Block) -> NDArray[np.bool_]:
        """Which rows of a block define a free variable of the next stage, (n_rows, count)."""
        if block.next_state is None:
            return np.zeros((len(block.stage.labels), block.stage.count), dtype=bool)
        column = block.next_state
        is_free = self._position[block.variables[column]] < self.size
        return np.asarray(is_free & (column >= 0)[:, None])

    @property
    def jacobian_sparsity(self) -> ca.Sparsity:
        """Where the Jacobian of the constraints is not zero."""
        return self._patterns.jacobian

    @property
    def hessian_sparsity(self) -> ca.Sparsity:
        """Where the upper triangle of the Hessian of the Lagrangian is not zero."""
        return self._patterns.hessian

    @cached_property
    def _patterns(self) -> _Patterns:
        """Where the nonzeros of the stage derivatives go in the whole Jacobian and Hessian."""
        j_rows, j_cols, j_source = [], [], []
        h_rows, h_cols, h_source = [], [], []
        j_begin = h_begin = 0
        for block, number in zip(self.blocks, self._row_number, strict=True):
            f, count = block.function, block.stage.count
            position = self._position[block.variables]
            rows, cols = number[f.jacobian_rows], position[f.jacobian_cols]
            used = (rows >= 0) & (cols < self.size)
            source = np.arange(rows.size).reshape(count, -1).T + j_begin  # column-major: stage after stage
            j_rows.append(rows[used])
            j_cols.append(cols[used])
            j_source.append(source[used])
            j_begin += rows.size
            rows, cols = position[f.hessian_rows], position[f.hessian_cols]
            used = (rows < self.size) & (cols < self.size)
            source = np.arange(rows.size).reshape(count, -1).T + h_begin
            h_rows.append(np.minimum(rows, cols)[used])
            h_cols.append(np.maximum(rows, cols)[used])
            h_source.append(source[used])
            h_begin += rows.size
        jacobian, source = _assemble_unique(
            self.rows, self.size, np.concatenate(j_rows), np.concatenate(j_cols), np.concatenate(j_source)
        )
        hessian, total = _assemble_sum(
            self.size, np.concatenate(h_rows), np.concatenate(h_cols), np.concatenate(h_source), h_begin
        )
        return _Patterns(jacobian, source, hessian, total)

    def origin(self, number: int) -> RowOrigin:
        """Where a constraint comes from, by its number among the solver's rows."""
        for which, order in enumerate(self._order):
            if number < order.size:
                k, row = divmod(int(order[number]), self.blocks[which].function.rows)
                return self._origin(which, row, k)
            number -= order.size
        raise IndexError(number)

    @cached_property
    def origins(self) -> list[RowOrigin]:
        """Where each constraint comes from, in the order of the solver's rows."""
        result: list[RowOrigin] = []
        for block, order in zip(self.blocks, self._order, strict=True):
            for k, row in zip(*divmod(order, len(block.stage.labels)), strict=True):
                result.append(RowOrigin(block.stage.labels[row], block.first + int(k)))
        return result

    @cached_property
    def bound_origins(self) -> tuple[list[BoundOrigin | None], list[BoundOrigin | None]]:
        """Which constraint each lower and each upper bound of the free variables comes from."""
        result: list[list[BoundOrigin | None]] = [[], []]
        for side, origins in enumerate(result):
            for block_number, row, stage, slope in self._bound_sources.of(side, self.free):
                if block_number < 0:
                    origins.append(None)
                    continue
                block = self.blocks[block_number]
                origins.append(BoundOrigin(block.stage.labels[row], block.first + stage, slope))
        return result[0], result[1]

    # -- values ------------------------------------------------------------------------------------------

    def _local(self, block: Block, w: Array) -> Array:
        return np.concatenate([w, self._fixed_values])[self._position[block.variables]]

    def all_variables(self, w: Array) -> Array:
        """All variables, the fixed ones included, from the free ones."""
        result = self.constants.copy()
        result[self.free] = w
        return result

    def costs(self, w: Array) -> dict[str, float]:
        """The cost term by term at the free variables `w`."""
        total: dict[str, float] = {}
        for block in self.blocks:
            values = _mapped(block.function.costs, block, self._local(block, w)).sum(axis=1)
            for name, value in zip(block.function.cost_names, values, strict=True):
                total[name] = total.get(name, 0.0) + float(value)
        return total

    def values(self, w: Array) -> tuple[float, Array]:
        """Cost and constraints at the free variables `w`."""
        cost, g = 0.0, []
        for block, order in zip(self.blocks, self._order, strict=True):
            costs, rows = repeated(block.function.value, block.stage.count).call(
                [self._local(block, w), block.stage.parameters]
            )
            cost += float(np.asarray(costs).sum())
            g.append(np.asarray(rows).ravel(order="F")[order])
        return cost, np.concatenate(g)

    def violations(self, g: Array, w: Array) -> Array:
        """By how much each constraint, then each bound, is violated (0 where it holds)."""
        return violations_of(self, g, w)

    def limit_name(self, number: int) -> str:
        """What a constraint, or a bound, is about; numbered as in `violations`."""
        if number < self.rows:
            return self.origin(number).label.describe()
        sides = (origins[number - self.rows] for origins in self.bound_origins)
        return next((origin.label.describe() for origin in sides if origin), "a variable")

    # -- functions of the whole problem ------------------------------------------------------------------

    @property
    def parameters(self) -> Array:
        """All numbers that the problem depends on: fixed variables, then the parameters of each block.

        They are those of now: both may change between solves."""
        return np.concatenate(
            [self._fixed_values, *(b.stage.parameters.ravel(order="F") for b in self.blocks)]
        )

    @cached_property
    def functions(self) -> dict[str, ca.Function]:
        """f, g and their derivatives as CasADi functions of (x, p), under the names that `nlpsol` uses."""
        x, p = ca.MX.sym("x", self.size), ca.MX.sym("p", self.parameters.size)
        lam_f, lam_g = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", self.rows)
        fixed = self._fixed_values.size
        with_constants = ca.vertcat(x, p[:fixed])
        lam_padded = ca.vertcat(lam_g, 0)
        begin = fixed
        f, g_parts, gradient, jacobian, hessian = ca.MX(0), [], ca.MX(self.size, 1), [], []
        for block, order, number in zip(self.blocks, self._order, self._row_number, strict=True):
            function, count = block.function, block.stage.count
            position = self._position[block.variables]
            y = ca.reshape(with_constants[_indices(position)], position.shape[0], count)
            size = block.stage.parameters.size
            parameters = ca.reshape(p[begin : begin + size], -1, count)
            begin += size
            cost, rows = function.value.map(count)(y, parameters)
            f += ca.sum2(cost)
            g_parts.append(ca.vec(rows)[_indices(order)])
            gradient += ca.mtimes(self._gather(position), ca.vec(function.gradient.map(count)(y, parameters)))
            jacobian.append(ca.vec(function.jacobian.map(count)(y, parameters)))
            lam = ca.reshape(lam_padded[_indices(np.where(number < 0, self.rows, number))], -1, count)
            second, _ = function.hessian.map(count)(y, parameters, ca.repmat(lam_f, 1, count), lam)
            hessian.append(ca.vec(second))
        g = ca.vertcat(*g_parts)
        jac_g = ca.MX(self.jacobian_sparsity, ca.vertcat(*jacobian)[_indices(self._patterns.jacobian_source)])
        hess = ca.MX(self.hessian_sparsity, ca.mtimes(self._patterns.hessian_sum, ca.vertcat(*hessian)))
        of_lagrangian = lam_f * gradient + ca.mtimes(jac_g.T, lam_g)
        return named_functions(
            (x, p, lam_f, lam_g),
            {
                "nlp": [f, g],
                "nlp_f": [f],
                "nlp_g": [g],
                "nlp_grad_f": [f, gradient],
                "nlp_jac_g": [g, jac_g],
                "nlp_grad": [f, g, of_lagrangian, ca.MX(1, p.numel())],
                "nlp_hess_l": [hess],
            },
        )

    def _gather(self, position: Index) -> ca.DM:
        """The matrix that adds local gradients (stage after stage) into that of the free variables."""
        flat = position.ravel(order="F")
        local = np.flatnonzero(flat < self.size)
        pattern = ca.Sparsity.triplet(self.size, flat.size, flat[local].tolist(), local.tolist())
        return ca.DM(pattern, 1.0)


class Limits(Protocol):
    """Limits of constraints and bounds of variables."""

    lower: Array
    upper: Array
    g_lower: Array
    g_upper: Array


def violations_of(limits: Limits, g: Array, w: Array) -> Array:
    """By how much each constraint, then each bound, is violated (0 where it holds)."""
    excess = np.maximum(limits.g_lower - g, g - limits.g_upper)
    beyond = np.maximum(limits.lower - w, w - limits.upper)
    return np.asarray(np.maximum(np.concatenate([excess, beyond]), 0.0))


def named_functions(
    inputs: tuple[ca.MX, ca.MX, ca.MX, ca.MX],
    expressions: Mapping[str, Sequence[ca.MX]],
    outputs: Mapping[str, Sequence[str]] = OUTPUTS,
) -> dict[str, ca.Function]:
    """Functions under the names that `nlpsol` uses.

    Args:
        inputs: x, p, lam_f and lam_g; only functions of multipliers take the last two.
        expressions: the outputs of each function.
        outputs: their names.
    """
    result = {}
    for name, values in expressions.items():
        count = len(INPUTS) if name in OF_MULTIPLIERS else 2
        result[name] = ca.Function(name, inputs[:count], values, INPUTS[:count], outputs[name])
    return result


def _limits_something(stage: Stage) -> NDArray[np.bool_]:
    return np.asarray(np.isfinite(stage.lower) | np.isfinite(stage.upper))


def _mapped(function: ca.Function, block: Block, y: Array, output: int = 0) -> Array:
    """A stage function at all repetitions of its block."""
    results = repeated(function, block.stage.count).call([y, block.stage.parameters])
    return np.asarray(results[output])


def _indices(array: Index) -> list[int]:
    return array.ravel(order="F").tolist()


def _assemble_unique(
    n_rows: int, n_cols: int, rows: Index, cols: Index, source: Index
) -> tuple[ca.Sparsity, Index]:
    """A sparsity and, for each of its nonzeros, which source entry fills it; no two may fall together."""
    order = np.lexsort((rows, cols))
    sparsity = ca.Sparsity.triplet(n_rows, n_cols, rows.tolist(), cols.tolist())
    assert sparsity.nnz() == rows.size, "a variable stands twice in one row's stage"
    return sparsity, source[order]


def _assemble_sum(n: int, rows: Index, cols: Index, source: Index, sources: int) -> tuple[ca.Sparsity, ca.DM]:
    """A sparsity and the matrix that adds source entries into its nonzeros."""
    key = cols * n + rows
    unique, target = np.unique(key, return_inverse=True)
    sparsity = ca.Sparsity.triplet(n, n, (unique % n).tolist(), (unique // n).tolist())
    pattern = ca.Sparsity.triplet(unique.size, sources, target.tolist(), source.tolist())
    return sparsity, ca.DM(pattern, 1.0)
