"""A joint trajectory: what the whole body does, sample by sample. Needs no robot library to save and load."""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.config import validate
from rollgait.errors import FileError
from rollgait.files import replacing
from rollgait.plan.samples import Samples
from rollgait.robot.robot import Robot
from rollgait.tracking.report import TrackingReport

Array = NDArray[np.float64]

FORMAT_VERSION = 1
"""Version of the file format; a file with another one is refused."""

_FORMAT = "rollgait-joints"
_NO_JOINTS = "is not a joint trajectory that rollgait saved"
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
        target = Path(path)
        if target.suffix != ".npz":
            target = target.with_name(target.name + ".npz")
        header = {
            "format": _FORMAT,
            "version": FORMAT_VERSION,
            "joint_names": list(self.joint_names),
            "robot": self.robot.model_dump(mode="json"),
            "report": self.report.to_dict(),
        }
        arrays: dict[str, Any] = {name: getattr(self, name) for name in _ARRAYS}
        arrays |= {_REFERENCE + f.name: getattr(self.reference, f.name) for f in fields(Samples)}
        with replacing(target) as temporary, temporary.open("wb") as stream:
            np.savez_compressed(stream, header=np.array(json.dumps(header)), **arrays)
        return target

    @classmethod
    def load(cls, path: str | Path) -> JointTrajectory:
        """Reads a joint trajectory; runs no code from the file.

        Raises:
            FileError: the file is missing, is no joint trajectory, or has a version that is not known here.
        """
        name = str(path)
        try:
            with np.load(path, allow_pickle=False) as data:
                arrays = {key: data[key] for key in data.files}
            header = json.loads(str(arrays.pop("header")))
            known = header.get("format") == _FORMAT
        except OSError as error:
            reason = f"cannot be read: {error.strerror}" if error.strerror else _NO_JOINTS
            raise FileError("joints", name, reason) from None
        except Exception:  # damaged bytes lead anywhere
            raise FileError("joints", name, _NO_JOINTS) from None
        if not known:
            raise FileError("joints", name, _NO_JOINTS)
        if header.get("version") != FORMAT_VERSION:
            rule = f"has format version {header.get('version')}; this rollgait knows version {FORMAT_VERSION}"
            raise FileError("joints", name, rule)
        try:
            return cls(
                **{key: arrays[key] for key in _ARRAYS},
                joint_names=tuple(header["joint_names"]),
                reference=Samples(**{f.name: arrays[_REFERENCE + f.name] for f in fields(Samples)}),
                robot=validate(Robot, header["robot"], "robot"),
                report=TrackingReport.from_dict(header["report"]),
            )
        except (KeyError, TypeError, ValueError) as error:
            reason = f"{error} is missing" if isinstance(error, KeyError) else str(error).splitlines()[0]
            raise FileError("joints", name, f"is damaged: {reason}") from None


_ARRAYS = (
    "time",
    "base_position",
    "base_quaternion",
    "base_velocity",
    "joint_position",
    "joint_velocity",
    "joint_torque",
)
