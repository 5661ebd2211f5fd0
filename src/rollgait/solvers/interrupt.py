"""Ctrl-C while foreign code runs, which would swallow Python's KeyboardInterrupt."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def deferred_interrupt() -> Iterator[Callable[[], bool]]:
    """Keeps Ctrl-C until the block ends, and hands it on then: KeyboardInterrupt, if nobody else handles it.

    Yields a function that says whether Ctrl-C was pressed, so that the block can end early. Outside the main
    thread, which alone receives signals, it changes nothing.
    """
    pressed = threading.Event()

    def remember(number: int, frame: FrameType | None) -> None:
        pressed.set()

    if threading.current_thread() is not threading.main_thread():
        yield pressed.is_set
        return
    before = signal.signal(signal.SIGINT, remember)
    try:
        yield pressed.is_set
    finally:
        signal.signal(signal.SIGINT, before)
    if pressed.is_set():
        signal.raise_signal(signal.SIGINT)
