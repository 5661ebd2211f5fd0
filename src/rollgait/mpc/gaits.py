"""Cyclic gaits of the controller, as data. A new gait is one line in `GAITS`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from rollgait.errors import UnknownNameError


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
    wheels: Literal["rolling", "locked"] = "rolling"
    brakes: bool = False
    clearance: float = 0.08
    centred: float = 0.0
    speed_max: float = 1.0
    turn_rate_max: float = 1.0


CENTRED: Final = 0.5
"""A robot that carries its weight in front falls over a front foot in the air unless it leans back."""
_ONE_BY_ONE: Final = (0.75, 0.25, 0.5, 0.0)
"""HR, FR, HL, FL: the paper's order."""

GAITS: Final = {
    gait.name: gait
    for gait in (
        CyclicGait("stand", brakes=True),
        CyclicGait("drive"),
        CyclicGait("crawl", period=4.0, swing=0.8, phase=_ONE_BY_ONE, centred=CENTRED),
        CyclicGait(
            "walk",
            period=5.0,
            swing=0.7,
            phase=_ONE_BY_ONE,
            wheels="locked",
            centred=CENTRED,
            speed_max=0.04,
            turn_rate_max=0.05,
        ),
        CyclicGait(
            "trot", period=1.0, swing=0.3, phase=(0.0, 0.5, 0.5, 0.0), clearance=0.05, centred=CENTRED
        ),
    )
}


def find_gait(name: str) -> CyclicGait:
    """The gait of a name. Raises `UnknownNameError`."""
    if name not in GAITS:
        raise UnknownNameError("gait", name, list(GAITS))
    return GAITS[name]
