"""Fewer steps, more steps, other orders, pairs: each planned, judged and put into one table.

Whether a foot should step is a question with two answers; a relaxation of it ends between them. So all
changes of a gait that are worth a look are enumerated, each planned from the best motion so far.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import islice
from typing import Any, Final, Literal, Protocol

from rollgait.discover.steps import (
    Steps,
    in_pairs,
    one_by_one,
    one_more,
    orders,
    steps_of,
    with_steps,
    without,
)
from rollgait.errors import InputError, NotSolvedError
from rollgait.plan.plan import Plan
from rollgait.plan.work import mechanical_work
from rollgait.scenario.scenario import Scenario

Change = Literal["fewer", "more", "pairs", "orders"]
CHANGES: Final = ("fewer", "pairs", "orders")
"""What is tried unless told: more steps never help where fewer are certified."""
CANDIDATES: Final = 40
"""How many gaits are planned at most: some 20 s."""
MARGIN_ROWS: Final[tuple[str, ...]] = ("com_margin", "capture_margin", "friction_margin")
"""Rows of the certificate that say how safe a gait is."""
BETTER: Final = 1e-3
"""Share of the cost that a change must save: less is the solver's tolerance."""


class Planning(Protocol):
    """Plans a scenario from an earlier plan. Raises `NotSolvedError`."""

    def __call__(self, scenario: Scenario, warm_start: Plan | None, /) -> Plan: ...


@dataclass(frozen=True)
class Tried:
    """A gait that was planned.

    Attributes:
        change: how it differs from the best one before, in words.
        steps: its steps.
        verdict: `certified`, `not certified` or `not solved`.
        reason: which row failed, or what the planner says; "" if it is certified.
        cost: J; None if it is not solved.
        horizon: T, s.
        work: mechanical work of wheels and legs, J.
        margins: of CoM, capture point and friction, by the name of their row in the certificate: what is left
            beyond the limit; only those that the scenario asks for.
        iterations: of the solver.
        seconds: wall time.
        plan: the plan, if it is solved.
    """

    change: str
    steps: Steps
    verdict: Literal["certified", "not certified", "not solved"]
    reason: str = ""
    cost: float | None = None
    horizon: float = 0.0
    work: float | None = None
    margins: dict[str, float] = field(default_factory=dict)
    iterations: int = 0
    seconds: float = 0.0
    plan: Plan | None = field(default=None, repr=False, compare=False)

    @property
    def certified(self) -> bool:
        """Whether its certificate passes."""
        return self.verdict == "certified"

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        values = {key: value for key, value in vars(self).items() if key != "plan"}
        return {**values, "steps": [asdict(step) for step in self.steps]}


@dataclass(frozen=True)
class StepSearch:
    """What a search found.

    Attributes:
        tried: all gaits, in the order in which they were planned; the first one is the given one.
        cut: whether there were more than should be planned.
    """

    tried: tuple[Tried, ...]
    cut: bool = False

    @property
    def best(self) -> Tried | None:
        """The cheapest certified one; None if there is none."""
        return min((t for t in self.tried if t.certified), key=lambda t: t.cost or 0.0, default=None)

    def cheapest_by_count(self) -> dict[int, Tried]:
        """The cheapest certified one of each number of swings, most first."""
        result: dict[int, Tried] = {}
        for tried in self.tried:
            count = sum(len(step.legs) for step in tried.steps)
            if tried.certified and (count not in result or _cost(tried) < _cost(result[count])):
                result[count] = tried
        return dict(sorted(result.items(), reverse=True))


def enumerate_steps(
    scenario: Scenario,
    plan: Planning,
    changes: Sequence[str] = CHANGES,
    candidates: int = CANDIDATES,
    tell: Callable[[Tried], None] = lambda tried: None,
) -> StepSearch:
    """Changes the steps of a scenario as long as that saves cost.

    `fewer`: each step is left out once; then they are left out together, in the order of what each has saved,
    and a step whose absence saves nothing more, or is not certified, stays. `more`: further steps in the
    longest pauses. `pairs`: diagonal pairs for single feet, and the reverse. `orders`: other feet at the same
    times.

    Args:
        scenario: what is asked, with a gait.
        plan: plans one.
        changes: what is tried, of `fewer`, `more`, `pairs`, `orders`, in this order.
        candidates: how many gaits are planned at most.
        tell: is told of each.

    Raises:
        InputError: there is no such change, or nothing may be planned.
    """
    for change in changes:
        if change not in _CHANGES:
            raise InputError("changes", change, f"must be one of {', '.join(_CHANGES)}")
    if candidates < 1:
        raise InputError("candidates", candidates, "must be at least 1")
    search = _Search(scenario, plan, candidates, tell)
    try:
        best = search.take("as given", steps_of(scenario))
        for change in changes:
            best = _CHANGES[change](search, best)
    except _CutError:
        return StepSearch(tuple(search.tried), cut=True)
    return StepSearch(tuple(search.tried))


class _CutError(Exception):
    """As many as allowed were planned."""


class _Search:
    def __init__(
        self, scenario: Scenario, plan: Planning, candidates: int, tell: Callable[[Tried], None]
    ) -> None:
        self.scenario, self._plan, self._candidates, self._tell = scenario, plan, candidates, tell
        self.tried: list[Tried] = []

    def take(self, change: str, steps: Steps, start: Tried | None = None) -> Tried:
        """Plans a gait, from another one's motion; one that was planned before is not planned again."""
        for known in self.tried:
            if known.steps == steps:
                return known
        if len(self.tried) == self._candidates:
            raise _CutError
        begin = time.perf_counter()
        found = self._planned(change, steps, None if start is None else start.plan)
        found = replace(found, seconds=time.perf_counter() - begin)
        self.tried.append(found)
        self._tell(found)
        return found

    def _planned(self, change: str, steps: Steps, warm_start: Plan | None) -> Tried:
        try:
            asked = self.scenario if not self.tried else with_steps(self.scenario, steps)
            plan = self._plan(asked, warm_start)
        except (NotSolvedError, InputError) as error:
            return Tried(change, steps, "not solved", str(error), horizon=self.scenario.horizon)
        certificate = plan.certificate()
        rows = {row.name: row for row in certificate.rows}
        here = [rows[name] for name in MARGIN_ROWS if name in rows]
        margins = {row.name: row.worst - (row.limit or 0.0) for row in here}
        failures = certificate.failures
        return Tried(
            change,
            steps,
            "not certified" if failures else "certified",
            ", ".join(row.name for row in failures),
            plan.statistics.cost,
            plan.horizon,
            mechanical_work(plan),
            margins,
            plan.statistics.iterations,
            plan=plan,
        )

    def cheaper(self, a: Tried, b: Tried) -> Tried:
        """The better one of two; the first one unless the second is certified and saves cost."""
        if not b.certified or (a.certified and _cost(b) > _cost(a) * (1.0 - BETTER)):
            return a
        return b

    def best_of(self, best: Tried, variants: Iterable[tuple[str, Steps]]) -> Tried:
        """Plans variants of the best one; the cheapest."""
        result = best
        for change, steps in variants:
            result = self.cheaper(result, self.take(change, steps, best))
        return result


def _cost(tried: Tried) -> float:
    return float("inf") if tried.cost is None else tried.cost


def _fewer(search: _Search, best: Tried) -> Tried:
    alone = [
        (search.take(f"without {step}", without(best.steps, k), best), step)
        for k, step in enumerate(best.steps)
    ]
    result = best
    for tried, _ in alone:
        result = search.cheaper(result, tried)
    for _, step in sorted(alone, key=lambda pair: (not pair[0].certified, _cost(pair[0]))):
        if result is not best and step in result.steps:
            fewer = without(result.steps, result.steps.index(step))
            result = search.cheaper(result, search.take(f"also without {step}", fewer, result))
    return result


def _more(search: _Search, best: Tried) -> Tried:
    result = best
    while more := one_more(result.steps, search.scenario.horizon):
        (added,) = set(more) - set(result.steps)
        tried = search.take(f"with {added}", more, result)
        if search.cheaper(result, tried) is result:
            return result
        result = tried
    return result


def _pairs(search: _Search, best: Tried) -> Tried:
    horizon = search.scenario.horizon
    ways = (("diagonal pairs", in_pairs(best.steps)), ("one by one", one_by_one(best.steps, horizon)))
    return search.best_of(best, ((change, steps) for change, steps in ways if steps))


def _orders(search: _Search, best: Tried) -> Tried:
    others = (("order " + " ".join("+".join(s.legs) for s in steps), steps) for steps in orders(best.steps))
    return search.best_of(best, islice(others, CANDIDATES))


_CHANGES: Final[dict[str, Callable[[_Search, Tried], Tried]]] = {
    "fewer": _fewer,
    "more": _more,
    "pairs": _pairs,
    "orders": _orders,
}
