"""What people do on a page is done one after another, in the order in which they did it.

Viser hands each click and each number that is typed to a pool of threads. There, of two numbers typed in a
hurry the first may be taken last, and a plan may begin before the number typed ahead of it counts. Here one
thread takes all of it; and where a person has set what it has not taken yet, nobody shows anything else.
"""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, ParamSpec, TypeVar

import viser

from rollgait.view.event_loop import in_the_loop

P = ParamSpec("P")
T = TypeVar("T")


class InOrder(ThreadPoolExecutor):
    """One thread, for the callbacks of a page's controls."""

    def __init__(self) -> None:
        super().__init__(max_workers=1, thread_name_prefix="page")
        self._untaken: Counter[str] = Counter()
        self._counting = threading.Lock()
        self._ended = False

    def end(self) -> None:
        """Waits for what is under way; nothing is begun any more."""
        self._ended = True
        self.shutdown(wait=True, cancel_futures=True)

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Does something when all before it is done; after the end nothing, without a word."""
        if self._ended:
            return Future()
        uuid = _control(args)
        self._count(uuid, 1)

        def act() -> T:
            self._count(uuid, -1)  # from here on it is taken: who looks at the control sees the newest value
            return fn(*args, **kwargs)

        return super().submit(act)

    def has_untaken(self, handle: Any) -> bool:
        """Whether a person has set this control, and that waits for what was done before."""
        return self._untaken[handle._impl.uuid] > 0

    def _count(self, uuid: str, more: int) -> None:
        with self._counting:
            self._untaken[uuid] += more


def show_values(values: Iterable[tuple[Any, Any]]) -> None:
    """Shows values in their controls, but not over what a person has set there meanwhile.

    Viser sets what comes from pages in its event loop. It is done there, too: so nothing comes in between.

    Args:
        values: controls, each with its value; one that is shown already is not sent again.
    """
    others = [(handle, value) for handle, value in values if handle.value != value]
    if not others:
        return

    def show() -> None:
        for handle, value in others:
            executor = handle._impl.gui_api._thread_executor  # viser tells it in no other way
            if not (isinstance(executor, InOrder) and executor.has_untaken(handle)):
                handle.value = value

    in_the_loop(others[0][0]._impl.gui_api._event_loop, show)


def _control(args: tuple[Any, ...]) -> str:
    """Which control an event is of; "" for what is none."""
    event = args[0] if args else None
    return str(event.target._impl.uuid) if isinstance(event, viser.GuiEvent) else ""
