"""The connections of viser's server, behind the gate.

Viser 1.1 has no hook for who may connect, nor for what comes from a page; but all of it goes through the
server of `websockets` that it begins. While a server is begun here, that one is begun with a gate in it.
"""

from __future__ import annotations

import asyncio
import logging
import threading
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http import HTTPStatus
from typing import Any, Final

import websockets.asyncio.server as web
from websockets.http11 import Request, Response

from rollgait.view.gate.access import Access
from rollgait.view.gate.controls import Controls
from rollgait.view.gate.dress import Dress
from rollgait.view.gate.inbox import Inbox
from rollgait.view.gate.messages import RefusedError
from rollgait.view.gate.uploads import UPLOAD_SILENCE

MESSAGE_MAX: Final = 2**20
"""Largest message of a page, bytes: twice a part of a file."""
HEADERS: Final = {
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",  # the address may hold the token
    "Cache-Control": "no-store",
}

GOODBYE: Final = 0.5
"""s that a page has to answer as the server ends: one that hangs would hold it up for six."""
ALONE: Final = {"X-Frame-Options": "DENY", "Content-Security-Policy": "frame-ancestors 'none'"}
"""No other page may lay itself over this one."""
IN_NOTEBOOKS: Final = {
    "Content-Security-Policy": "frame-ancestors http://localhost:* http://127.0.0.1:* "
    "https://localhost:* https://127.0.0.1:*"
}
"""But pages of servers of this machine, which a notebook's is."""

log = logging.getLogger("rollgait")
quiet = logging.getLogger(f"{__name__}.websockets")
quiet.setLevel(logging.CRITICAL)  # what is refused is told in one line, not as a traceback

_BEGINNING: Final = threading.Lock()


class Gate:
    """Decides who may connect to one server, and what of a page's messages is heard.

    Attributes:
        access: who may connect.
        dress: of the page; None leaves it as it is.
        controls: of the page; None until there are any, and nothing is heard before.
        framed: whether pages of this machine may hold the page in a frame.
    """

    def __init__(self, access: Access, dress: Dress | None = None) -> None:
        self.access, self.dress = access, dress
        self.controls: Controls | None = None
        self.framed = False

    def refusal(self, connection: Any, request: Request) -> Response | None:
        """The answer to a request that is refused, None if it is not; for `process_request`."""
        why = self.access.refusal(request)
        if why is None:
            return None
        log.warning("the page refused a request: %s", why)
        response: Response = connection.respond(HTTPStatus.FORBIDDEN, f"Refused: {why}.\n")
        return response

    def connection(self, *args: Any, **options: Any) -> web.ServerConnection:
        """A connection behind this gate; for `create_connection`."""
        return _Connection(self, *args, **options)


class _Connection(web.ServerConnection):
    """A page's connection; what is received from it has been through the gate."""

    def __init__(self, gate: Gate, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._gate = gate
        self._inbox: Inbox | None = None
        self._heard: deque[bytes] = deque()
        self._forgetting: asyncio.TimerHandle | None = None
        self._is_first = True
        self.wants_head = False
        """Whether the headers of the answer are all that is asked for."""

    def data_received(self, data: bytes) -> None:
        """As the library's own, which knows GET alone and tells of HEAD by a traceback."""
        if self._is_first and data.startswith(b"HEAD "):
            self.wants_head, data = True, b"GET " + data.removeprefix(b"HEAD ")
        self._is_first = False
        super().data_received(data)

    async def recv(self, decode: bool | None = None) -> Any:
        while not self._heard:
            raw = await super().recv(decode)
            try:
                self._heard += self._inbox_now().admit(raw)
            except RefusedError as refused:
                log.warning("the page's message was refused: %s", refused)
            self._forget_later()
        return self._heard.popleft()

    def _inbox_now(self) -> Inbox:
        if self._inbox is None:
            if self._gate.controls is None:
                raise RefusedError("the page is not built yet")
            self._inbox = Inbox(self._gate.controls)
        return self._inbox

    def _forget_later(self) -> None:
        if self._forgetting is not None:
            self._forgetting.cancel()
            self._forgetting = None
        if self._inbox is not None and self._inbox.upload.unfinished:
            self._forgetting = self.loop.call_later(UPLOAD_SILENCE, self._inbox.upload.forget)

    def connection_lost(self, exc: Exception | None) -> None:
        if self._inbox is not None:
            self._inbox.upload.forget()
        super().connection_lost(exc)


@contextmanager
def behind(gate: Gate) -> Iterator[None]:
    """The server that viser begins in this block is behind the gate.

    Raises:
        RuntimeError: viser has begun none in the way that is known here.
    """
    begun: list[Any] = []
    plain = web.serve

    def serve(handler: Any, *args: Any, **options: Any) -> web.serve:
        if not str(handler.__module__).startswith("viser."):
            return plain(handler, *args, **options)
        begun.append(handler)
        options["process_request"] = _answering(gate, options.get("process_request"))
        options |= {"max_size": MESSAGE_MAX, "logger": quiet, "create_connection": gate.connection}
        options["close_timeout"] = GOODBYE
        return plain(handler, *args, **options)

    with _BEGINNING:
        web.serve = serve  # type: ignore[assignment, misc]
        try:
            yield
        finally:
            web.serve = plain  # type: ignore[misc]
    if not begun:
        raise RuntimeError("viser's server cannot be put behind a gate")


def _answering(gate: Gate, process_request: Callable[[Any, Request], Response | None] | None) -> Any:
    """Viser's answers, for requests that are not refused, and with headers that protect the page."""

    def answer(connection: Any, request: Request) -> Response | None:
        response = gate.refusal(connection, request)
        if response is None and process_request is not None:
            response = process_request(connection, request)
            if response is not None and gate.access.cookie is not None:
                response.headers["Set-Cookie"] = gate.access.cookie
        if response is not None and gate.dress is not None:
            gate.dress.put_on(response)
        if response is not None and connection.wants_head:
            response.body = b""
        if response is not None:
            for name, value in (HEADERS | (IN_NOTEBOOKS if gate.framed else ALONE)).items():
                response.headers[name] = value
        return response

    return answer
