"""Gaits: which foot is on the ground when. A new gait is one class like those here and its name in `Gait`.

A gait says in continuous time when each foot lifts off and touches down; `schedule.py` puts that on the mesh.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import AfterValidator, Discriminator, Field, model_validator

from rollgait.config import Config, NonNegative, Number, Positive, Whole
from rollgait.robot.robot import LEG_NAMES, LegName

Swing = tuple[Number, Number]
"""(lift-off, touch-down), s."""
Swings = dict[LegName, tuple[Swing, ...]]


class BaseGait(Config):
    """What all gaits share."""

    wheels: Literal["rolling", "locked"] = "rolling"
    """`locked`: the feet stand still on the ground, as point feet do (the paper's legged mode)."""
    clearance: Positive = 0.08
    """z_fly: height of the foot above the ground in the middle of its swing, m."""

    def swings(self, horizon: float) -> Swings:
        """Lift-off and touch-down times of each leg within `horizon` (s); ValueError if it does not fit."""
        raise NotImplementedError


class Drive(BaseGait):
    """All feet stay on the ground."""

    kind: Literal["drive"] = "drive"
    """Kind of the gait."""

    def swings(self, horizon: float) -> Swings:
        return dict.fromkeys(LEG_NAMES, ())


class Crawl(BaseGait):
    """One foot at a time, in equal slots of which the middle part is swing."""

    kind: Literal["crawl"] = "crawl"
    """Kind of the gait."""
    steps: Annotated[Whole, Field(ge=1, le=1000)] = 8
    """Number of steps of all feet together."""
    order: tuple[LegName, ...] = ("HR", "FR", "HL", "FL")
    """Order in which the feet step, repeated as often as needed."""
    swing_fraction: Annotated[Number, Field(gt=0.0, le=1.0)] = 0.8
    """Part of a slot in which the foot is in the air, in its middle."""
    pause_start: NonNegative = 1.0
    """Time at the beginning with all feet on the ground, s."""
    pause_end: NonNegative = 1.0
    """Time at the end with all feet on the ground, s."""

    def swings(self, horizon: float) -> Swings:
        slot = (horizon - self.pause_start - self.pause_end) / self.steps
        if slot <= 0.0:
            raise ValueError(
                f"needs a horizon longer than its two pauses ({self.pause_start} s + {self.pause_end} s), "
                f"not {horizon} s"
            )
        rest = 0.5 * slot * (1.0 - self.swing_fraction)
        result: dict[LegName, tuple[Swing, ...]] = dict.fromkeys(LEG_NAMES, ())
        for step in range(self.steps):
            begin = self.pause_start + step * slot
            leg = self.order[step % len(self.order)]
            result[leg] = (*result[leg], (begin + rest, begin + slot - rest))
        return result

    @model_validator(mode="after")
    def _has_an_order(self) -> Crawl:
        if not self.order:
            raise ValueError("must name at least one leg in order")
        return self


def _checked_swings(value: tuple[Swing, ...]) -> tuple[Swing, ...]:
    for begin, end in value:
        if not 0.0 <= begin < end:
            raise ValueError(f"must lift off at a time ≥ 0 and before it touches down, not [{begin}, {end}]")
    for (_, end), (begin, _) in pairwise(value):
        if begin < end:
            raise ValueError(
                f"must name swings in order and apart: one ends at {end} s, the next begins at {begin} s"
            )
    return value


class Schedule(BaseGait):
    """Any contact schedule, spelled out: for each leg the lift-off and touch-down times."""

    kind: Literal["schedule"] = "schedule"
    """Kind of the gait."""
    FL: Annotated[tuple[Swing, ...], AfterValidator(_checked_swings)] = ()
    """Swings of the front left foot, [[lift-off, touch-down], …], s."""
    FR: Annotated[tuple[Swing, ...], AfterValidator(_checked_swings)] = ()
    """Swings of the front right foot, s."""
    HL: Annotated[tuple[Swing, ...], AfterValidator(_checked_swings)] = ()
    """Swings of the hind left foot, s."""
    HR: Annotated[tuple[Swing, ...], AfterValidator(_checked_swings)] = ()
    """Swings of the hind right foot, s."""

    def swings(self, horizon: float) -> Swings:
        return {"FL": self.FL, "FR": self.FR, "HL": self.HL, "HR": self.HR}


Gait = Annotated[Drive | Crawl | Schedule, Discriminator("kind")]
"""One of the gaits, told apart by `kind`."""

GAIT_KINDS = ("drive", "crawl", "schedule")
