"""What others read: motions in the formats of the field. A new format is one function and one line here."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from rollgait.errors import MISSING, InputError, UnknownNameError
from rollgait.plan.plan import Plan

if TYPE_CHECKING:
    from rollgait.export.controllers import Controllers

FORMATS: Final[dict[str, str]] = {
    "csv": "csv",
    "json": "json",
    "mcap": "mcap",
    "rosbag2": "",
    "mujoco": "xml",
}
"""Every format by its name, with the suffix of its file. Each is a module with a function write_<name>."""

BAGS: Final = ("mcap", "rosbag2")
"""The formats with messages of ROS 2."""


def write(
    motion: Any,
    path: str | Path,
    format: str = "csv",
    rate: float = 100.0,
    meshes: str | None = None,
    controllers: Controllers | None = None,
) -> Path:
    """Writes a motion, sampled at a fixed rate, in a format that others read; returns the path.

    Args:
        motion: a plan, joints, or the log of a simulation or of the controller (csv: plans only; mujoco: only
            what has joints).
        path: where to; the folder is created if it is missing.
        format: a key of `FORMATS`.
        rate: samples per second, Hz.
        meshes: of bags (mcap and rosbag2): where those who read them find the robot's meshes, `beside` the
            bag, in a `package` that they have, or as a `file` of this machine. Default: beside.
        controllers: of bags: names of controllers of ros2_control, each with its joints or patterns of their
            names. Default: one for the wheels and one for all other joints.

    Raises:
        UnknownNameError: there is no such format.
        InputError: the rate is not positive, the format cannot hold this kind of motion or is no bag, there
            is no such way with meshes, controllers name joints that there are not, or numbers of the motion
            are none.
        MissingExtraError: the format needs an extra that is not installed.
        FileError: the path cannot be written to.
    """
    if format not in FORMATS:
        raise UnknownNameError("format", format, FORMATS)
    if format == "csv" and not isinstance(motion, Plan):
        raise InputError("format", "csv", "holds plans only; for joints take json, mcap, rosbag2 or mujoco")
    asked = {"meshes": meshes, "controllers": controllers}
    options = {name: value for name, value in asked.items() if value is not None}
    if options and format not in BAGS:
        raise InputError(next(iter(options)), MISSING, f"is for bags ({', '.join(BAGS)}), not for {format}")
    if isinstance(motion, Plan):
        motion.require_numbers()
    module = import_module(f"rollgait.export.{format}")
    written: Path = getattr(module, f"write_{format}")(motion, Path(path), rate, **options)
    return written


__all__ = ["FORMATS", "write"]
