"""Foreign code that may never come back, called so that its caller does.

Fatrop regularises a matrix that it cannot factorise, without end and without calling anybody, where rounding
errors alone make it indefinite (a motion far from any that the robot could make, constraints that contradict
each other). No option bounds that, and nothing can end it from outside. So it runs in a thread of its own,
and if it is silent for too long it is left behind: at the lowest priority, until the process ends.
"""

from __future__ import annotations

import contextvars
import logging
import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Generic, TypeVar

log = logging.getLogger("rollgait")

LOOK = 0.05
"""s between looks whether it is still alive."""

T = TypeVar("T")


class NoAnswerError(RuntimeError):
    """Foreign code was silent for too long. What it uses must never be used again, nor freed."""


def call_watched(call: Callable[[], T], signs: Callable[[], int], patience: float) -> T:
    """What a call returns or raises, unless it is silent for too long.

    The call runs in another thread, with the context variables of this one.

    Args:
        call: what is called; it keeps alive what it uses.
        signs: how many signs of life there were so far.
        patience: longest silence, s of processor time, so that the load of the machine changes nothing (of
            wall time where there is no clock for that).

    Raises:
        NoAnswerError: it was left behind.
    """
    thread = _idle.pop() if _idle else _Thread()
    job = _Job(call)
    try:
        thread.begin(job)
        _wait(job, thread, signs, patience)
    except BaseException:
        thread.leave_behind()
        raise
    _idle.append(thread)
    return job.result()


def _wait(job: _Job[T], thread: _Thread, signs: Callable[[], int], patience: float) -> None:
    """Until the job is done."""
    seen, since = signs(), thread.seconds()
    while not job.is_done(LOOK):
        if (now := signs()) != seen:
            seen, since = now, thread.seconds()
        elif thread.seconds() - since > patience:
            raise NoAnswerError(f"no sign of life for {patience:g} s")


class _Job(Generic[T]):
    """A call and what came of it."""

    def __init__(self, call: Callable[[], T]) -> None:
        self._call, self._context = call, contextvars.copy_context()
        self._results: SimpleQueue[tuple[T | None, BaseException | None]] = SimpleQueue()
        self._result: tuple[T | None, BaseException | None] = (None, None)

    def run(self) -> None:
        try:
            result = (self._context.run(self._call), None)
        except BaseException as error:  # it is raised where the call was asked for
            self._results.put((None, error))
        else:
            self._results.put(result)

    def is_done(self, timeout: float) -> bool:
        try:
            self._result = self._results.get(timeout=timeout)
        except Empty:
            return False
        return True

    def result(self) -> T:
        value, error = self._result
        if error is not None:
            raise error
        return value  # type: ignore[return-value]


class _Thread:
    """A thread that runs one job after the other, until it is left behind."""

    def __init__(self) -> None:
        self._jobs: SimpleQueue[_Job[object]] = SimpleQueue()
        self._is_left = False
        self._thread = threading.Thread(target=self._work, name="rollgait solver", daemon=True)
        self._thread.start()
        self._clock: int | None = None
        if hasattr(time, "pthread_getcpuclockid"):
            self._clock = time.pthread_getcpuclockid(self._thread.ident or 0)

    def _work(self) -> None:
        while not self._is_left:
            self._jobs.get().run()  # (no name for it here: what it holds is free as soon as it is done)

    def begin(self, job: _Job[T]) -> None:
        self._jobs.put(job)  # type: ignore[arg-type]

    def seconds(self) -> float:
        """Time that the thread has had."""
        return time.monotonic() if self._clock is None else time.clock_gettime(self._clock)

    def leave_behind(self) -> None:
        self._is_left = True
        with suppress(AttributeError, OSError):  # only Linux can do that
            os.sched_setscheduler(self._thread.native_id or 0, os.SCHED_IDLE, os.sched_param(0))


_idle: list[_Thread] = []
"""Threads that wait for a job: as many as there were at once."""

if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_idle.clear)  # threads do not come along
