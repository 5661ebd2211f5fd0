"""What a worker says to the process that gives it jobs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Ready:
    """It has begun, and knows what to do with jobs."""


@dataclass(frozen=True)
class Done:
    """What came of a job."""

    result: Any


@dataclass(frozen=True)
class Failed:
    """What a job raised."""

    error: Exception


def words(error: Exception) -> str:
    """An error that is not ours, in a sentence."""
    return f"{type(error).__name__}: {error}"
