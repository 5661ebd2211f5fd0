"""A robot on fixed wheels that may slip sideways, and turns on the spot."""

from __future__ import annotations

from typing import Any

import rollgait as rg

SLIP_MAX = 0.1
"""m/s."""


def robot(slip_max: float | None = SLIP_MAX) -> rg.Robot:
    """The rover; its wheels may slip so fast."""
    data = rg.find_robot("rover").model_dump()
    for leg in data["legs"].values():
        leg["slip_max"] = slip_max
    return rg.Robot.model_validate(data)


def turning(yaw_deg: float, slip_max: float | None = SLIP_MAX, **values: Any) -> rg.Scenario:
    """It turns on the spot; `values` are set instead."""
    data: dict[str, Any] = {
        "robot": robot(slip_max),
        "goal": {"x": 0.0, "yaw_deg": yaw_deg},
        "horizon": 3.0,
        "interval": 0.1,
        "gait": {"kind": "drive"},
    }
    return rg.Scenario.from_dict(data | values)
