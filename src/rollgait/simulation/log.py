"""What happened in a simulation, as plain arrays beside the plan. Saving and loading need no physics."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from rollgait.archive import ArchiveFormat
from rollgait.config import Flag, Line, NonNegative, Number
from rollgait.errors import MISSING, InputError
from rollgait.npz import Layout
from rollgait.plant.disturbances import Disturbances
from rollgait.robot.robot import Robot
from rollgait.series import check_numbers, check_quaternions, check_times
from rollgait.simulation.report import SimulationReport, judge

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SimulationLog:
    """A simulation. SI units, world frame unless said otherwise, legs in the order FL, FR, HL, HR.

    Attributes:
        time: (n,), s.
        base_position: origin of the base link, (n, 3), m.
        base_quaternion: base link to world, (x, y, z, w), (n, 4).
        base_velocity: linear, then angular velocity of the base link in base axes, (n, 6), m/s and rad/s.
        joint_position: (n, n_j), rad.
        joint_velocity: (n, n_j), rad/s.
        joint_torque: of the drives, (n, n_j), N m.
        torque_peak: largest magnitude since the sample before, (n, n_j), N m.
        com_position: (n, 3), m, with the payload.
        force: contact force on each foot, mean since the sample before, (n, 4, 3), N.
        slip: speed of the material contact point over the ground, (n, 4), m/s; NaN in the air.
        planned_base_position: (n, 3), m.
        planned_base_quaternion: (x, y, z, w), (n, 4).
        planned_com_position: (n, 3), m.
        planned_force: (n, 4, 3), N.
        planned_contact: (n, 4), bool.
        effort_max: of the joints, (n_j,), N m, inf where there is no limit.
        joint_names: of the n_j joints.
        robot: the planner's robot.
        disturbances: what was not as planned.
        feedback: whether the base pose was fed back.
        ground_height: z of the ground, m.
        motion_end: when the planned motion ends, s; the robot stands still from then on.
        fallen_at: when it fell, s; None if it did not. The log ends there.
        wall_time: how long the simulation took, s.
    """

    time: Array
    base_position: Array
    base_quaternion: Array
    base_velocity: Array
    joint_position: Array
    joint_velocity: Array
    joint_torque: Array
    torque_peak: Array
    com_position: Array
    force: Array
    slip: Array
    planned_base_position: Array
    planned_base_quaternion: Array
    planned_com_position: Array
    planned_force: Array
    planned_contact: NDArray[np.bool_]
    effort_max: Array
    joint_names: tuple[str, ...]
    robot: Robot
    disturbances: Disturbances
    feedback: bool
    ground_height: float
    motion_end: float
    fallen_at: float | None
    wall_time: float

    @property
    def fallen(self) -> bool:
        """Whether the robot fell."""
        return self.fallen_at is not None

    def report(self) -> SimulationReport:
        """Judges the simulation (computed once)."""
        return self._report

    @cached_property
    def _report(self) -> SimulationReport:
        return judge(self)

    def save(self, path: str | Path) -> Path:
        """Writes one .npz file (the suffix is added if it is missing); returns its path."""
        header = {
            "joint_names": list(self.joint_names),
            "robot": self.robot.model_dump(mode="json"),
            "disturbances": self.disturbances.model_dump(mode="json"),
            **{name: getattr(self, name) for name in _PLAIN},
        }
        arrays: dict[str, Any] = {name: getattr(self, name) for name in _ARRAYS}
        return _FILE.write(path, header, arrays)

    @classmethod
    def load(cls, path: str | Path) -> SimulationLog:
        """Reads a log; runs no code from the file.

        Raises:
            FileError: the file is missing, is no log, or has a version that is not known here.
        """
        header, arrays = _FILE.read(path)
        with _FILE.damage_told(path):
            check_times(arrays["time"])
            check_numbers(arrays, set(_ARRAYS) - {"slip", "effort_max"})
            for name in ("base_quaternion", "planned_base_quaternion"):
                check_quaternions(name, arrays[name])
            if not np.all(arrays["effort_max"] > 0.0):
                raise InputError("effort_max", MISSING, "must hold positive numbers")
        return cls(**arrays, **dict(header))  # type: ignore[arg-type]  # the header names its parts as here


class _Header(BaseModel):
    """What the header of a log holds."""

    joint_names: Annotated[tuple[Line, ...], Field(min_length=1)]
    robot: Robot
    disturbances: Disturbances
    feedback: Flag
    ground_height: Number
    motion_end: Number
    fallen_at: Number | None
    wall_time: NonNegative


_PLAIN: Final = ("feedback", "ground_height", "motion_end", "fallen_at", "wall_time")
_ARRAYS: Final = tuple(
    field.name
    for field in fields(SimulationLog)
    if field.name not in (*_PLAIN, "joint_names", "robot", "disturbances")
)


def _layout(header: _Header) -> Layout:
    """The arrays of a log; n samples."""
    count = len(header.joint_names)
    joints = ("joint_position", "joint_velocity", "joint_torque", "torque_peak")
    places = ("base_position", "com_position", "planned_base_position", "planned_com_position")
    return {
        "time": ("f", ("n",)),
        **dict.fromkeys(places, ("f", ("n", 3))),
        **dict.fromkeys(("base_quaternion", "planned_base_quaternion"), ("f", ("n", 4))),
        "base_velocity": ("f", ("n", 6)),
        **dict.fromkeys(joints, ("f", ("n", count))),
        **dict.fromkeys(("force", "planned_force"), ("f", ("n", 4, 3))),
        "slip": ("f", ("n", 4)),
        "planned_contact": ("b", ("n", 4)),
        "effort_max": ("f", (count,)),
    }


_FILE: Final = ArchiveFormat(
    "rollgait-simulation", 1, "log", "is not a simulation log that rollgait saved", _Header, _layout
)
