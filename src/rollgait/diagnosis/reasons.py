"""What is missed, said in words: foot, time span, constraint, by how much."""

from __future__ import annotations

from collections.abc import Sequence

from rollgait.diagnosis.elastic import Missed
from rollgait.diagnosis.report import Reason
from rollgait.ocp.goal import GoalPlace, GoalYaw
from rollgait.ocp.problem import Problem
from rollgait.ocp.term import Place, SelfDescribing
from rollgait.robot.robot import LEG_NAMES

FAINT = 0.02
"""Part of a reason's worst miss below which its time span does not count it."""


def reasons_of(problem: Problem, missed: Sequence[Missed]) -> tuple[Reason, ...]:
    """One reason for each term and leg; terms in the order of the most legs and the longest time."""
    groups: dict[tuple[str, int | None], list[Missed]] = {}
    for item in missed:
        groups.setdefault((item.origin.label.term, item.origin.label.leg), []).append(item)
    rows: dict[str, int] = {}
    for (term, _), items in groups.items():
        rows[term] = rows.get(term, 0) + len(items)
    result = [_reason(problem, items) for items in groups.values()]
    return tuple(sorted(result, key=lambda r: (-rows[r.term], r.term, r.leg or "")))


def _reason(problem: Problem, items: Sequence[Missed]) -> Reason:
    worst = max(items, key=lambda item: item.excess)
    label = worst.origin.label
    excess, unit = worst.excess, label.unit
    if label.term == "acceleration":  # a row is the change of speed from one interval to the next
        excess, unit = excess / float(problem.schedule.mesh.between_middles[worst.origin.interval]), "m/s²"
    spans = [_span(problem, item) for item in items if item.excess > FAINT * worst.excess]
    return Reason(
        term=label.term,
        description=_sentence(problem, label.term),
        leg=None if label.leg is None else LEG_NAMES[label.leg],
        begin=min(begin for begin, _ in spans),
        end=max(end for _, end in spans),
        excess=excess,
        unit=unit,
    )


def _sentence(problem: Problem, name: str) -> str:
    """What a constraint of this name says of itself; the goal's are none of the scenario's own problem."""
    for term in (*problem.constraints, GoalPlace(0.0), GoalYaw(0.0)):
        if term.name == name:
            return term.sentence
    return SelfDescribing.sentence


def _span(problem: Problem, item: Missed) -> tuple[float, float]:
    """When a row holds: in all its interval, or at one of its ends, s."""
    k, place, nodes = item.origin.interval, item.origin.label.place, problem.schedule.node_times
    if place == Place.TERMINAL.name:
        return problem.schedule.horizon, problem.schedule.horizon
    return round(float(nodes[k]), 9), round(float(nodes[k + 1]), 9)
