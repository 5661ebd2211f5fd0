"""Trying gaits until one is certified: proposed by geometry, planned in the order of their scores."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from heapq import merge
from itertools import chain, islice
from typing import Final, Protocol

from rollgait.discover.candidate import Candidate
from rollgait.discover.needless import needless_steps
from rollgait.discover.proposers import PROPOSERS
from rollgait.discover.reserves import driving
from rollgait.discover.steps import Steps, steps_of, steps_values
from rollgait.errors import InputError, NotSolvedError, shortened
from rollgait.footing.pace import poses_of
from rollgait.footing.skidding import turns_by_skidding
from rollgait.plan.plan import CandidateResult, Plan
from rollgait.scenario.gait import Discover
from rollgait.scenario.scenario import Scenario

ITERATIONS: Final = 80
"""Of the solver for each solve of a candidate: who needs more mostly gets nowhere."""
ITERATIONS_SKIDDING: Final = 200
"""The same of a candidate that skids: the law of friction takes 50 to 150, however good the guess is."""
MENDINGS: Final = 3
"""Looks of the judge at a candidate: one that is not mended at once is worse than the next."""
DIGITS: Final = 4
"""Of places, m."""
ITERATIONS_ON: Final = 40
"""The same where the solver begins from a motion that was found: with fewer steps it mostly takes 20."""
WORTH: Final = 0.1
"""Part of the steps that must look needless for them to be left out: each look is a plan."""
SAME: Final = 1e-3
"""Share of the cost by which a gait with fewer steps may be dearer: that much the solver leaves open."""
NOT_KEPT: Final = "certified, not kept"
"""Outcome of a gait whose steps, or the want of them, cost more than those of the one that was found."""
OUTCOME: Final = 200
"""Longest outcome that is kept, characters."""


def iterations(scenario: Scenario, is_changed: bool) -> int:
    """The most for each solve of a candidate; `is_changed` if it begins from a motion that was found."""
    if is_changed:
        return ITERATIONS_ON
    return ITERATIONS_SKIDDING if turns_by_skidding(scenario, scenario.schedule) else ITERATIONS


class PlanOne(Protocol):
    """Plans a scenario whose gait is given; raises `NotSolvedError`."""

    def __call__(self, scenario: Scenario, task: str, until: float, start: Plan | None = None) -> Plan:
        """The plan. Iterations are told as those of a task; the solver stops at a time (s) of the clock.

        `start` is a motion to begin from, where one is known.
        """


def discover(scenario: Scenario, plan_one: PlanOne) -> Plan:
    """The plan of the first gait that is certified, without steps that it does not need.

    Args:
        scenario: with the gait `discover`.
        plan_one: plans one candidate.

    Raises:
        InputError: nobody knows gaits for its feet.
        NotSolvedError: there is no way, or no candidate is certified; says where and why.
    """
    gait = scenario.gait
    assert isinstance(gait, Discover), "only gaits that are to be found are searched for"
    base = driving(scenario, gait)
    trying = _Trying(gait, plan_one)
    is_cut = False
    for candidate in islice(proposed(base), gait.search.candidates):
        if trying.results and trying.is_late:
            is_cut = True
            break
        if (found := trying.plan(candidate, base)) is not None:
            best = trying.leaner(found)
            return best.with_statistics(replace(best.statistics, discovery=tuple(trying.results)))
    nearest = trying.nearest
    if nearest is not None:
        nearest = nearest.with_statistics(replace(nearest.statistics, discovery=tuple(trying.results)))
    raise NotSolvedError(_nothing(trying.results, gait, is_cut), nearest)


class _Trying:
    """Gaits that are planned within the limits of a search.

    Attributes:
        results: what came of each; where a gait was found, of that one last.
        nearest: the best plan that is not certified.
    """

    def __init__(self, gait: Discover, plan_one: PlanOne) -> None:
        self.gait, self._plan_one = gait, plan_one
        self._until = time.perf_counter() + gait.search.seconds
        self.results: list[CandidateResult] = []
        self.nearest: Plan | None = None

    @property
    def is_late(self) -> bool:
        return time.perf_counter() >= self._until

    def plan(self, candidate: Candidate, base: Scenario, start: Plan | None = None) -> Plan | None:
        """The plan of a candidate; None if it is not certified."""
        try:
            asked = candidate.of(base)
        except InputError as error:  # e.g. a swing that is too short for the intervals
            result = CandidateResult(candidate.name, candidate.score, 0.0, 0, _line(str(error)))
            self.results.append(result)
            return None
        task = f"gait {len(self.results) + 1} of at most {self.gait.search.candidates}, {candidate.name}"
        until = self._until if self.results else math.inf
        plan: Plan | None
        try:
            plan = self._plan_one(asked, task, until, start)
            outcome = outcome_of(plan)
        except NotSolvedError as error:
            plan, outcome = error.plan, str(error)
        self.results.append(_result(candidate, asked, plan, outcome))
        if plan is not None and plan.solved and plan.certificate().passed:
            return plan
        if plan is not None and (self.nearest is None or plan.solved > self.nearest.solved):
            self.nearest = plan
        return None

    def leaner(self, found: Plan) -> Plan:
        """The plan without the steps that it does not need; what is found is certified and no dearer.

        All that look needless are left out at once, and where that does not do, the first half of them.
        """
        steps = needless_steps(found)
        if len(steps) < WORTH * len(steps_of(found.scenario)):
            return found
        without_all = self._without(found, steps)
        return without_all or self._without(found, steps[: len(steps) // 2]) or found

    def _without(self, found: Plan, steps: Steps) -> Plan | None:
        """A plan without some steps; None if it is not kept, or the search is at its end."""
        if not steps or self.is_late or len(self.results) == self.gait.search.candidates:
            return None
        here = len(self.results) - 1
        left = tuple(step for step in steps_of(found.scenario) if step not in steps)
        name = "without " + (str(steps[0]) if len(steps) == 1 else f"{len(steps)} steps")
        values = steps_values(found.scenario, left)
        plan = self.plan(Candidate(name, self.results[here].score, values), found.scenario, found)
        is_kept = plan is not None and plan.statistics.cost <= found.statistics.cost * (1.0 + SAME)
        if plan is not None:
            vain = here if is_kept else here + 1
            self.results[vain] = replace(self.results[vain], outcome=NOT_KEPT)
        if not is_kept:  # who was found stays the last
            self.results.append(self.results.pop(here))
        return plan if is_kept else None


def proposed(base: Scenario) -> Iterator[Candidate]:
    """All candidates for a scenario that drives, each once, the best first; made as they are asked for.

    Raises:
        InputError: nobody knows gaits for its feet.
        NotSolvedError: there is no way.
    """
    begun: list[Iterable[Candidate]] = []
    refusals: list[NotSolvedError] = []
    for proposer in PROPOSERS:
        candidates = iter(proposer(base))
        try:
            begun.append(chain([next(candidates)], candidates))
        except StopIteration:
            continue
        except NotSolvedError as error:
            refusals.append(error)
    if not begun and refusals:
        raise refusals[0]
    if not begun:
        kinds = ", ".join(dict.fromkeys(leg.foot for leg in base.body.leg_list))
        ground = "flat ground" if base.ground.kind == "flat" else "this ground"
        raise InputError("gait", "discover", f"finds no gaits for feet of the kind {kinds} on {ground}")
    known: set[str] = set()
    for candidate in merge(*begun, key=lambda candidate: candidate.score):
        if candidate.key not in known:
            known.add(candidate.key)
            yield candidate


def outcome_of(plan: Plan) -> str:
    """`certified`, or which rows of the certificate fail and where."""
    failures = plan.certificate().failures
    if not failures:
        return "certified"
    row = failures[0]
    where = f" of {row.leg}" if row.leg else ""
    when = "" if row.time is None else f" at t = {row.time:.2f} s"
    more = f", and {len(failures) - 1} more" if len(failures) > 1 else ""
    return f"not certified: {row.name}{where} {row.worst:.3g} {row.unit}{when}{more}"


def _result(candidate: Candidate, asked: Scenario, plan: Plan | None, outcome: str) -> CandidateResult:
    steps = sum(1 for _ in asked.schedule.swings())
    iterations = 0 if plan is None else plan.statistics.iterations
    poses = poses_of(asked)
    return CandidateResult(
        candidate.name,
        candidate.score,
        asked.horizon,
        steps,
        _line(outcome),
        iterations,
        way=tuple((round(float(x), DIGITS), round(float(y), DIGITS)) for x, y, _ in poses),
        footholds=() if plan is None or not plan.solved else _footholds(plan),
    )


def _line(text: str) -> str:
    return shortened("".join(c if c.isprintable() else " " for c in text), OUTCOME)


def _footholds(plan: Plan) -> tuple[tuple[float, float], ...]:
    """Where its feet land, (x, y), m, in the order of the landings."""
    swings = sorted(plan.schedule.swings(), key=lambda swing: swing.touch_down)
    if not swings:
        return ()
    at = plan.sample(plan.schedule.node_times[[swing.touch_down for swing in swings]])
    places = (at.foot_position[k, swing.leg] for k, swing in enumerate(swings))
    return tuple((round(float(x), DIGITS), round(float(y), DIGITS)) for x, y, _ in places)


def _nothing(results: Sequence[CandidateResult], gait: Discover, is_cut: bool) -> str:
    first = results[0]
    tried = f"{len(results)} gaits were tried" if len(results) > 1 else "one gait was tried"
    cut = f" until gait.search.seconds = {gait.search.seconds:g} were over" if is_cut else ""
    return f"no motion found: {tried}{cut}; the first one ({first.name}): {first.outcome}"
