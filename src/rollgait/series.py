"""What makes arrays from a file a motion over time: times that increase, numbers that a robot can have."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import InputError

LARGEST: Final = 1e9
"""Largest number of a motion, in SI units: far beyond any robot, and squares of it are still numbers."""
DURATION_MAX: Final = 86400.0
"""Longest motion, s: a day."""
_UNIT_TOLERANCE: Final = 1e-3
"""By how much the length of a quaternion may differ from 1."""


def check_times(time: NDArray[np.float64], *, motion: bool = True) -> None:
    """Raises `InputError` unless times (n,) increase, lie within ±`LARGEST`, and span at most a day.

    Those of a motion must have a first and a last one, after t = 0.
    """
    check_numbers({"time": time}, ["time"])
    if motion and not (time.size > 1 and time[-1] > 0.0):
        raise InputError("time", float(time[-1]), "must be later than 0, and the last of two or more")
    if np.any(np.diff(time) <= 0.0):
        row = 1 + int(np.argmax(np.diff(time) <= 0.0))
        raise InputError("time", float(time[row]), "must be later than the time before it")
    if time[-1] - time[0] > DURATION_MAX:
        rule = f"must be at most {DURATION_MAX:g} s after the first"
        raise InputError("time", float(time[-1]), rule)


def check_numbers(arrays: Mapping[str, NDArray[Any]], names: Iterable[str]) -> None:
    """Raises `InputError` if an array of one of these names holds a number beyond ±`LARGEST`, or none."""
    for name in names:
        if not arrays[name].size:
            continue
        for extreme in (float(arrays[name].min()), float(arrays[name].max())):  # NaN if there is one
            if not abs(extreme) <= LARGEST:
                raise InputError(name, extreme, f"must lie between {-LARGEST:g} and {LARGEST:g}")


def check_quaternions(name: str, quaternions: NDArray[np.float64]) -> None:
    """Raises `InputError` unless all of them, (n, 4), have the length 1."""
    length = np.linalg.norm(quaternions, axis=1)
    wrong = np.abs(length - 1.0) > _UNIT_TOLERANCE
    if np.any(wrong):
        raise InputError(name, float(length[np.argmax(wrong)]), "is the length of a quaternion; it must be 1")
