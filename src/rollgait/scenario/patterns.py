"""Which feet leave the ground together, and in which order: what gaits of planner and controller share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from rollgait.robot.robot import LEG_NAMES, LegName

Wheels = Literal["rolling", "locked"]


@dataclass(frozen=True)
class Pattern:
    """A cycle of steps, told by phases.

    Attributes:
        name: of the gait.
        phase: when FL, FR, HL, HR lift off, as shares of a cycle.
        wheels: `locked` wheels stand still on the ground.
    """

    name: str
    phase: tuple[float, float, float, float]
    wheels: Wheels = "rolling"

    @property
    def groups(self) -> tuple[tuple[LegName, ...], ...]:
        """The feet that swing together, in the order of their lift-offs."""
        return tuple(
            tuple(leg for leg, phase in zip(LEG_NAMES, self.phase, strict=True) if phase == at)
            for at in sorted(set(self.phase))
        )

    @property
    def order(self) -> tuple[LegName, ...]:
        """All legs in the order of their lift-offs."""
        return tuple(leg for group in self.groups for leg in group)


_ONE_BY_ONE: Final = (0.75, 0.25, 0.5, 0.0)
"""HR, FR, HL, FL: the paper's order."""

PATTERNS: Final = {
    pattern.name: pattern
    for pattern in (
        Pattern("crawl", _ONE_BY_ONE),
        Pattern("walk", _ONE_BY_ONE, wheels="locked"),
        Pattern("trot", (0.0, 0.5, 0.5, 0.0)),
        Pattern("pace", (0.0, 0.5, 0.0, 0.5)),
    )
}
"""By name: one foot at a time (rolling or with locked wheels), diagonal pairs, pairs of one side."""
