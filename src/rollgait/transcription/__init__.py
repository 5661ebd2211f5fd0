"""From the continuous problem to a nonlinear program, and back."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from rollgait.errors import UnknownNameError

if TYPE_CHECKING:
    from rollgait.ocp.problem import Problem
    from rollgait.transcription.base import Transcribed
    from rollgait.transcription.code import CodeStore

TRANSCRIPTION_NAMES = ("condensed", "collocation")
"""Names under which a transcription can be asked for: each is a module here with a function `transcribe`."""


def transcribe(name: str, problem: Problem, store: CodeStore | None = None) -> Transcribed:
    """The problem as a nonlinear program, by the transcription of this name.

    Args:
        name: one of `TRANSCRIPTION_NAMES`.
        problem: what is to be solved.
        store: keeps the code of its stages, compiled and on disk, e.g. `solvers.code_store.ON_DISK`.

    Raises:
        UnknownNameError: there is no such transcription.
    """
    from rollgait.ocp.timed import TimedProblem  # here: what has no times of its own need not load it

    if isinstance(problem, TimedProblem):
        name = "timed"
    elif name not in TRANSCRIPTION_NAMES:
        raise UnknownNameError("transcription", name, TRANSCRIPTION_NAMES)
    result: Transcribed = import_module(f"rollgait.transcription.{name}").transcribe(problem, store)
    return result
