"""Marks: the moments of a motion that are worth a look, from what judges it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from rollgait.plan.certificate.rows import nearness
from rollgait.plan.plan import Plan
from rollgait.simulation.log import SimulationLog
from rollgait.tracking import JointTrajectory

MOST: Final = 6
"""Marks on a timeline that a person can still tell apart."""


@dataclass(frozen=True)
class Mark:
    """A moment.

    Attributes:
        time: s.
        title: what is measured there.
        where: leg or joint, "" if none.
        value: what was measured, with its limit and unit.
        failed: whether it breaks its limit.
        severity: how near to its limit it is: 1 is at it.
    """

    time: float
    title: str
    where: str
    value: str
    failed: bool
    severity: float

    @property
    def label(self) -> str:
        """One line."""
        place = f" {self.where}" if self.where else ""
        return f"{self.title}{place}, {self.time:.2f} s"


def marks_of_plan(plan: Plan) -> tuple[Mark, ...]:
    """The rows of the certificate that come nearest to their limits or break them."""
    return _worst(
        Mark(
            row.time,
            row.name,
            row.leg or "",
            measure(row.worst, row.limit, row.unit, row.sense == "at least"),
            row.verdict == "fail",
            row.nearness,
        )
        for row in plan.certificate().rows
        if row.time is not None and row.verdict != "not promised" and row.limit is not None
    )


def marks_of_joints(joints: JointTrajectory) -> tuple[Mark, ...]:
    """The rows of the tracking report, likewise; a torque's limit is its 100 %."""
    return _worst(
        Mark(
            row.time,
            row.name,
            row.where,
            measure(row.worst, row.limit, row.unit, row.at_least),
            row.limit is not None and not row.passed,
            nearness(row.worst, 100.0 if row.limit is None else row.limit, row.at_least),
        )
        for row in joints.report.rows
        if row.limit is not None or row.unit == "%"
    )


def marks_of_log(log: SimulationLog) -> tuple[Mark, ...]:
    """The fall, and the joints that used the most of their torque."""
    report = log.report()
    marks = [
        Mark(
            use.time, "torque", use.joint, f"{use.torque:.3g} N m, {100 * use.share:.0f} %", False, use.share
        )
        for use in report.joints
    ]
    if report.fallen_at is not None:
        marks.append(Mark(report.fallen_at, "fall", "", "the robot fell", True, math.inf))
    return _worst(marks)


def measure(worst: float, limit: float | None, unit: str, at_least: bool) -> str:
    """A value and its limit, for a person."""
    text = f"{worst:.3g}"
    if limit is not None:
        text += f" {'≥' if at_least else '≤'} {limit:.3g}"
    return f"{text} {unit}".rstrip()


def _worst(marks: Iterable[Mark]) -> tuple[Mark, ...]:
    ranked = sorted(marks, key=lambda mark: (mark.failed, mark.severity), reverse=True)
    return tuple(ranked[:MOST])
