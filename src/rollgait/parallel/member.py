"""A process that does one job after another for its parent: see `crew`."""

from __future__ import annotations

from typing import Any

from rollgait.child import Parent
from rollgait.errors import RollgaitError
from rollgait.parallel.messages import Done, Failed, Ready, words


def main() -> None:
    """Hears what is to be done with each job, then the jobs."""
    parent = Parent()
    call = parent.asks()
    parent.tell(Ready())
    while True:
        answer = _answer(call, parent.asks())
        try:
            parent.tell(answer)
        except Exception as error:  # it cannot be pickled
            parent.tell(Failed(RollgaitError(f"what came of a job cannot be sent: {words(error)}")))


def _answer(call: Any, job: Any) -> Done | Failed:
    for told in (call, job):
        if isinstance(told, Exception):
            return Failed(RollgaitError(f"a worker cannot read what it was sent: {words(told)}"))
    try:
        return Done(call(job))
    except Exception as error:
        return Failed(error)
