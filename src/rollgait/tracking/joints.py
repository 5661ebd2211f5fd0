"""A joint trajectory: what the whole body does, sample by sample. Needs no robot library to save and load."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from rollgait.archive import ArchiveFormat
from rollgait.config import Line, Positive
from rollgait.errors import MISSING, InputError
from rollgait.npz import Layout
from rollgait.plan.samples import SAMPLES_LAYOUT, Samples
from rollgait.robot.loads import Wrench
from rollgait.robot.robot import Robot
from rollgait.series import check_numbers, check_quaternions, check_times
from rollgait.terrain.terrain import Terrain, TerrainHeader, terrain_layout
from rollgait.tracking.report import TrackingReport

Array = NDArray[np.float64]

INTERVAL_BEFORE: Final = 0.1
"""Interval of the plan, s, where a file does not say it: what all were smoothed by when files did not."""

_REFERENCE = "reference/"
_TERRAIN = "terrain/"


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
        interval: the longest interval of the plan, s: within one, speeds and forces are constant.
        report: how well it follows the plan.
        terrain: the ground of the plan; None where a file does not say it.
        wrenches: what pulls at the base as planned; what it carries the robot says.
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
    interval: float
    report: TrackingReport
    terrain: Terrain | None = None
    wrenches: tuple[Wrench, ...] = ()

    def save(self, path: str | Path) -> Path:
        """Writes one .npz file (the suffix is added if it is missing); returns its path."""
        header: dict[str, Any] = {
            "joint_names": list(self.joint_names),
            "robot": self.robot.model_dump(mode="json"),
            "interval": self.interval,
            "report": self.report.to_dict(),
            "wrenches": [wrench.model_dump(mode="json") for wrench in self.wrenches],
        }
        arrays: dict[str, Any] = {name: getattr(self, name) for name in _ARRAYS}
        arrays |= {_REFERENCE + f.name: getattr(self.reference, f.name) for f in fields(Samples)}
        if self.terrain is not None:
            header["terrain"] = self.terrain.to_dict()
            arrays |= {_TERRAIN + name: array for name, array in self.terrain.arrays().items()}
        return _FILE.write(path, header, arrays)

    @classmethod
    def load(cls, path: str | Path) -> JointTrajectory:
        """Reads a joint trajectory; runs no code from the file.

        Raises:
            FileError: the file is missing, is no joint trajectory, or has a version that is not known here.
        """
        header, arrays = _FILE.read(path)
        with _FILE.damage_told(path):
            check_times(arrays["time"])
            check_numbers(arrays, [name for name in arrays if not name.startswith(_TERRAIN)])
            check_quaternions("base_quaternion", arrays["base_quaternion"])
            if not np.array_equal(arrays["time"], arrays[_REFERENCE + "time"]):
                raise InputError("reference/time", MISSING, "must be the times of the joints")
            heights = {name: arrays[_TERRAIN + name] for name in _ground_layout(header)}
            said = header.terrain
            terrain = None if said is None else Terrain.from_dict(said.model_dump(mode="json"), heights)
        return cls(
            **{key: arrays[key] for key in _ARRAYS},
            joint_names=header.joint_names,
            reference=Samples(**{f.name: arrays[_REFERENCE + f.name] for f in fields(Samples)}),
            robot=header.robot,
            interval=header.interval,
            report=header.report,
            terrain=terrain,
            wrenches=header.wrenches,
        )


class _Header(BaseModel):
    """What the header of a file of joints holds."""

    joint_names: Annotated[tuple[Line, ...], Field(min_length=1)]
    robot: Robot
    interval: Positive = INTERVAL_BEFORE
    report: TrackingReport
    terrain: TerrainHeader | None = None
    wrenches: tuple[Wrench, ...] = ()


_ARRAYS = (
    "time",
    "base_position",
    "base_quaternion",
    "base_velocity",
    "joint_position",
    "joint_velocity",
    "joint_torque",
)


def _ground_layout(header: _Header) -> Layout:
    """The arrays of its ground."""
    return {} if header.terrain is None else terrain_layout(header.terrain)


def _layout(header: _Header) -> Layout:
    """The arrays of a file of joints; n samples."""
    joints = ("f", ("n", len(header.joint_names)))
    return {
        "time": ("f", ("n",)),
        "base_position": ("f", ("n", 3)),
        "base_quaternion": ("f", ("n", 4)),
        "base_velocity": ("f", ("n", 6)),
        **dict.fromkeys(("joint_position", "joint_velocity", "joint_torque"), joints),
        **{_REFERENCE + name: described for name, described in SAMPLES_LAYOUT.items()},
        **{_TERRAIN + name: described for name, described in _ground_layout(header).items()},
    }


_FILE = ArchiveFormat(
    "rollgait-joints", 2, "joints", "is not a joint trajectory that rollgait saved", _Header, _layout
)
