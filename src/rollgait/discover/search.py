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
from rollgait.discover.proposers import PROPOSERS
from rollgait.discover.reserves import driving
from rollgait.errors import InputError, NotSolvedError, shortened
from rollgait.footing.pace import poses_of
from rollgait.plan.plan import CandidateResult, Plan
from rollgait.scenario.gait import Discover
from rollgait.scenario.scenario import Scenario

ITERATIONS: Final = 80
"""Of the solver for each solve of a candidate: who needs more mostly gets nowhere."""
MENDINGS: Final = 3
"""Looks of the judge at a candidate: one that is not mended at once is worse than the next."""
DIGITS: Final = 4
"""Of places, m."""
OUTCOME: Final = 200
"""Longest outcome that is kept, characters."""


class PlanOne(Protocol):
    """Plans a scenario whose gait is given; raises `NotSolvedError`."""

    def __call__(self, scenario: Scenario, task: str, until: float) -> Plan:
        """The plan. Iterations are told as those of a task; the solver stops at a time (s) of the clock."""


def discover(scenario: Scenario, plan_one: PlanOne) -> Plan:
    """The plan of the first gait that is certified.

    Args:
        scenario: with the gait `discover`.
        plan_one: plans one candidate.

    Raises:
        InputError: nobody knows gaits for its feet.
        NotSolvedError: there is no way, or no candidate is certified; says where and why.
    """
    gait = scenario.gait
    assert isinstance(gait, Discover), "only gaits that are to be found are searched for"
    until = time.perf_counter() + gait.search.seconds
    base = driving(scenario, gait)
    most = gait.search.candidates
    results: list[CandidateResult] = []
    nearest: Plan | None = None
    is_cut = False
    for number, candidate in enumerate(islice(proposed(base), most), 1):
        if results and time.perf_counter() >= until:
            is_cut = True
            break
        try:
            asked = candidate.of(base)
        except InputError as error:  # e.g. a swing that is too short for the intervals
            results.append(CandidateResult(candidate.name, candidate.score, 0.0, 0, _line(str(error))))
            continue
        task = f"gait {number} of at most {most}, {candidate.name}"
        plan: Plan | None
        try:
            plan = plan_one(asked, task, until if results else math.inf)
            outcome = outcome_of(plan)
        except NotSolvedError as error:
            plan, outcome = error.plan, str(error)
        results.append(_result(candidate, asked, plan, outcome))
        if plan is not None and plan.solved and plan.certificate().passed:
            return plan.with_statistics(replace(plan.statistics, discovery=tuple(results)))
        if plan is not None and (nearest is None or plan.solved > nearest.solved):
            nearest = plan
    if nearest is not None:
        nearest = nearest.with_statistics(replace(nearest.statistics, discovery=tuple(results)))
    raise NotSolvedError(_nothing(results, gait, is_cut), nearest)


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
