"""A small scenario with a step, for tests that plan it."""

from __future__ import annotations

from typing import Any

import rollgait as rg


def stepping(**values: Any) -> rg.Scenario:
    """A step of the hind left foot while driving a little, in 2 s; `values` are set instead."""
    data: dict[str, Any] = {
        "robot": "centauro-2020",
        "goal": {"x": 0.15, "y": 0.03, "yaw_deg": 5},
        "horizon": 2.0,
        "gait": {"kind": "schedule", "HL": [[0.5, 1.2]]},
    }
    return rg.Scenario.from_dict(data | values)
