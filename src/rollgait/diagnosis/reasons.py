"""What is missed, said in words: foot, time span, constraint, by how much."""

from __future__ import annotations

from collections.abc import Sequence

from rollgait.diagnosis.elastic import Missed
from rollgait.diagnosis.report import Reason
from rollgait.ocp.problem import Problem
from rollgait.ocp.term import Place
from rollgait.robot.robot import LEG_NAMES

DESCRIPTIONS = {
    "acceleration": "the foot would have to change its speed faster",
    "box": "the foot would have to leave its box",
    "force_limits": "the normal force would have to leave its limits",
    "friction": "the contact force would have to leave the friction cone",
    "goal_distance": "the goal would not be reached",
    "goal_yaw": "the goal would not be reached",
    "height_at_end": "the body would not end at its nominal height",
    "joint_steering": "hip_yaw or the steering joint would have to leave its range",
    "level_at_end": "the base would not end level and at rest",
    "reach": "the leg would have to be stretched or folded further",
    "rest_at_end": "the body would not end at rest",
    "stance_at_end": "the foot would not end at its nominal place",
    "stance_speed": "the wheel would have to roll faster",
    "steering": "the wheel would have to steer further",
    "steering_rate": "the wheel would have to steer faster",
    "swing_speed": "the foot would have to swing faster",
    "touchdown_speed": "the foot would have to be set down faster",
    "wheels_rest_at_end": "the wheel would not end at rest",
}
"""What would have to happen, by term."""
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
    if label.term == "acceleration":  # a row is the change of speed in an interval
        excess, unit = excess / problem.schedule.interval, "m/s²"
    spans = [_span(problem, item) for item in items if item.excess > FAINT * worst.excess]
    return Reason(
        term=label.term,
        description=DESCRIPTIONS.get(label.term, "the constraint would have to be missed"),
        leg=None if label.leg is None else LEG_NAMES[label.leg],
        begin=min(begin for begin, _ in spans),
        end=max(end for _, end in spans),
        excess=excess,
        unit=unit,
    )


def _span(problem: Problem, item: Missed) -> tuple[float, float]:
    """When a row holds: in all its interval, or at one of its ends, s."""
    h, k, place = problem.schedule.interval, item.origin.interval, item.origin.label.place
    if place == Place.TERMINAL.name:
        return problem.schedule.horizon, problem.schedule.horizon
    return round(k * h, 9), round((k + 1) * h, 9)
