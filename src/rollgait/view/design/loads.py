"""What a scenario's robot carries and what pulls at it, as values of the scenario: one more, one less."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Literal

from rollgait.robot.loads import Load, Wrench
from rollgait.scenario.scenario import Scenario

CARRIED: Final = 0.1
"""Mass of a new payload as a share of the robot's: every robot of the library carries that."""
PULLED: Final = 0.05
"""Force of a new pull as a share of the robot's weight: a cart's."""
ON_TOP: Final = 0.3
"""Of a new payload over the CoM, in heights of the CoM over the ground: on the back."""

Kind = Literal["payload", "wrench"]
KINDS: Final[tuple[Kind, ...]] = ("payload", "wrench")


@dataclass(frozen=True)
class Place:
    """One of the loads: which list of the scenario it is in, and where."""

    kind: Kind
    number: int

    @property
    def key(self) -> str:
        """Of it in the scenario, dotted."""
        return f"loads.{self.kind}.{self.number}"

    def of(self, scenario: Scenario) -> Load | Wrench | None:
        """What it is in a scenario; None where there is none of this number."""
        things = getattr(scenario.loads, self.kind)
        return things[self.number] if self.number < len(things) else None


def places(scenario: Scenario) -> list[Place]:
    """All loads: what is carried, then what pulls."""
    return [Place(kind, k) for kind in KINDS for k in range(len(getattr(scenario.loads, kind)))]


def with_load(scenario: Scenario, kind: Kind) -> dict[str, Any]:
    """A load more: a box on the back, or a cart that is pulled."""
    body = scenario.body.bare
    first: dict[Kind, dict[str, Any]] = {
        "payload": {"mass": _plain(CARRIED * body.mass), "at": [0.0, 0.0, _plain(ON_TOP * body.height)]},
        "wrench": {
            "force": [-_plain(PULLED * body.weight), 0.0, 0.0],
            "at": [_plain(float(body.stance[:, 0].min())), 0.0, 0.0],
            "frame": "base",
        },
    }
    return {f"loads.{kind}": [*_listed(scenario, kind), first[kind]]}


def without_load(scenario: Scenario, place: Place) -> dict[str, Any]:
    """A load less."""
    left = [load for k, load in enumerate(_listed(scenario, place.kind)) if k != place.number]
    return {f"loads.{place.kind}": left}


def _listed(scenario: Scenario, kind: Kind) -> list[dict[str, Any]]:
    return [load.model_dump(mode="json") for load in getattr(scenario.loads, kind)]


def _plain(value: float) -> float:
    """With two figures, as a person would write it."""
    return float(f"{value:.2g}")
