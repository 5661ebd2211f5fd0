"""Is the robot of the plan the one that was asked for? All other checks take its figures from the plan."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.certificate.rows import Row, measured

if TYPE_CHECKING:
    from rollgait.plan.certificate.case import Case


def check_robot(case: Case) -> Iterator[Row]:
    """Every figure of the plan's robot against that of the robot asked for, with what it carries."""
    own, asked = (dict(_figures(robot.model_dump())) for robot in (case.robot, case.scenario.body))
    other = sorted(name for name in own.keys() | asked.keys() if not _same(own.get(name), asked.get(name)))
    named = f" ({other[0]}{', …' if len(other) > 1 else ''})" if other else ""
    yield from measured(
        "robot",
        f"figures of the plan's robot that are not those of the robot asked for{named}",
        "",
        np.array([float(len(other))]),
        0.0,
        np.zeros(1),
    )


def _figures(data: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """The leaves of nested data by their dotted names."""
    if isinstance(data, dict | list | tuple):
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield from _figures(value, f"{name}.{key}" if name else str(key))
    else:
        yield name, data


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, float | int) and isinstance(other, float | int):
        return bool(np.isclose(one, other, rtol=tol.FIGURE, atol=tol.FIGURE))
    return bool(one == other)
