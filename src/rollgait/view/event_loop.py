"""Things that are done in the thread of a server's event loop, so that nothing of it comes in between."""

from __future__ import annotations

import asyncio
import concurrent.futures
from collections.abc import Callable
from typing import Final

PATIENCE: Final = 1.0
"""How long is waited for an event loop that does not answer, s."""


def in_the_loop(loop: asyncio.AbstractEventLoop, action: Callable[[], None], wait: bool = True) -> None:
    """Does something in the thread of an event loop, in the order of these calls.

    Args:
        loop: of the server.
        action: what is to be done; what it raises is raised here, if it is waited for.
        wait: until it is done, but no longer than `PATIENCE`.
    """
    if _running() is loop:
        action()
        return
    done: concurrent.futures.Future[None] = concurrent.futures.Future()

    def act() -> None:
        try:
            action()
        except BaseException as error:
            done.set_exception(error)
        else:
            done.set_result(None)

    try:
        loop.call_soon_threadsafe(act)
    except RuntimeError:  # the server has stopped: nobody is there to see anything
        return
    if wait:
        try:
            done.result(PATIENCE)
        except TimeoutError:  # it comes in its order nevertheless
            return


def _running() -> asyncio.AbstractEventLoop | None:
    try:
        return asyncio.get_running_loop()
    except RuntimeError:
        return None
