"""What others read: motions in the formats of the field. A new format is one function and one line here."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any, Final

from rollgait.errors import InputError, UnknownNameError
from rollgait.plan.plan import Plan

FORMATS: Final[dict[str, str]] = {
    "csv": "csv",
    "json": "json",
    "mcap": "mcap",
    "rosbag2": "",
    "mujoco": "xml",
}
"""Every format by its name, with the suffix of its file. Each is a module with a function write_<name>."""


def write(motion: Any, path: str | Path, format: str = "csv", rate: float = 100.0) -> Path:
    """Writes a motion, sampled at a fixed rate, in a format that others read; returns the path.

    Args:
        motion: a plan, or joints (not for csv; mujoco takes joints only).
        path: where to; the folder is created if it is missing.
        format: a key of `FORMATS`.
        rate: samples per second, Hz.

    Raises:
        UnknownNameError: there is no such format.
        InputError: the rate is not positive, or the format cannot hold this kind of motion.
        MissingExtraError: the format needs an extra that is not installed.
        FileError: the path cannot be written to.
    """
    if format not in FORMATS:
        raise UnknownNameError("format", format, FORMATS)
    if format == "csv" and not isinstance(motion, Plan):
        raise InputError("format", "csv", "holds plans only; for joints take json, mcap, rosbag2 or mujoco")
    module = import_module(f"rollgait.export.{format}")
    written: Path = getattr(module, f"write_{format}")(motion, Path(path), rate)
    return written


__all__ = ["FORMATS", "write"]
