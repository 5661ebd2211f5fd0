"""A process that does one job after another for its parent: see `crew`."""

from __future__ import annotations

import os
import traceback
from typing import Any

from rollgait.child import Parent, Unreadable, pickled
from rollgait.errors import RollgaitError
from rollgait.parallel.messages import Begun, Done, Failed, Ready


def main() -> None:
    """Hears what is to be done with each job, then the jobs."""
    parent = Parent()
    call = parent.asks()
    parent.tell(Ready())
    while True:
        job = parent.asks()
        parent.tell(Begun())
        answer = _answer(call, job)
        try:
            parent.tell(answer)
        except RollgaitError as error:
            parent.tell(Failed(None, f"what came of a job {error}"))


def _answer(call: Any, job: Any) -> Done | Failed:
    for told in (call, job):
        if isinstance(told, Unreadable):
            return Failed(None, f"a worker cannot read what it was sent: {told.reason}")
    try:
        return Done(call(job))
    except Exception as error:
        error.add_note(f"In a worker:\n{traceback.format_exc()}")
        return _failed(error)
    except BaseException:  # a job that ends its process, as a crash does
        os._exit(1)


def _failed(error: Exception) -> Failed:
    text = f"{type(error).__name__} in a worker: {error}"
    try:
        return Failed(pickled(error), text)
    except RollgaitError:
        return Failed(None, text)
