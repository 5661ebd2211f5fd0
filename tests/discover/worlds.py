"""Scenarios whose gait is to be found."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rollgait.discover.candidate import Candidate
from rollgait.discover.reserves import driving
from rollgait.discover.search import proposed
from rollgait.scenario import Scenario
from rollgait.scenario.gait import Discover

Part = dict[str, Any]

STEP: Part = {"kind": "step", "x": 0.9, "height": 0.15}
OBLIQUE: Part = {"kind": "step", "x": 1.0, "height": 0.12, "yaw_deg": 20.0}
BLOCK: Part = {"kind": "block", "x": 1.1, "y": 0.6, "length": 0.4, "width": 1.8, "height": 0.12}
POTHOLE: Part = {"kind": "block", "x": 1.1, "y": 0.45, "length": 0.4, "width": 0.5, "height": -0.3}
PILLAR: Part = {"kind": "block", "x": 1.5, "length": 0.3, "width": 0.3, "height": 1.0}
WALL: Part = {"kind": "block", "x": 1.4, "length": 0.15, "width": 30.0, "height": 1.0}
PIT: Part = {"kind": "gap", "x": 1.0, "length": 0.9}


def world(parts: Sequence[Part] = (), goal: Part | None = None, **more: Any) -> Scenario:
    """A scenario of CENTAURO over some parts, 2.6 m straight on if no goal is given."""
    data: Part = {"robot": "centauro", "goal": goal or {"x": 2.6}, "gait": "discover"}
    if parts:
        data["ground"] = {"parts": list(parts)}
    return Scenario.from_dict({**data, **more})


def candidates(scenario: Scenario, most: int = 100) -> list[Candidate]:
    """What is proposed for it, the best first; nothing is solved."""
    gait = scenario.gait
    assert isinstance(gait, Discover)
    found = []
    for candidate in proposed(driving(scenario, gait)):
        found.append(candidate)
        if len(found) == most:
            break
    return found


def first(scenario: Scenario) -> Scenario:
    """The scenario with the gait that is tried first."""
    gait = scenario.gait
    assert isinstance(gait, Discover)
    return candidates(scenario, 1)[0].of(driving(scenario, gait))
