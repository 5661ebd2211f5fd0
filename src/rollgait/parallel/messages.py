"""What a worker says to the process that gives it jobs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Ready:
    """It knows what to do with jobs."""


@dataclass(frozen=True)
class Begun:
    """It begins with a job."""


@dataclass(frozen=True)
class Done:
    """What came of a job."""

    result: Any


@dataclass(frozen=True)
class Failed:
    """What a job raised.

    Attributes:
        error: pickled; None if that cannot be.
        text: the same in words.
    """

    error: bytes | None
    text: str
