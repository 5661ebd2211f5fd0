"""What is sent together reaches every page together.

Viser's own `atomic` only asks for that. A connection that is just taking messages while a block begins or
ends takes some of them; the rest waits, and when the next values replace it, it is never sent: a page then
shows the base of one frame and the legs of another. Here a block begins and ends in the thread of the event
loop, which takes messages without a pause, so that it finds none of a block or all.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Final

TOGETHER_MAX: Final = 4096
"""Messages that are sent at once; a frame of a robot with a hundred links has some hundreds, and viser's 128
would cut it in two."""
PATIENCE: Final = 1.0
"""How long a block waits for an event loop that does not answer, s."""


class Blocks:
    """Blocks of messages to all pages of one server.

    Args:
        buffer: viser's, of the messages to all pages.
    """

    def __init__(self, buffer: Any) -> None:
        self._buffer = buffer
        buffer.max_window_size = TOGETHER_MAX

    @contextmanager
    def block(self) -> Iterator[None]:
        """What is sent in here is one message to each page, or none where newer values replace it."""
        self._in_the_loop(self._buffer.atomic_start)
        try:
            yield
        finally:
            self._in_the_loop(self._buffer.atomic_end, wait=False)

    def _in_the_loop(self, action: Callable[[], None], wait: bool = True) -> None:
        loop: asyncio.AbstractEventLoop = self._buffer.event_loop
        if _running() is loop:
            action()
            return
        done: concurrent.futures.Future[None] = concurrent.futures.Future()

        def act() -> None:
            action()
            done.set_result(None)

        try:
            loop.call_soon_threadsafe(act)
        except RuntimeError:  # the server has stopped: nobody is there to see anything
            return
        if wait:
            try:
                done.result(PATIENCE)
            except TimeoutError:  # both ends of the block come in their order nevertheless
                return


def _running() -> asyncio.AbstractEventLoop | None:
    try:
        return asyncio.get_running_loop()
    except RuntimeError:
        return None
