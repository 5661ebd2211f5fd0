"""Goals and parts of the ground as values of a scenario: a new one, one less, a copy. Nothing here draws."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from rollgait.plan.samples import Array
from rollgait.scenario.scenario import Scenario
from rollgait.view.rotations import turn_z

FIRST: Final[dict[str, dict[str, Any]]] = {
    "ramp": {"length": 1.0, "rise": 0.1},
    "step": {"height": 0.1},
    "stairs": {"steps": 3, "rise": 0.1, "tread": 0.4},
    "gap": {"length": 0.2, "depth": 0.5},
    "block": {"length": 0.4, "width": 0.4, "height": 0.1},
}
"""A new part of each kind: what a robot of CENTAURO's size can take. m"""
AHEAD: Final = 0.45
"""From the front feet to a new part, m: no foot stands within 3 cm of its edge."""
APART: Final = 0.5
"""From a part to the next new one, from a goal to the next, m."""
SHOWN: Final = 3.0
"""Of a part without end, m."""
PLACES: Final = 3
"""Decimals of a place that was dragged: millimetres."""


def with_part(scenario: Scenario, kind: str) -> dict[str, Any]:
    """A part more: before the robot, and beyond the parts that are there."""
    begin = scenario.start
    forward = turn_z(np.radians(begin.yaw_deg))[:2, 0]
    at = float(scenario.body.stance[:, 0].max()) + AHEAD
    for part in scenario.ground.parts:
        low, high = extent(part)
        along = float(forward @ (np.array([part.x, part.y]) - [begin.x, begin.y]))
        at = max(at, along + (high if high < SHOWN else max(low, 0.0)) + APART)
    x, y = np.array([begin.x, begin.y]) + at * forward
    place = {"x": round(float(x), PLACES), "y": round(float(y), PLACES), "yaw_deg": begin.yaw_deg}
    return {"ground.parts": [*_parts(scenario), {"kind": kind, **place, **FIRST[kind]}]}


def with_copy_of_part(scenario: Scenario, number: int) -> dict[str, Any]:
    """A part once more, half a metre to its side."""
    parts = _parts(scenario)
    aside = turn_z(np.radians(parts[number]["yaw_deg"]))[:2, 1] * APART
    place = {
        key: round(parts[number][key] + float(shift), PLACES) for key, shift in zip("xy", aside, strict=True)
    }
    return {"ground.parts": [*parts, {**parts[number], **place}]}


def without_part(scenario: Scenario, number: int) -> dict[str, Any]:
    """A part less."""
    return {"ground.parts": [part for k, part in enumerate(_parts(scenario)) if k != number]}


def with_goal(scenario: Scenario) -> dict[str, Any]:
    """A goal more after the last one, half way through the time that is left."""
    later = _later(scenario)
    last: dict[str, Any] = later[-1] if later else {"at": 0.0, **pose_of(scenario.goal)}
    at = round(0.5 * (last["at"] + scenario.horizon), 2)
    ahead = turn_z(np.radians(last["yaw_deg"]))[:2, 0] * APART
    place = {key: round(last[key] + float(shift), PLACES) for key, shift in zip("xy", ahead, strict=True)}
    return {"goal.then": [*later, {"at": at, **place, "yaw_deg": last["yaw_deg"]}]}


def without_goal(scenario: Scenario, number: int) -> dict[str, Any]:
    """A goal less; the last one stays."""
    later = _later(scenario)
    if not later:
        return {}
    if number > 0:
        return {"goal.then": [goal for k, goal in enumerate(later) if k != number - 1]}
    first, *others = later
    return {**{f"goal.{key}": first[key] for key in ("x", "y", "yaw_deg")}, "goal.then": others}


def pose_of(place: Any) -> dict[str, float]:
    """x, y (m) and yaw (degrees) of a start, a goal or a part."""
    return {key: float(getattr(place, key)) for key in ("x", "y", "yaw_deg")}


def extent(part: Any) -> tuple[float, float]:
    """Where a part begins and ends on its axis, m."""
    pieces = list(part.pieces())
    return min(at for at, *_ in pieces), max(at + length for at, length, *_ in pieces)


def footprint(part: Any) -> Array:
    """Closed outline of a part in its own frame, (5, 2), m; of what has no end as much as is shown."""
    low, high = extent(part)
    high, half = min(high, low + SHOWN), 0.5 * min(part.across, SHOWN)
    return np.array([[low, -half], [high, -half], [high, half], [low, half], [low, -half]])


def _parts(scenario: Scenario) -> list[dict[str, Any]]:
    return [part.model_dump(mode="json") for part in scenario.ground.parts]


def _later(scenario: Scenario) -> list[dict[str, Any]]:
    return [goal.model_dump(mode="json") for goal in scenario.goal.then]
