"""Signals while foreign code runs, which would swallow what their handlers raise."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Final

OTHERS: Final = tuple(
    getattr(signal, name)
    for name in ("SIGTERM", "SIGHUP", "SIGALRM", "SIGUSR1", "SIGUSR2")
    if hasattr(signal, name)
)
"""Whose handlers may raise something: to end the program, or what takes too long."""


@contextmanager
def deferred_interrupt(others: bool = False) -> Iterator[Callable[[], bool]]:
    """Keeps Ctrl-C until the block ends, and hands it on then: KeyboardInterrupt, if nobody else handles it.

    Yields a function that says whether Ctrl-C was pressed, so that the block can end early. Outside the main
    thread, which alone receives signals, it changes nothing.

    Args:
        others: keeps other signals with handlers in Python, too: for foreign code that runs in this thread,
            and not for long.
    """
    pressed: set[int] = set()

    def remember(number: int, frame: FrameType | None) -> None:
        pressed.add(number)

    def is_pressed() -> bool:
        return signal.SIGINT in pressed

    if threading.current_thread() is not threading.main_thread():
        yield is_pressed
        return
    kept = [number for number in OTHERS if callable(signal.getsignal(number))] if others else []
    before = [(number, signal.signal(number, remember)) for number in (signal.SIGINT, *kept)]
    try:
        yield is_pressed
    finally:
        for number, handler in before:
            signal.signal(number, handler)
    for number in sorted(pressed):
        signal.raise_signal(number)
