"""The log of a simulation: its record with its report, and its file. Saving and loading need no physics."""

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
from rollgait.plant.unplanned import UnplannedContact
from rollgait.robot.robot import Robot
from rollgait.series import check_numbers, check_quaternions, check_times
from rollgait.simulation.record import SimulationRecord
from rollgait.simulation.report import SimulationReport, judge
from rollgait.terrain.terrain import Terrain, TerrainHeader, terrain_layout

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SimulationLog(SimulationRecord):
    """A simulation that judges, saves and loads itself; what it holds says `SimulationRecord`."""

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
            "unplanned": [contact.model_dump(mode="json") for contact in self.unplanned],
        }
        arrays: dict[str, Any] = {name: getattr(self, name) for name in _ARRAYS}
        if self.terrain is not None:
            header["terrain"] = self.terrain.to_dict()
            arrays |= {_TERRAIN + name: array for name, array in self.terrain.arrays().items()}
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
            parts = dict(header)
            if header.terrain is not None:
                heights = {name.removeprefix(_TERRAIN): a for name, a in arrays.items() if _TERRAIN in name}
                parts["terrain"] = Terrain.from_dict(header.terrain.model_dump(mode="json"), heights)
            for name in ("base_quaternion", "planned_base_quaternion"):
                check_quaternions(name, arrays[name])
            if not np.all(arrays["effort_max"] > 0.0):
                raise InputError("effort_max", MISSING, "must hold positive numbers")
        return cls(**{name: arrays[name] for name in _ARRAYS}, **parts)  # type: ignore[arg-type]  # the header names its parts as here


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
    terrain: TerrainHeader | None = None
    unplanned: tuple[UnplannedContact, ...] = ()


_TERRAIN: Final = "terrain/"
_PLAIN: Final = ("feedback", "ground_height", "motion_end", "fallen_at", "wall_time")
_ARRAYS: Final = tuple(
    field.name
    for field in fields(SimulationLog)
    if field.name not in (*_PLAIN, "joint_names", "robot", "disturbances", "terrain", "unplanned")
)


def _layout(header: _Header) -> Layout:
    """The arrays of a log; n samples."""
    count = len(header.joint_names)
    ground = {} if header.terrain is None else terrain_layout(header.terrain)
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
        **{_TERRAIN + name: described for name, described in ground.items()},
    }


_FILE: Final = ArchiveFormat(
    "rollgait-simulation", 1, "log", "is not a simulation log that rollgait saved", _Header, _layout
)
