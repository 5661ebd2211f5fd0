"""What others read: a plan in the formats of the field. A new format is one function and one line here."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final

from rollgait.errors import UnknownNameError
from rollgait.export.csv import write_csv
from rollgait.plan.plan import Plan

Write = Callable[[Plan, Path, float], Path]
"""Writes a plan at a path, sampled at a rate in Hz; returns the path."""

FORMATS: Final[dict[str, Write]] = {
    "csv": write_csv,
}
"""Every format by its name."""


def write(plan: Plan, path: str | Path, format: str = "csv", rate: float = 100.0) -> Path:
    """Writes a plan, sampled at a fixed rate, in a format that others read; returns the path.

    Args:
        plan: what to write.
        path: where to; the folder is created if it is missing.
        format: a key of `FORMATS`.
        rate: samples per second, Hz.

    Raises:
        UnknownNameError: there is no such format.
        InputError: the rate is not positive.
        FileError: the path cannot be written to.
    """
    if format not in FORMATS:
        raise UnknownNameError("format", format, FORMATS)
    return FORMATS[format](plan, Path(path), rate)


__all__ = ["FORMATS", "write"]
