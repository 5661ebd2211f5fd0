"""A stage in symbols and as functions: what depends on kinds of feet, terms and transcription, never on
numbers.

Schedules, goals, robots, ground and mesh are numbers that `stage.py` puts into the parameters and limits of
a `StageCode`; so one serves all plans of its kind. It is made once in a process, and kept by a `CodeStore`
(on disk, compiled) it is not made again in the next one either.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, Protocol

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.ground import MODEL_SIZE, FootGround
from rollgait.errors import InputError
from rollgait.footing.footing import FEET, LEAVE_SIZE
from rollgait.ocp.instant import Body, Instant
from rollgait.ocp.term import Cost, Place
from rollgait.transcription.uses import BODY_SIZES, Outline, TermUse

Index = NDArray[np.intp]
Array = NDArray[np.float64]

FUNCTION_NAMES = ("value", "gradient", "jacobian", "hessian", "costs")
"""The functions of a stage, by the name of their attribute."""
EVALUATED = FUNCTION_NAMES[:4]
"""Those that a solver evaluates again and again: worth compiling."""


@dataclass(frozen=True)
class RowGroup:
    """Consecutive rows of a stage that come from one expression.

    Attributes:
        source: where their limits and intervals come from (`stage.RowNumbers`).
        term: whose they are.
        leg: of a foot's rows, else None.
        place: name of the place in the stage.
        unit: of the rows, for messages.
        by_weight: whether they are divided by the robot's weight.
        count: how many.
    """

    source: str
    term: str
    leg: int | None
    place: str
    unit: str
    by_weight: bool
    count: int


@dataclass(frozen=True, eq=False)
class StageCode:
    """A stage and its derivatives as CasADi functions of (y, p): local variables and parameters.

    Attributes:
        value: (y, p) to the cost and the rows.
        gradient: (y, p) to that of the cost.
        jacobian: (y, p) to the nonzeros of that of the rows.
        hessian: (y, p, multiplier of the cost, multipliers of the rows) to the nonzeros of the upper
            triangle of that of the Lagrangian, and its gradient.
        costs: (y, p) to the cost term by term.
        jacobian_rows, jacobian_cols, hessian_rows, hessian_cols: where the nonzeros stand.
        linear: which nonzeros of the Jacobian depend on no local variable.
        parameters: names and sizes of what p is made of, in its order.
        groups: the rows.
        cost_names: the costs, in the order of `costs`.
    """

    value: ca.Function
    gradient: ca.Function
    jacobian: ca.Function
    hessian: ca.Function
    costs: ca.Function
    jacobian_rows: Index
    jacobian_cols: Index
    hessian_rows: Index
    hessian_cols: Index
    linear: NDArray[np.bool_]
    parameters: tuple[tuple[str, int], ...]
    groups: tuple[RowGroup, ...]
    cost_names: tuple[str, ...]

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return sum(group.count for group in self.groups)

    def with_functions(self, functions: Mapping[str, ca.Function]) -> StageCode:
        """The same with other functions of the same values, by the names of `FUNCTION_NAMES`."""
        changed: dict[str, Any] = dict(functions)
        return replace(self, **changed)


class CodeStore(Protocol):
    """Keeps stage codes, perhaps beyond the process, perhaps in a faster form."""

    def load(self, key: str) -> StageCode | None:
        """What is kept under a key; None if nothing is."""

    def keep(self, key: str, code: StageCode, compile_it: bool) -> StageCode:
        """Keeps a code and returns it, or a faster one with the same values."""


class Recipe(Protocol):
    """How a transcription writes one of its stages."""

    @property
    def name(self) -> str:
        """Of transcription and stage."""

    @property
    def places(self) -> Mapping[Place, int]:
        """How many instants there are at each place of the stage."""

    @property
    def terminal(self) -> bool:
        """Whether it is the end of the horizon."""

    @property
    def only_at_nodes(self) -> bool:
        """Whether constraints on states are tightened by what may happen between the nodes."""

    @property
    def worth_compiling(self) -> bool:
        """Whether it is evaluated so often that compiling pays."""

    def write(self, symbols: StageSymbols) -> ca.SX:
        """Writes rows and costs into `symbols`; the local variables."""


class StageSymbols:
    """Collects the costs and rows of one stage over symbols of its parameters."""

    def __init__(self, outline: Outline) -> None:
        self.outline = outline
        self._symbols: dict[str, ca.SX] = {}
        self._costs: dict[str, ca.SX] = {}
        self._residuals: list[ca.SX] = []
        self._rows: list[ca.SX] = [ca.SX(0, 1)]
        self._groups: list[RowGroup] = []
        for name, size in (*BODY_SIZES.items(), *outline.extra):
            self.symbol(name, size)
        for use in outline.uses:
            for name, size in use.sizes:
                self.symbol(name, size)
        p = self._symbols
        self.body = Body(
            mass=p["mass"],
            weight=p["weight"],
            inertia=symmetric(p["inertia"]),
            stance=ca.reshape(p["stance"], 3, 4),
            heading_offset=p["heading_offset"],
            interval=p["interval"],
            ground=p["ground"],
            terrain=_terrain(p),
            tilt=_tilt(p),
            wrench=p.get("wrench"),
        )
        self.leaves = _leaves(p)
        self.inertia_inverse = symmetric(p["inertia_inverse"])

    def symbol(self, name: str, size: int) -> ca.SX:
        """A parameter of that many numbers in each repetition."""
        self._symbols[name] = ca.SX.sym(name, size)
        return self._symbols[name]

    def __getitem__(self, name: str) -> ca.SX:
        return self._symbols[name]

    # -- rows and costs ----------------------------------------------------------------------------------

    def add_rows(
        self,
        expression: ca.SX,
        term: str,
        place: str = "",
        *,
        leg: int | None = None,
        unit: str = "",
        source: str | None = None,
        by_weight: bool = False,
    ) -> None:
        """Rows lower ≤ expression ≤ upper; the numbers come from `source`, by default named as the term."""
        column = ca.vec(expression)
        group = RowGroup(source or term, term, leg, place, unit, by_weight, column.numel())
        self._groups.append(group)
        self._rows.append(column / self.body.weight if by_weight else column)

    def add_costs(self, points: Sequence[Instant], quadrature: Array, terminal: bool = False) -> None:
        """The costs of the problem: integrated over the interval by its points, or those at the end."""
        length = ca.SX(1) if terminal else self.body.interval
        for use in self.outline.uses:
            if isinstance(use.term, Cost) and use.term.terminal == terminal:
                d, weight = self._data(use), self[use.weight]
                values = [b * use.term.expression(x, d) for b, x in zip(quadrature, points, strict=True)]
                self._costs[use.term.name] = weight * length * sum(values, start=ca.SX(0))

    def add_cost(self, name: str, cost: ca.SX) -> None:
        """A cost of the recipe's own."""
        self._costs[name] = cost

    def add_squares(self, x: Instant, length: ca.SX) -> None:
        """The costs of the problem at one instant by their residuals, for a Gauss-Newton Hessian.

        Raises:
            InputError: a cost is no sum of squares.
        """
        for use in self.outline.uses:
            if isinstance(use.term, Cost):
                residual = use.term.residual(x, self._data(use))
                if residual is None:
                    rule = "must be a sum of squares, given by `residual`, for a controller"
                    raise InputError("terms", use.term.name, rule)
                factor = self[use.weight] * (1 if use.term.terminal else length)
                self.add_square(use.term.name, factor, residual)

    def add_square(self, name: str, factor: ca.SX, residual: ca.SX) -> None:
        """The cost factor · ‖residual‖²; the factor must not be negative."""
        column = ca.vec(residual)
        self._costs[name] = factor * ca.sumsqr(column)
        self._residuals.append(ca.sqrt(2.0 * factor) * column)

    def add_constraints(self, instants: Mapping[Place, Sequence[Instant]]) -> None:
        """The constraints of the problem, at those places that this stage has."""
        for use in self.outline.uses:
            if not isinstance(use.term, Cost):
                d = self._data(use)
                for place in use.places:
                    for x in instants[place]:
                        self.add_rows(
                            use.expression(x, d),
                            use.term.name,
                            place.name,
                            leg=use.leg,
                            unit=use.term.unit,
                            source=use.source(place),
                            by_weight=use.term.by_weight,
                        )

    def _data(self, use: TermUse) -> SimpleNamespace:
        return SimpleNamespace(**{own: self[name] for own, name in use.parameters.items()})

    # -- result ------------------------------------------------------------------------------------------

    def derive(self, y: ca.SX) -> StageCode:
        """The code of the stage over its local variables `y`.

        Where the costs were given by squares ½ ‖r‖² the Hessian is the Gauss-Newton one, (∂r/∂y)ᵀ ∂r/∂y:
        never indefinite, and blind to the curvature of the rows.
        """
        p, rows = ca.vertcat(*self._symbols.values()), ca.vertcat(*self._rows)
        cost = sum(self._costs.values(), start=ca.SX(0))
        lam_f, lam = ca.SX.sym("lam_f"), ca.SX.sym("lam", rows.numel())
        jacobian = ca.jacobian(rows, y)
        lagrangian = lam_f * cost + ca.dot(lam, rows)
        if not self._residuals:
            full_hessian, lagrangian_gradient = ca.hessian(lagrangian, y)
        else:
            slopes = ca.jacobian(ca.vertcat(*self._residuals), y)
            full_hessian, lagrangian_gradient = lam_f * (slopes.T @ slopes), ca.gradient(lagrangian, y)
        hessian = ca.triu(full_hessian)
        expressions = {
            "value": ([y, p], [cost, rows]),
            "gradient": ([y, p], [ca.gradient(cost, y)]),
            "jacobian": ([y, p], [_nonzeros(jacobian)]),
            "hessian": ([y, p, lam_f, lam], [_nonzeros(hessian), lagrangian_gradient]),
            "costs": ([y, p], [ca.vertcat(*self._costs.values())]),
        }
        functions: dict[str, Any] = {
            name: ca.Function(f"stage_{name}", inputs, outputs, {"cse": True})
            for name, (inputs, outputs) in expressions.items()
        }
        (jacobian_rows, jacobian_cols), (hessian_rows, hessian_cols) = _pattern(jacobian), _pattern(hessian)
        depends = ca.which_depends(_nonzeros(jacobian), y, 1, True)
        return StageCode(
            **functions,
            jacobian_rows=jacobian_rows,
            jacobian_cols=jacobian_cols,
            hessian_rows=hessian_rows,
            hessian_cols=hessian_cols,
            linear=np.array([not it for it in depends], dtype=bool),
            parameters=tuple((name, symbol.numel()) for name, symbol in self._symbols.items()),
            groups=tuple(self._groups),
            cost_names=tuple(self._costs),
        )


def _terrain(p: Mapping[str, ca.SX]) -> tuple[FootGround, ...] | None:
    """The ground under each foot, where a stage knows of more than its height."""
    if "ground_model" not in p:
        return None
    models = ca.vertsplit(p["ground_model"], MODEL_SIZE)
    slopes = ca.vertsplit(p["contact_slope"], 2)
    return tuple(
        FootGround(ca.vertsplit(models[i]), ca.vertsplit(slopes[i]), p["foot_radius"][i]) for i in range(FEET)
    )


def _tilt(p: Mapping[str, ca.SX]) -> tuple[ca.SX, ca.SX] | None:
    """Pitch and roll that the ground asks for at both ends of the interval, 2 each."""
    return (p["base_tilt"][:2], p["base_tilt"][2:]) if "base_tilt" in p else None


def _leaves(p: Mapping[str, ca.SX]) -> tuple[FootGround, ...] | None:
    """By how much the ground of the interval lies above that of the next, about the place of its model."""
    if "ground_leave" not in p:
        return None
    models, leaves = ca.vertsplit(p["ground_model"], MODEL_SIZE), ca.vertsplit(p["ground_leave"], LEAVE_SIZE)
    return tuple(
        FootGround([*ca.vertsplit(models[i][:2]), *ca.vertsplit(leaves[i])], [0.0, 0.0], 0.0)
        for i in range(FEET)
    )


def symmetric(upper: ca.SX) -> ca.SX:
    """A 3 × 3 matrix from its upper triangle (xx, xy, xz, yy, yz, zz)."""
    xx, xy, xz, yy, yz, zz = (upper[i] for i in range(6))
    return ca.vertcat(ca.horzcat(xx, xy, xz), ca.horzcat(xy, yy, yz), ca.horzcat(xz, yz, zz))


def _nonzeros(matrix: ca.SX) -> ca.SX:
    return ca.SX(matrix.nz[:]) if matrix.nnz() else ca.SX(0, 1)


def _pattern(matrix: ca.SX) -> tuple[Index, Index]:
    rows, cols = matrix.sparsity().get_triplet()
    return np.array(rows, dtype=np.intp), np.array(cols, dtype=np.intp)
