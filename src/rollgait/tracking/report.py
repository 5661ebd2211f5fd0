"""How well the joints follow a plan: rows of plain data."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.config import Line
from rollgait.robot.robot import LEG_NAMES

if TYPE_CHECKING:
    from rollgait.tracking.clearance import Nearest

Array = NDArray[np.float64]

LENGTH_TOLERANCE: Final = 1e-3
"""Farthest that a foot or the CoM may be from its place, m."""

ANGLE_TOLERANCE: Final = np.radians(0.5)
"""Farthest that a heading or the base may be from its angle, rad."""

CLEARANCE_MIN: Final = 0.01
"""Smallest distance of body and ground, and of one leg and another, m: shapes are looked at no finer."""

TORQUE_TIME_MAX: Final = 0.05
"""So long a drive gives its largest torque, s: a foot that strikes the ground asks for no more."""

LIMIT_TOLERANCE: Final = 1e-6
"""By how much rounding may exceed a joint's limit, rad or rad/s."""


@dataclass(frozen=True)
class TrackingRow:
    """One thing that was measured.

    Attributes:
        name: short name.
        worst: the worst value found, in `unit`.
        limit: what it is compared with; None if it is only shown.
        unit: of both.
        where: leg or joint; "" where there is none.
        time: when, s.
        at_least: whether `worst` must not be smaller than `limit`, or not larger.
    """

    name: Line
    worst: float
    limit: float | None
    unit: Line
    where: Line
    time: float
    at_least: bool = False

    @property
    def passed(self) -> bool:
        """Whether the value is on the right side of its limit; true where there is none."""
        if self.limit is None:
            return True
        return bool(self.worst >= self.limit if self.at_least else self.worst <= self.limit)


@dataclass(frozen=True)
class TrackingReport:
    """What was measured of a joint trajectory, and whether it follows its plan.

    Attributes:
        rows: what was measured.
        steps: number of steps.
        bounded_steps: steps in which a joint's limit shaped the motion.
        failed_steps: steps in which a level found no answer and fell back to the levels above it.
        step_time: mean time to compute a step, s.
        step_time_max: longest, s.
        wrench_mismatch: root mean square of what the planned forces lack to move the whole body, N: the
            planner's robot is a single rigid body, whose legs weigh nothing on their own.
    """

    rows: tuple[TrackingRow, ...]
    steps: int
    bounded_steps: int
    failed_steps: int
    step_time: float
    step_time_max: float
    wrench_mismatch: float

    @property
    def passed(self) -> bool:
        """Whether every row passes and no step failed."""
        return self.failed_steps == 0 and all(row.passed for row in self.rows)

    def row(self, name: str) -> TrackingRow:
        """The row of this name. Raises KeyError."""
        return next(row for row in self.rows if row.name == name)

    def to_dict(self) -> dict[str, Any]:
        """Plain data, e.g. for JSON."""
        rows = [asdict(row) | {"passed": row.passed} for row in self.rows]
        return asdict(self) | {"rows": rows, "passed": self.passed}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> TrackingReport:
        """The inverse of `to_dict`."""
        rows = tuple(TrackingRow(**{k: v for k, v in row.items() if k != "passed"}) for row in data["rows"])
        return cls(**{k: v for k, v in data.items() if k not in ("rows", "passed")} | {"rows": rows})


def leg_rows(time: Array, foot: Array, heading: Array) -> Iterator[TrackingRow]:
    """Rows of the feet: distances (n, 4), m, and headings (n, 4), rad."""
    yield _largest("foot", foot, LENGTH_TOLERANCE, "m", LEG_NAMES, time)
    yield _largest("heading", heading, ANGLE_TOLERANCE, "rad", LEG_NAMES, time)


def body_rows(time: Array, com: Array, base: Array, camber: Array) -> Iterator[TrackingRow]:
    """Rows of the body: distance of the CoM (n,), m; angle of the base (n,) and cambers (n, 4), rad."""
    yield _largest("com", com[:, None], LENGTH_TOLERANCE, "m", ("",), time)
    yield _largest("base", base[:, None], ANGLE_TOLERANCE, "rad", ("",), time)
    yield _largest("camber", camber, None, "rad", LEG_NAMES, time)


def joint_rows(
    time: Array,
    names: tuple[str, ...],
    position_margin: Array,
    speed: Array,
    speed_max: Array,
    torque_use: Array,
) -> Iterator[TrackingRow]:
    """Rows of the joints.

    Args:
        time: (n,), s.
        names: of the joints, n_j.
        position_margin: distance from the nearer limit, (n, n_j), rad.
        speed: |q̇| of the steps, (n − 1, n_j), rad/s.
        speed_max: (n_j,), rad/s.
        torque_use: |τ| as a share of the limit, (n, n_j).
    """
    yield _smallest("position margin", position_margin, -LIMIT_TOLERANCE, "rad", names, time)
    yield _smallest("speed margin", speed_max - speed, -LIMIT_TOLERANCE, "rad/s", names, time)
    yield _largest("torque use", 100.0 * torque_use, None, "%", names, time)
    yield _largest("torque at limit", _time_at_limit(time, torque_use), TORQUE_TIME_MAX, "s", names, time)


def clearance_rows(ground: Nearest | None, legs: Nearest | None) -> Iterator[TrackingRow]:
    """Rows of the nearest approaches of body and ground and of two legs, as far as they are known."""
    for name, found in (("ground clearance", ground), ("leg clearance", legs)):
        if found is not None:
            yield TrackingRow(name, found.distance, CLEARANCE_MIN, "m", found.where, found.time, True)


def _time_at_limit(time: Array, use: Array) -> Array:
    """For how long (s) each joint's torque has been at its limit or beyond, without a break, (n, n_j)."""
    step = np.gradient(time)
    held = np.zeros_like(use)
    before = np.zeros(use.shape[1])
    for k, is_at_limit in enumerate(use >= 1.0):
        before = np.where(is_at_limit, before + step[k], 0.0)
        held[k] = before
    return np.asarray(held.round(9))  # sums of steps carry round-off, and the limit is a whole number of them


def _largest(
    name: str, values: Array, limit: float | None, unit: str, where: tuple[str, ...], time: Array
) -> TrackingRow:
    row, column = np.unravel_index(np.argmax(values), values.shape)
    return TrackingRow(name, float(values[row, column]), limit, unit, where[column], float(time[row]))


def _smallest(
    name: str, values: Array, limit: float | None, unit: str, where: tuple[str, ...], time: Array
) -> TrackingRow:
    row, column = np.unravel_index(np.argmin(values), values.shape)
    return TrackingRow(name, float(values[row, column]), limit, unit, where[column], float(time[row]), True)
