"""Cyclic gaits of the controller, as data. A new gait is one line in `GAITS`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from rollgait.errors import UnknownNameError
from rollgait.scenario.patterns import PATTERNS, Wheels


@dataclass(frozen=True)
class CyclicGait:
    """Which foot leaves the ground when, over and over.

    Attributes:
        name: of the gait.
        period: of a cycle, s; of no meaning if no foot swings.
        swing: how long a foot is in the air, s; 0 if none ever is.
        phase: when FL, FR, HL, HR lift off, as shares of the period.
        wheels: `locked` wheels stand still on the ground.
        brakes: velocities that are commanded count as zero.
        clearance: height of a foot in the middle of its swing, m.
        centred: share of the way by which the CoM moves over the middle of the feet.
        speed_max, turn_rate_max: what the gait can follow, m/s and rad/s.
    """

    name: str
    period: float = 1.0
    swing: float = 0.0
    phase: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    wheels: Wheels = "rolling"
    brakes: bool = False
    clearance: float = 0.08
    centred: float = 0.0
    speed_max: float = 1.0
    turn_rate_max: float = 1.0


CENTRED: Final = 0.5
"""A robot that carries its weight in front falls over a front foot in the air unless it leans back."""


def _stepping(name: str, period: float, swing: float, **rest: Any) -> CyclicGait:
    """A gait of the pattern of its name."""
    pattern = PATTERNS[name]
    return CyclicGait(name, period, swing, pattern.phase, pattern.wheels, centred=CENTRED, **rest)


GAITS: Final = {
    gait.name: gait
    for gait in (
        CyclicGait("stand", brakes=True),
        CyclicGait("drive"),
        _stepping("crawl", period=4.0, swing=0.8),
        _stepping("walk", period=5.0, swing=0.7, speed_max=0.04, turn_rate_max=0.05),
        _stepping("trot", period=1.0, swing=0.3, clearance=0.05),
        _stepping("pace", period=1.0, swing=0.2, clearance=0.05),
    )
}


def find_gait(name: str) -> CyclicGait:
    """The gait of a name. Raises `UnknownNameError`."""
    if name not in GAITS:
        raise UnknownNameError("gait", name, list(GAITS))
    return GAITS[name]
