"""A data set of small plans, and what tests ask of it."""

from __future__ import annotations

from typing import Any, Final

BASE: Final[dict[str, Any]] = {
    "robot": "centauro",
    "goal": {"x": 0.1},
    "horizon": 1.6,
    "interval": 0.2,
    "gait": "drive",
}
"""Planned in a blink."""


def spec(count: int = 6, **changes: Any) -> dict[str, Any]:
    """Goals nearby in one family; in the other every second row is refused, as its goal is out of reach."""
    data: dict[str, Any] = {
        "description": "small drives",
        "count": count,
        "seed": 5,
        "families": {
            "near": {"base": BASE, "share": 2, "vary": {"goal.x": {"uniform": [0.05, 0.15]}}},
            "mixed": {"base": BASE, "vary": {"goal.x": {"list": [0.1, 9.0]}}},
        },
        "vary": {"goal.y": {"normal": [0.0, 0.02], "within": [-0.03, 0.03]}},
    }
    return data | changes
