"""What a run of the controller was like: arrays over time, and its report in numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from rollgait.archive import ArchiveFormat
from rollgait.config import Line, Number, Positive
from rollgait.dynamics.step import rotations
from rollgait.errors import MISSING, InputError
from rollgait.mpc.prediction import Event, Prediction
from rollgait.npz import Layout
from rollgait.plant.control import Control
from rollgait.plant.state import RobotState
from rollgait.robot.robot import Robot
from rollgait.series import DURATION_MAX, check_numbers, check_quaternions, check_times

Array = NDArray[np.float64]

FORMAT: Final = "rollgait-mpc"
BODILESS: Final = "rigid"
"""The plant that has no legs, so that feet may be where no leg could have them."""
OUTSIDE_MAX: Final = 0.05
"""So far outside its box a foot of that plant may be, m: boxes are costs, and a push costs."""
MODES: Final = ("tracking", "coasting", "standing")


@dataclass(frozen=True, eq=False)
class MpcLog:
    """A run. World frame, SI units, one row for each step of the controller (n), legs FL, FR, HL, HR.

    Attributes:
        time: (n,), s.
        com_position, euler, com_velocity, euler_rate: true state, (n, 3).
        foot_position: (n, 4, 3), m.
        heading, speed: of the wheels, (n, 4), rad and m/s.
        force: that the controller asks for, (n, 4, 3), N.
        contact: (n, 4), which feet shall stand.
        reference: r and yaw that are asked for, (n, 4), m and rad.
        wanted: forward and lateral velocity and yaw rate that are asked for now, (n, 3).
        seconds, solver_seconds: of wall time that each step, and the solver in it, took, (n,).
        iterations, violation, mode, late: of each step, (n,); `mode` counts in `MODES`.
        cost: per second, (n,).
        base_position, base_quaternion, joint_position: of the whole body, (n, …); empty without one.
        joint_names: of the joints.
        robot: the controller's.
        plant: name of the plant.
        period: between two steps, s.
        fallen_at: s; None if it did not fall. The log ends there.
        events: what was not as it should be.
    """

    time: Array
    com_position: Array
    euler: Array
    com_velocity: Array
    euler_rate: Array
    foot_position: Array
    heading: Array
    speed: Array
    force: Array
    contact: NDArray[np.bool_]
    reference: Array
    wanted: Array
    seconds: Array
    solver_seconds: Array
    iterations: NDArray[np.int_]
    violation: Array
    cost: Array
    mode: NDArray[np.int_]
    late: NDArray[np.bool_]
    base_position: Array
    base_quaternion: Array
    joint_position: Array
    joint_names: tuple[str, ...]
    robot: Robot
    plant: str
    period: float
    fallen_at: float | None
    events: tuple[Event, ...]

    def outside(self) -> Array:
        """How far each foot is outside its box in the plane, seen from the base, (n, 4), m; 0 inside."""
        R = rotations(self.euler)
        seen = np.einsum("nji,nlj->nli", R, self.foot_position - self.com_position[:, None])
        away = (seen - self.robot.stance)[..., :2]
        low, high = np.moveaxis(self.robot.foot_boxes()[:, :, :2], 1, 0)
        return np.asarray(np.maximum(np.maximum(low - away, away - high), 0.0).max(axis=2))

    def report(self) -> MpcReport:
        """The run in numbers."""
        c, s = np.cos(self.euler[:, 0]), np.sin(self.euler[:, 0])
        v = self.com_velocity
        forward, lateral = c * v[:, 0] + s * v[:, 1], c * v[:, 1] - s * v[:, 0]
        gaps = np.stack([forward, lateral, self.euler_rate[:, 0]]) - self.wanted.T
        rms = np.sqrt(np.mean(gaps**2, axis=1))
        away = self.com_position[:, :2] - self.reference[:, :2]
        ms = 1e3 * self.seconds
        tilt = np.degrees(np.arccos(np.clip(np.cos(self.euler[:, 1]) * np.cos(self.euler[:, 2]), -1.0, 1.0)))
        return MpcReport(
            duration=float(self.time[-1] - self.time[0]) + self.period,
            steps=int(self.time.size),
            rate=1.0 / self.period,
            median_ms=float(np.median(ms)),
            p99_ms=float(np.percentile(ms, 99.0)),
            worst_ms=float(ms.max()),
            solver_median_ms=float(np.median(1e3 * self.solver_seconds)),
            solver_p99_ms=float(np.percentile(1e3 * self.solver_seconds, 99.0)),
            late=int(self.late.sum()),
            forward_rms=float(rms[0]),
            lateral_rms=float(rms[1]),
            turn_rms=float(rms[2]),
            place_rms=float(np.sqrt(np.mean(np.sum(away**2, axis=1)))),
            final_place=float(np.hypot(*away[-1])),
            final_yaw_deg=float(np.degrees(self.euler[-1, 0] - self.reference[-1, 3])),
            tilt_deg=float(tilt.max()),
            outside=float(self.outside().max()),
            bodiless=self.plant == BODILESS,
            violation=float(self.violation.max()),
            cost=_mean(self.cost),
            coasting=int((self.mode == 1).sum()),
            standing=int((self.mode == 2).sum()),
            fallen_at=self.fallen_at,
            events=tuple(f"{event.time:.2f} s: {event.text}" for event in self.events),
        )

    # -- on disk -----------------------------------------------------------------------------------------

    def save(self, path: str | Path) -> Path:
        """Writes it (.npz). Raises `FileError`."""
        header = {
            "joint_names": list(self.joint_names),
            "robot": self.robot.model_dump(mode="json"),
            "plant": self.plant,
            "period": self.period,
            "fallen_at": self.fallen_at,
            "events": [asdict(event) for event in self.events],
        }
        arrays: dict[str, Any] = {name: getattr(self, name) for name in ARRAYS}
        return _FILE.write(path, header, arrays)

    @classmethod
    def load(cls, path: str | Path) -> MpcLog:
        """Reads it. Raises `FileError`."""
        header, arrays = _FILE.read(path)
        with _FILE.damage_told(path):
            check_times(arrays["time"], motion=False)
            check_numbers(arrays, set(ARRAYS) - {"cost", "violation"})
            if header.joint_names:
                check_quaternions("base_quaternion", arrays["base_quaternion"])
            if not np.all((arrays["mode"] >= 0) & (arrays["mode"] < len(MODES))):
                raise InputError("mode", MISSING, f"must hold numbers below {len(MODES)}")
        return cls(**arrays, **dict(header))  # type: ignore[arg-type]  # the header names its parts as here


@dataclass(frozen=True)
class MpcReport:
    """A run in numbers.

    Attributes:
        duration: s.
        steps: of the controller.
        rate: of the controller, Hz.
        median_ms, p99_ms, worst_ms: wall time of a step.
        solver_median_ms, solver_p99_ms: of the solver alone.
        late: steps that took longer than the deadline.
        forward_rms, lateral_rms, turn_rms: velocity less what is asked for, m/s and rad/s.
        place_rms: CoM from the reference, m.
        final_place, final_yaw_deg: the same at the end, m and degrees.
        tilt_deg: largest.
        outside: farthest of a foot from its box in the ground plane, m.
        bodiless: whether the plant has no legs that could have kept it inside.
        violation: largest of a step, in the solver's scaling.
        cost: mean cost per second.
        coasting, standing: steps in these modes.
        fallen_at: s, or None.
        events: in words.
    """

    duration: float
    steps: int
    rate: float
    median_ms: float
    p99_ms: float
    worst_ms: float
    solver_median_ms: float
    solver_p99_ms: float
    late: int
    forward_rms: float
    lateral_rms: float
    turn_rms: float
    place_rms: float
    final_place: float
    final_yaw_deg: float
    tilt_deg: float
    outside: float
    bodiless: bool
    violation: float
    cost: float
    coasting: int
    standing: int
    fallen_at: float | None
    events: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Whether the robot stayed on its feet and under control."""
        return self.fallen_at is None and self.standing == 0 and not self.is_out_of_reach

    @property
    def is_out_of_reach(self) -> bool:
        """Whether feet of a plant without legs were where no leg could have had them."""
        return self.bodiless and self.outside > OUTSIDE_MAX

    @property
    def verdict(self) -> str:
        """One sentence: what became of the robot."""
        if self.fallen_at is not None:
            return f"the robot falls at {self.fallen_at:.2f} s"
        if self.standing:
            return f"the robot stands for good after {self.duration - self.standing / self.rate:.2f} s"
        if self.is_out_of_reach:
            return f"a foot is {1e3 * self.outside:.0f} mm outside its box, where no leg could have it"
        return "the robot stays on its feet"

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self) | {"passed": self.passed}


class LogWriter:
    """Collects the rows of a log."""

    def __init__(self, robot: Robot, plant: Any, period: float) -> None:
        self._robot, self._plant, self._period = robot, plant, period
        self._rows: list[tuple[Any, ...]] = []

    def add(
        self,
        state: RobotState,
        control: Control,
        prediction: Prediction,
        wanted: Sequence[float],
        pose: tuple[Array, Array, Array] | None = None,
    ) -> None:
        """A step: the true state, what was done, what was expected, and the velocity that is asked for.

        With the pose of the whole body in that state, if there is one.
        """
        status = prediction.status
        base, quaternion, joints = pose if pose is not None else (np.empty(0), np.empty(0), np.empty(0))
        self._rows.append(
            (
                state.time,
                state.com_position,
                state.euler,
                state.com_velocity,
                state.euler_rate,
                state.foot_position,
                state.heading,
                state.speed,
                control.force,
                control.contact,
                prediction.reference[0],
                np.array(wanted, dtype=float),
                status.seconds,
                status.solver_seconds,
                status.iterations,
                status.violation,
                status.cost_rate,
                MODES.index(status.mode),
                status.late,
                np.array(base),
                np.array(quaternion),
                np.array(joints),
            )
        )

    def finish(self, fallen_at: float | None, events: Sequence[Event]) -> MpcLog:
        """The log."""
        columns = [np.array(column) for column in zip(*self._rows, strict=True)]
        return MpcLog(
            **dict(zip(ARRAYS, columns, strict=True)),
            joint_names=tuple(getattr(self._plant, "joint_names", ())),
            robot=self._robot,
            plant=self._plant.name,
            period=self._period,
            fallen_at=fallen_at,
            events=tuple(events),
        )


ARRAYS: Final = (
    "time",
    "com_position",
    "euler",
    "com_velocity",
    "euler_rate",
    "foot_position",
    "heading",
    "speed",
    "force",
    "contact",
    "reference",
    "wanted",
    "seconds",
    "solver_seconds",
    "iterations",
    "violation",
    "cost",
    "mode",
    "late",
    "base_position",
    "base_quaternion",
    "joint_position",
)
"""Names of the arrays of a log, in the order of the rows that `LogWriter` collects."""


def _mean(values: Array) -> float:
    """The mean of what is known; a solve that fails may cost anything, so that sums overflow to ∞."""
    if not np.isfinite(values).any():
        return math.nan
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.nanmean(values))


class _Header(BaseModel):
    """What the header of a log holds."""

    joint_names: tuple[Line, ...]
    robot: Robot
    plant: Line
    period: Annotated[Positive, Field(le=DURATION_MAX)]
    fallen_at: Number | None
    events: tuple[Event, ...]


def _layout(header: _Header) -> Layout:
    """The arrays of a log; n steps. A log without joints has no base either."""
    joints = len(header.joint_names)
    numbers = ("time", "seconds", "solver_seconds", "violation", "cost")
    return {
        **dict.fromkeys(numbers, ("f", ("n",))),
        **dict.fromkeys(("com_position", "euler", "com_velocity", "euler_rate", "wanted"), ("f", ("n", 3))),
        **dict.fromkeys(("foot_position", "force"), ("f", ("n", 4, 3))),
        **dict.fromkeys(("heading", "speed"), ("f", ("n", 4))),
        "contact": ("b", ("n", 4)),
        "reference": ("f", ("n", 4)),
        **dict.fromkeys(("iterations", "mode"), ("i", ("n",))),
        "late": ("b", ("n",)),
        "base_position": ("f", ("n", 3 if joints else 0)),
        "base_quaternion": ("f", ("n", 4 if joints else 0)),
        "joint_position": ("f", ("n", joints)),
    }


_FILE: Final = ArchiveFormat(
    FORMAT,
    1,
    "file",
    "is not a log of the controller that rollgait saved",
    _Header,
    _layout,
    "has version {found}; this rollgait reads {known}",
)
