"""A plan carried out by the whole robot in MuJoCo with feedback, and where it ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import rollgait as rg

DISTANCE_MAX, ANGLE_MAX = 10.0, 1.0
"""Farthest that a base may end from its plan, mm in the ground plane and degrees of the whole rotation."""


@dataclass(frozen=True)
class Execution:
    """How it went.

    Attributes:
        distance: of the base from its planned place in the ground plane at the end, mm.
        angle: of the base from its planned orientation there, degrees.
        fallen_at: when it fell, s; None if it did not.
        unplanned: how many links other than feet touched the ground.
        untracked: rows of the report on tracking that fail.
        refused: why it could not be carried out at all; "" if it could.
    """

    distance: float = 0.0
    angle: float = 0.0
    fallen_at: float | None = None
    unplanned: int = 0
    untracked: tuple[str, ...] = ()
    refused: str = ""

    @property
    def passed(self) -> bool:
        """Whether it stays on its feet and ends near enough to its plan."""
        near = self.distance <= DISTANCE_MAX and self.angle <= ANGLE_MAX
        return near and self.fallen_at is None and not self.refused

    def __str__(self) -> str:
        if self.refused:
            return self.refused
        if self.fallen_at is not None:
            return f"falls at {self.fallen_at:.1f} s"
        touched = f", {self.unplanned} unplanned contacts" if self.unplanned else ""
        failed = f", tracking: {', '.join(self.untracked)}" if self.untracked else ""
        return f"{self.distance:.1f} mm, {self.angle:.2f}°{touched}{failed}"


def executed(plan: rg.Plan) -> Execution:
    """Tracked by all joints, then simulated."""
    import rollgait as rg
    from rollgait.errors import RollgaitError

    try:
        joints = rg.track(plan)
        log = rg.simulate(joints, feedback=True)
    except RollgaitError as error:
        return Execution(refused=str(error))
    report = log.report()
    return Execution(
        1e3 * report.final_distance,
        float(np.degrees(report.final_angle)),
        report.fallen_at if report.fallen else None,
        len(report.unplanned),
        tuple(row.name for row in joints.report.rows if not row.passed),
    )
