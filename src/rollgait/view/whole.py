"""What is sent together reaches every page together.

Viser's own `atomic` only asks for that. A connection that is just taking messages while a block begins or
ends takes some of them; the rest waits, and when the next values replace it, it is never sent: a page then
shows the base of one frame and the legs of another. Here a block begins and ends in the thread of the event
loop, which takes messages without a pause, so that it finds none of a block or all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Final

from rollgait.view.event_loop import in_the_loop

TOGETHER_MAX: Final = 4096
"""Messages that are sent at once; a frame of a robot with a hundred links has some hundreds, and viser's 128
would cut it in two."""


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
        in_the_loop(self._buffer.event_loop, action, wait)
