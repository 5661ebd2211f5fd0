"""What happened in a simulation, as plain arrays beside the plan. Saving and loading need no physics."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.archive import ArchiveFormat
from rollgait.config import validate
from rollgait.robot.robot import Robot
from rollgait.simulation.disturbances import Disturbances

if TYPE_CHECKING:
    from rollgait.simulation.report import SimulationReport

Array = NDArray[np.float64]

_FILE: Final = ArchiveFormat("rollgait-simulation", 1, "log", "is not a simulation log that rollgait saved")


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
        from rollgait.simulation.report import judge

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
            return cls(
                **{key: arrays[key] for key in _ARRAYS},
                **{key: header[key] for key in _PLAIN},
                joint_names=tuple(header["joint_names"]),
                robot=validate(Robot, header["robot"], "robot"),
                disturbances=validate(Disturbances, header["disturbances"], "disturbances"),
            )


_PLAIN: Final = ("feedback", "ground_height", "motion_end", "fallen_at", "wall_time")
_ARRAYS: Final = tuple(
    field.name
    for field in fields(SimulationLog)
    if field.name not in (*_PLAIN, "joint_names", "robot", "disturbances")
)
