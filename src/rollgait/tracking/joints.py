"""A joint trajectory: what the whole body does, sample by sample. Needs no robot library to save and load."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.archive import ArchiveFormat
from rollgait.config import validate
from rollgait.plan.samples import Samples
from rollgait.robot.robot import Robot
from rollgait.tracking.report import TrackingReport

Array = NDArray[np.float64]

_FILE = ArchiveFormat("rollgait-joints", 1, "joints", "is not a joint trajectory that rollgait saved")
_REFERENCE = "reference/"


@dataclass(frozen=True)
class JointTrajectory:
    """The whole body over time. SI units, world frame unless said otherwise.

    Attributes:
        time: (n,), s.
        joint_names: names of the n_j joints in the URDF, in the order of the columns below.
        base_position: origin of the base link, (n, 3), m.
        base_quaternion: base link to world, (x, y, z, w), (n, 4).
        base_velocity: linear, then angular velocity of the base link in base axes, (n, 6), m/s and rad/s.
        joint_position: (n, n_j), rad; wheels count their turns.
        joint_velocity: (n, n_j), rad/s.
        joint_torque: feed-forward, (n, n_j), N m: inverse dynamics less what the planned contact forces do.
        reference: the plan at these times. The heading of a wheel that is planned as a point foot is the one
            it is held at.
        robot: the planner's robot.
        report: how well it follows the plan.
    """

    time: Array
    joint_names: tuple[str, ...]
    base_position: Array
    base_quaternion: Array
    base_velocity: Array
    joint_position: Array
    joint_velocity: Array
    joint_torque: Array
    reference: Samples
    robot: Robot
    report: TrackingReport

    def save(self, path: str | Path) -> Path:
        """Writes one .npz file (the suffix is added if it is missing); returns its path."""
        header = {
            "joint_names": list(self.joint_names),
            "robot": self.robot.model_dump(mode="json"),
            "report": self.report.to_dict(),
        }
        arrays: dict[str, Any] = {name: getattr(self, name) for name in _ARRAYS}
        arrays |= {_REFERENCE + f.name: getattr(self.reference, f.name) for f in fields(Samples)}
        return _FILE.write(path, header, arrays)

    @classmethod
    def load(cls, path: str | Path) -> JointTrajectory:
        """Reads a joint trajectory; runs no code from the file.

        Raises:
            FileError: the file is missing, is no joint trajectory, or has a version that is not known here.
        """
        header, arrays = _FILE.read(path)
        with _FILE.damage_told(path):
            return cls(
                **{key: arrays[key] for key in _ARRAYS},
                joint_names=tuple(header["joint_names"]),
                reference=Samples(**{f.name: arrays[_REFERENCE + f.name] for f in fields(Samples)}),
                robot=validate(Robot, header["robot"], "robot"),
                report=TrackingReport.from_dict(header["report"]),
            )


_ARRAYS = (
    "time",
    "base_position",
    "base_quaternion",
    "base_velocity",
    "joint_position",
    "joint_velocity",
    "joint_torque",
)
