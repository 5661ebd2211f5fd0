"""Which constraints stand in the way: the elastic problem, solved a few times with other prices."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.diagnosis.budget import Budget
from rollgait.ocp.goal import GoalPlace, GoalYaw
from rollgait.ocp.problem import Problem, make_problem
from rollgait.ocp.term import Role, Term
from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.trajectory import Trajectory
from rollgait.scenario.scenario import Scenario
from rollgait.solvers import Progress
from rollgait.solvers.code_store import store_for
from rollgait.solvers.ipopt import Ipopt
from rollgait.transcription import transcribe
from rollgait.transcription.elastic import ElasticNlp
from rollgait.transcription.guess import kinematic_guess
from rollgait.transcription.nlp import RowOrigin

Array = NDArray[np.float64]

USUAL_MISS = {"m": 0.02, "m²": 0.02, "rad": 0.05, "m/s": 0.05, "rad/s": 0.2}
"""By the unit of a constraint: what counts as much as a usual miss of another unit."""
USUAL_MISS_FORCE = 0.05
"""The same for forces, as a part of the robot's weight."""
USUAL_MISS_OTHER = 0.05
COST_FACTOR = 0.01
"""Of the scenario's own cost: small enough to buy nothing, large enough to make the motion definite."""
SOFT_GOAL = 0.01
"""Weight of the goal's costs: it is the constraints' turn."""
PRICE_OF_GOAL = 0.01
"""Price of missing the goal at first, so low that no constraint is missed to get there."""
PRICE_OF_END = 10.0
"""Price of an end that is not at rest, level or in the nominal stance: hardly ever what one looks for."""
HIGH_PRICE = 100.0
"""Price of what is to be missed only if nothing else helps."""
NEGLIGIBLE = 0.02
"""Slack, in usual misses, that is left over by the solver's tolerance."""
TRIED_ALONE = 2
"""How many terms are tried as the only reason, the most missed first."""
LOOKING = "looking for the reason"
OPTIONS: dict[str, Any] = {"ipopt.max_iter": 100, "ipopt.tol": 1e-4}


@dataclass(frozen=True)
class Missed:
    """A constraint that is missed: where it comes from and by how much, in its unit."""

    origin: RowOrigin
    excess: float


@dataclass(frozen=True)
class Finding:
    """What the elastic problem says.

    Attributes:
        problem: the scenario's problem.
        missed: constraints that must be missed; empty if there is a motion that keeps them all.
        motion: the elastic motion; None if there is none since numbers contradict each other.
        kept: a motion that keeps all constraints but perhaps misses the goal; None if there is none.
        goal_misses: the smallest misses of the goal, if everything else is kept (x, y in m, yaw in rad).
    """

    problem: Problem
    missed: tuple[Missed, ...]
    motion: Trajectory | None = None
    kept: Trajectory | None = None
    goal_misses: Mapping[tuple[str, int], float] | None = None


def is_goal_promised(scenario: Scenario) -> bool:
    """Whether the goal is to be reached, not only wanted."""
    return bool(scenario.value_of("weights", "terminal_goal")) and (
        "terminal_goal" not in scenario.bounds.without
    )


def find_missed(
    scenario: Scenario, terms: Sequence[Term], kernels: bool, progress: Progress | None, budget: Budget
) -> Finding:
    """The smallest set of constraints that stand in the way of the scenario, or of its goal.

    When the budget is spent, it is the set that was found until then.
    """
    search = _Search(scenario, terms, kernels, progress, budget)
    if search.contradictions:
        return Finding(search.problem, search.contradictions)
    search.solve(search.prices(PRICE_OF_GOAL), "with the goal almost free")
    if not search.totals(without_goal=True):
        goal_misses = search.goal_misses()
        if not goal_misses:
            return Finding(search.problem, (), search.motion(), search.motion())
        kept = search.motion()
        # the goal is out of reach: now it is demanded
        search.solve(search.prices(HIGH_PRICE), "with the goal demanded")
        search.narrow(HIGH_PRICE)
        return Finding(search.problem, search.missed(), search.motion(), kept, goal_misses)
    search.narrow(PRICE_OF_GOAL)
    return Finding(search.problem, search.missed(without_goal=True), search.motion())


class _Search:
    """The elastic problem and its latest solution."""

    def __init__(
        self,
        scenario: Scenario,
        terms: Sequence[Term],
        kernels: bool,
        progress: Progress | None,
        budget: Budget,
    ) -> None:
        self.problem = make_problem(scenario, terms)
        self._progress, self._budget = progress, budget
        promised = is_goal_promised(scenario)
        softer = {
            f"weights.{name}": SOFT_GOAL
            for name in ("goal", "terminal_goal")
            if scenario.value_of("weights", name)
        }
        goal: list[Term] = []
        if promised:
            goal = [GoalPlace(0.5 * tol.GOAL_DISTANCE), GoalYaw(0.5 * np.radians(tol.GOAL_YAW))]
        soft = make_problem(scenario.with_values(softer), [*terms, *goal])
        self._roles = {term.name: term.role for term in soft.constraints}
        self._transcribed = transcribe("condensed", soft, store_for(kernels))
        nlp = self._transcribed.nlp
        contradictions = [
            Missed(origin, excess * origin.label.scale) for origin, excess in nlp.contradictions
        ]
        soft_ones = [item for item in contradictions if self._role(item.origin) is not Role.PHYSICS]
        self.contradictions = tuple(soft_ones or contradictions)  # the others only follow from these
        if self.contradictions:
            return
        self._elastic = ElasticNlp(nlp, self._usual_miss, COST_FACTOR)
        self._solver = Ipopt(self._elastic, OPTIONS)
        self._x = self._elastic.start(self._transcribed.encode(kinematic_guess(soft)))

    def _role(self, origin: RowOrigin) -> Role:
        """What a row is to the motion; those of the transcription itself are physics."""
        return self._roles.get(origin.label.term, Role.PHYSICS)

    def prices(self, of_goal: float, alone: str | None = None) -> Callable[[RowOrigin], float]:
        """Prices of constraints; all but one term are dear if that is named."""

        def price(origin: RowOrigin) -> float:
            role = self._role(origin)
            if role is Role.GOAL:
                return of_goal
            own = PRICE_OF_END if role is Role.END else 1.0
            return own * (1.0 if alone in (None, origin.label.term) else HIGH_PRICE)

        return price

    def _usual_miss(self, origin: RowOrigin) -> float | None:
        label = origin.label
        if self._role(origin) is Role.PHYSICS:
            return None
        if label.unit == "N":
            return USUAL_MISS_FORCE * self.problem.robot.weight / label.scale
        return USUAL_MISS.get(label.unit, USUAL_MISS_OTHER) / label.scale

    def solve(self, price: Callable[[RowOrigin], float], how: str) -> None:
        """Solves with other prices, from the latest solution, as far as the budget goes."""
        if self._budget.is_spent():
            return
        self._elastic.prices = np.array([price(origin) for origin in self._elastic.slack_origins])
        report = self._budget.counting(f"{LOOKING} {how}", self._progress)
        self._x = self._solver.solve(self._x, report, **self._budget.limits).w

    @property
    def _slacks(self) -> list[tuple[RowOrigin, float, float]]:
        """Origin, slack in usual misses and in the unit of the constraint, of those that matter."""
        slack = self._elastic.split(self._x)[1]
        return [
            (origin, float(value), float(value * usual * origin.label.scale))
            for origin, value, usual in zip(
                self._elastic.slack_origins, slack, self._elastic.usual, strict=True
            )
            if value > NEGLIGIBLE
        ]

    def totals(self, without_goal: bool = False) -> dict[str, float]:
        """Sum of the slacks of each term, the largest first."""
        result: dict[str, float] = {}
        for origin, value, _ in self._slacks:
            if not (without_goal and self._role(origin) is Role.GOAL):
                result[origin.label.term] = result.get(origin.label.term, 0.0) + value
        return dict(sorted(result.items(), key=lambda item: -item[1]))

    def goal_misses(self) -> dict[tuple[str, int], float]:
        """By how much x, y (component 0, 1 of the place) and yaw miss their tolerance."""
        return {
            (o.label.term, o.label.component): e for o, _, e in self._slacks if self._role(o) is Role.GOAL
        }

    def narrow(self, price_of_goal: float) -> None:
        """Looks for fewer terms: whether one alone, the others being dear, is reason enough."""
        totals = self.totals(without_goal=True)
        if len(totals) <= 1:
            return
        before = self._x
        best, fewest = before, len(totals)
        for alone in list(totals)[:TRIED_ALONE]:
            self._x = before
            self.solve(self.prices(price_of_goal, alone), f"in {alone} alone")
            if self._budget.is_spent():
                break
            count = len(self.totals(without_goal=True))
            if 0 < count < fewest:
                best, fewest = self._x, count
            if fewest == 1:
                break
        self._x = best

    def missed(self, without_goal: bool = False) -> tuple[Missed, ...]:
        """The constraints that are missed."""
        kept = (x for x in self._slacks if not (without_goal and self._role(x[0]) is Role.GOAL))
        return tuple(Missed(origin, excess) for origin, _, excess in kept)

    def motion(self) -> Trajectory:
        """The motion of the latest solution."""
        return self._transcribed.decode(self._elastic.split(self._x)[0])
