"""One stage of the horizon as a function of its own variables, written once and repeated over the horizon.

`StageBuilder` is where the terms of a problem meet the instants of a transcription: it evaluates each
term at each of its places, collects the rows with their limits, and turns the terms' data into
parameters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.ocp.instant import Body, Instant
from rollgait.ocp.problem import Problem
from rollgait.ocp.term import Constraint, Cost, FootConstraint, Limits, Mask, Place
from rollgait.robot.robot import LEG_NAMES

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RowLabel:
    """What a row of a stage means: its term, the leg (None for the whole robot), the place in the stage."""

    term: str
    leg: int | None = None
    place: str = ""
    component: int = 0
    unit: str = ""
    scale: float = 1.0
    """Size of one unit of the row, in `unit`: forces are solved for in units of the robot's weight."""

    def describe(self) -> str:
        """Term, leg and place in words."""
        leg = f" of {LEG_NAMES[self.leg]}" if self.leg is not None else ""
        return f"{self.term}{leg}"


@dataclass(frozen=True)
class Stage:
    """A stage function and the numbers for its repetitions.

    Attributes:
        y: local variables.
        p: parameters.
        cost: Σ of the weighted costs.
        costs: the same term by term.
        rows: constraint rows.
        parameters: values of p, (n_p, count).
        lower, upper: limits of the rows, (n_rows, count).
        holds: where each row is part of the problem, (n_rows, count).
        labels: what each row means.
    """

    y: ca.SX
    p: ca.SX
    cost: ca.SX
    costs: dict[str, ca.SX]
    rows: ca.SX
    parameters: Array
    lower: Array
    upper: Array
    holds: Mask
    labels: tuple[RowLabel, ...]

    @property
    def count(self) -> int:
        """How often the stage is repeated."""
        return int(self.parameters.shape[1])


class StageBuilder:
    """Collects the costs, rows and parameters of one stage."""

    def __init__(self, problem: Problem, count: int, only_at_nodes: bool = False) -> None:
        """`count` is N for the stage of an interval and 1 for that of the end of the horizon.

        With `only_at_nodes`, constraints on states are tightened by what may happen between the nodes.
        """
        self.problem = problem
        self.count = count
        self._only_at_nodes = only_at_nodes
        self._symbols: list[ca.SX] = []
        self._values: list[Array] = []
        self._costs: dict[str, ca.SX] = {}
        self._rows: list[ca.SX] = [ca.SX(0, 1)]
        self._lower: list[Array] = [np.zeros((0, count))]
        self._upper: list[Array] = [np.zeros((0, count))]
        self._holds: list[Mask] = [np.zeros((0, count), dtype=bool)]
        self._labels: list[RowLabel] = []
        self.body = self._make_body()

    # -- data --------------------------------------------------------------------------------------------

    def symbol(self, name: str, value: ArrayLike) -> ca.SX:
        """A parameter: a column of symbols with the values (n,) for all stages or (n, N) stage by stage."""
        array = np.atleast_1d(np.asarray(value, dtype=float))
        array = array[:, None] if array.ndim == 1 else array
        symbol = ca.SX.sym(name, array.shape[0])
        self._symbols.append(symbol)
        self._values.append(self._per_stage(array))
        return symbol

    def _per_stage(self, array: Array) -> Array:
        """Values for each repetition; the end of the horizon takes those of the last interval."""
        if self.count == 1:
            return array[:, -1:]
        return np.broadcast_to(array, (array.shape[0], self.count))

    def _data(self, prefix: str, values: Mapping[str, ArrayLike]) -> SimpleNamespace:
        return SimpleNamespace(**{name: self.symbol(f"{prefix}_{name}", v) for name, v in values.items()})

    def _make_body(self) -> Body:
        robot, scenario = self.problem.robot, self.problem.scenario
        mass = self.symbol("mass", [robot.mass])
        inertia = self.symbol("inertia", robot.inertia_matrix[np.triu_indices(3)])
        stance = self.symbol("stance", robot.stance.ravel())
        return Body(
            mass=mass,
            weight=self.symbol("weight", [robot.weight]),
            inertia=symmetric(inertia),
            stance=ca.reshape(stance, 3, 4),
            heading_offset=self.symbol("heading_offset", [leg.heading for leg in robot.leg_list]),
            interval=self.symbol("interval", [self.problem.schedule.interval]),
            ground=self.symbol("ground", [scenario.ground.height] * 4),
        )

    # -- terms -------------------------------------------------------------------------------------------

    def add_rows(
        self, expression: ca.SX, label: RowLabel, limits: Limits = (0.0, 0.0), holds: Mask | None = None
    ) -> None:
        """Rows lower ≤ expression ≤ upper; they hold in the stages where `holds` (count,) says so."""
        count = expression.numel()
        for component in range(count):
            self._labels.append(
                RowLabel(label.term, label.leg, label.place, component, label.unit, label.scale)
            )
        mask = np.ones(self.count, dtype=bool) if holds is None else holds
        self._rows.append(ca.vec(expression))
        self._lower.append(self._limit(limits[0], count))
        self._upper.append(self._limit(limits[1], count))
        self._holds.append(np.broadcast_to(mask, (count, self.count)))

    def _limit(self, value: ArrayLike, rows: int) -> Array:
        array = np.atleast_2d(np.asarray(value, dtype=float))
        return np.broadcast_to(self._per_stage(array), (rows, self.count))

    def add_costs(self, points: Sequence[Instant], quadrature: Array, terminal: bool) -> None:
        """The costs of the problem: integrated over the interval by its points, or those at the end."""
        for cost in self.problem.costs:
            if cost.terminal == terminal:
                self._add_cost(cost, points, quadrature)

    def _add_cost(self, cost: Cost, points: Sequence[Instant], quadrature: Array) -> None:
        d = self._data(cost.name, cost.data(self.problem))
        weight = self.symbol(f"{cost.name}_weight", [cost.weight])
        length = ca.SX(1) if cost.terminal else self.body.interval
        values = [b * cost.expression(x, d) for b, x in zip(quadrature, points, strict=True)]
        self._costs[cost.name] = weight * length * sum(values, start=ca.SX(0))

    def add_constraints(self, instants: Mapping[Place, Sequence[Instant]]) -> None:
        """The constraints of the problem, at those places that this stage has."""
        for term in self.problem.constraints:
            places = [place for place in instants if place in term.places]
            if not places:
                continue
            if isinstance(term, Constraint):
                self._add_constraint(term, places, instants)
            else:
                for leg in range(len(LEG_NAMES)):
                    if term.applies(self.problem, leg):
                        self._add_foot_constraint(term, leg, places, instants)

    def _add_constraint(
        self, term: Constraint, places: Sequence[Place], instants: Mapping[Place, Sequence[Instant]]
    ) -> None:
        d = self._data(term.name, term.data(self.problem))
        for place in places:
            holds = self._mask(term.holds(self.problem, place))
            for x in instants[place]:
                label = RowLabel(term.name, None, place.name, unit=term.unit)
                self.add_rows(term.expression(x, d), label, term.limits(self.problem), holds)

    def _add_foot_constraint(
        self,
        term: FootConstraint,
        leg: int,
        places: Sequence[Place],
        instants: Mapping[Place, Sequence[Instant]],
    ) -> None:
        d = self._data(f"{term.name}_{LEG_NAMES[leg]}", term.data(self.problem, leg))
        is_force = term.unit == "N"
        scale = self.problem.robot.weight if is_force else 1.0
        unit = self.body.weight if is_force else ca.SX(1)
        between = self.problem.schedule.interval**2 / 8.0 * term.curvature if self._only_at_nodes else 0.0
        low, high = (np.asarray(limit, dtype=float) for limit in term.limits(self.problem, leg))
        low, high = (low + between) / scale, (high - between) / scale
        for place in places:
            holds = self._mask(term.holds(self.problem, place, leg))
            for x in instants[place]:
                label = RowLabel(term.name, leg, place.name, unit=term.unit, scale=scale)
                self.add_rows(term.expression(x, x.feet[leg], d) / unit, label, (low, high), holds)

    def _mask(self, holds: Mask) -> Mask:
        return holds[-1:] if self.count == 1 else holds

    # -- result ------------------------------------------------------------------------------------------

    def finish(self, y: ca.SX) -> Stage:
        """The stage as a function of its local variables `y`."""
        return Stage(
            y=y,
            p=ca.vertcat(*self._symbols),
            cost=sum(self._costs.values(), start=ca.SX(0)),
            costs=dict(self._costs),
            rows=ca.vertcat(*self._rows),
            parameters=np.vstack(self._values),
            lower=np.vstack(self._lower),
            upper=np.vstack(self._upper),
            holds=np.vstack(self._holds),
            labels=tuple(self._labels),
        )


def symmetric(upper: ca.SX) -> ca.SX:
    """A 3 × 3 matrix from its upper triangle (xx, xy, xz, yy, yz, zz)."""
    xx, xy, xz, yy, yz, zz = (upper[i] for i in range(6))
    return ca.vertcat(ca.horzcat(xx, xy, xz), ca.horzcat(xy, yy, yz), ca.horzcat(xz, yz, zz))
