"""The numbers of a stage: parameters, limits, and where rows hold, put in place without a symbol."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.dynamics.wrench import WRENCH_SIZE
from rollgait.footing.footing import PARAMETERS
from rollgait.ocp.problem import Problem
from rollgait.ocp.term import Constraint, Cost, FootConstraint, Mask, Place
from rollgait.robot.robot import LEG_NAMES
from rollgait.transcription.code import CodeStore, Recipe, StageCode, StageSymbols
from rollgait.transcription.uses import Outline, TermUse, outline

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


@dataclass(frozen=True, eq=False)
class Stage:
    """A stage's code and the numbers for its repetitions.

    Attributes:
        code: what is repeated.
        parameters: values of p, (n_p, count).
        lower, upper: limits of the rows, (n_rows, count).
        holds: where each row is part of the problem, (n_rows, count).
        weight: of the robot, N: the scale of rows in units of it.
    """

    code: StageCode
    parameters: Array
    lower: Array
    upper: Array
    holds: Mask
    weight: float

    @property
    def count(self) -> int:
        """How often the stage is repeated."""
        return int(self.parameters.shape[1])

    @cached_property
    def labels(self) -> tuple[RowLabel, ...]:
        """What each row means."""
        return tuple(
            RowLabel(g.term, g.leg, g.place, i, g.unit, self.weight if g.by_weight else 1.0)
            for g in self.code.groups
            for i in range(g.count)
        )


@dataclass(frozen=True)
class RowNumbers:
    """Limits of rows and where they hold; each broadcasts to (rows, count)."""

    lower: ArrayLike = 0.0
    upper: ArrayLike = 0.0
    holds: Mask | None = None


_memory: dict[tuple[CodeStore | None, str], StageCode] = {}
"""Codes of this process, by where they are kept and their key: a store may hand out faster ones."""


def make_stage(
    recipe: Recipe,
    problem: Problem,
    store: CodeStore | None = None,
    own_rows: Mapping[str, RowNumbers] | None = None,
    own_numbers: Mapping[str, Array] | None = None,
) -> Stage:
    """A stage of a problem: its code, made now or long ago, with the problem's numbers.

    Args:
        recipe: how the stage is written.
        problem: whose numbers.
        store: where codes are kept; None keeps them in this process only.
        own_rows: numbers of the rows that the recipe adds by itself; those not named are 0 = row, always.
        own_numbers: of further parameters that the recipe reads, (size, N) each.
    """
    own_numbers = own_numbers or {}
    extra = () if problem.footing.is_flat else tuple(PARAMETERS.items())
    extra += () if problem.wrench is None else (("wrench", WRENCH_SIZE),)
    extra += tuple((name, value.shape[0]) for name, value in own_numbers.items())
    plan = outline(recipe.name, problem.terms, problem, recipe.places, recipe.terminal, extra)
    code = find_code(recipe, plan, store)
    return _Filling(recipe, problem, plan).stage(code, own_rows or {}, own_numbers)


def find_code(recipe: Recipe, plan: Outline, store: CodeStore | None) -> StageCode:
    """The code of a stage: from this process, from the store, or derived now."""
    key = plan.key
    known = (store, key)
    if known not in _memory:
        code = store.load(key) if store is not None else None
        if code is None:
            symbols = StageSymbols(plan)
            code = symbols.derive(recipe.write(symbols))
            if store is not None:
                code = store.keep(key, code, recipe.worth_compiling)
        _memory[known] = code
    return _memory[known]


def forget_codes() -> None:
    """Empties the memory of this process; what a store keeps remains."""
    _memory.clear()


class _Filling:
    """Puts the numbers of a problem into the places of a stage."""

    def __init__(self, recipe: Recipe, problem: Problem, plan: Outline) -> None:
        self._recipe, self._problem, self._plan = recipe, problem, plan
        self._count = 1 if recipe.terminal else problem.schedule.intervals

    def stage(
        self, code: StageCode, own_rows: Mapping[str, RowNumbers], own_numbers: Mapping[str, Array]
    ) -> Stage:
        values = _body_numbers(self._problem) | dict(own_numbers)
        for use in self._plan.uses:
            values |= use.numbers
        stacked = np.vstack([self._per_stage(values[name], size) for name, size in code.parameters])
        parameters = np.asfortranarray(stacked)  # a solver reads these very numbers, stage after stage
        rows = dict(own_rows)
        for use in self._plan.uses:
            for place in use.places:
                rows[use.source(place)] = self._row_numbers(use, place)
        shape = (code.rows, self._count)
        lower, upper, holds = np.zeros(shape), np.zeros(shape), np.ones(shape, dtype=bool)
        begin = 0
        for group in code.groups:
            numbers = rows.get(group.source, RowNumbers())
            scale = self._problem.robot.weight if group.by_weight else 1.0
            part = slice(begin, begin + group.count)
            lower[part] = self._per_stage(_column(numbers.lower), group.count) / scale
            upper[part] = self._per_stage(_column(numbers.upper), group.count) / scale
            if numbers.holds is not None:
                holds[part] = numbers.holds[-1:] if self._recipe.terminal else numbers.holds
            begin += group.count
        return Stage(code, parameters, lower, upper, holds, self._problem.robot.weight)

    def _per_stage(self, array: Array, rows: int) -> Array:
        """Values for each repetition; the end of the horizon takes those of the last interval."""
        values = array[:, -1:] if self._recipe.terminal else array
        return np.broadcast_to(values, (rows, self._count))

    def _row_numbers(self, use: TermUse, place: Place) -> RowNumbers:
        term, problem = use.term, self._problem
        assert not isinstance(term, Cost)
        if isinstance(term, Constraint):
            limits, holds = term.limits(problem), term.holds(problem, place)
        else:
            assert isinstance(term, FootConstraint)
            assert use.leg is not None
            limits, holds = term.limits(problem, use.leg), term.holds(problem, place, use.leg)
        low, high = (np.asarray(limit, dtype=float) for limit in limits)
        bulge = self._bulge(term) if self._recipe.only_at_nodes and term.curvature else 0.0
        return RowNumbers(low + bulge, high - bulge, holds)

    def _bulge(self, term: Constraint | FootConstraint) -> Array:
        """By how much a constraint may be missed beside its nodes, (1, N): in the longer interval of both."""
        return np.asarray(self._problem.beside_nodes[None, :] ** 2 / 8.0 * term.curvature)


def _column(value: ArrayLike) -> Array:
    return np.atleast_2d(np.asarray(value, dtype=float))


def _body_numbers(problem: Problem) -> dict[str, Array]:
    robot, upper = problem.robot, np.triu_indices(3)
    inertia = robot.inertia_matrix
    values = {
        "mass": [robot.mass],
        "weight": [robot.weight],
        "inertia": inertia[upper],
        "inertia_inverse": np.linalg.inv(inertia)[upper],
        "stance": robot.stance.ravel(),
        "heading_offset": [leg.heading for leg in robot.leg_list],
        "ground": [problem.footing.level] * 4,
    }
    columns = {name: np.asarray(value, dtype=float)[:, None] for name, value in values.items()}
    by_interval = {"interval": problem.schedule.lengths[None, :]}
    if problem.wrench is not None:
        by_interval["wrench"] = problem.wrench
    return columns | by_interval | ({} if problem.footing.is_flat else problem.footing.parameters())
