"""Where the joysticks of all pages report: a WebSocket on the loopback that no other web page can use."""

from __future__ import annotations

import contextlib
import json
import logging
import threading
from html import escape
from importlib import resources
from typing import Any, Final

from websockets.exceptions import ConnectionClosed
from websockets.sync.server import Server, ServerConnection, serve

from rollgait.view.driving.hands import Hands, wish_from
from rollgait.view.gate.access import Access, Site
from rollgait.view.gate.connections import Gate

PAD_HEIGHT: Final = 156
"""Of the joystick on the page, pixels."""
MESSAGE_MAX: Final = 4096
"""bytes"""


class Endpoint:
    """Listens until `close`.

    Args:
        hands: who wants what.
        host: address to listen on; a free port is taken.
        page_port: only pages from this port may connect: any page in the browser can try.
    """

    def __init__(self, hands: Hands, host: str, page_port: int) -> None:
        self._hands = hands
        self._open: set[ServerConnection] = set()
        quiet = logging.getLogger(f"{__name__}.connections")
        quiet.setLevel(logging.CRITICAL)
        self._server: Server = serve(
            self._listen,
            host,
            0,
            process_request=lambda *request: gate.refusal(*request),
            max_size=MESSAGE_MAX,
            compression=None,
            logger=quiet,
        )
        self.port = int(self._server.socket.getsockname()[1])
        gate = Gate(Access(Site(host, self.port), page=Site(host, page_port)))
        self._thread = threading.Thread(target=self._server.serve_forever, name="joysticks", daemon=True)
        self._thread.start()

    def _listen(self, connection: ServerConnection) -> None:
        """One page, until it is gone; then it wants nothing."""
        self._open.add(connection)
        try:
            for text in connection:
                message = _read(text)
                if isinstance(message, dict) and message.get("stop") is True:
                    self._hands.stop()
                self._hands.report(connection, wish_from(message))
        except ConnectionClosed:
            pass
        finally:
            self._open.discard(connection)
            self._hands.leave(connection)

    def pad(self) -> str:
        """The joystick as HTML: a frame that has the origin of the page, as scripts run only in frames."""
        text = resources.files(__package__).joinpath("pad.html").read_text(encoding="utf-8")
        inside = escape(text.replace("__PORT__", str(self.port)))
        return (
            f'<iframe title="joystick" style="border:0;width:100%;height:{PAD_HEIGHT}px" '
            f'srcdoc="{inside}"></iframe>'
        )

    def close(self) -> None:
        """Ends all connections."""
        self._server.shutdown()
        for connection in list(self._open):
            with contextlib.suppress(OSError, ConnectionClosed):
                connection.close()
        self._thread.join()


def _read(text: str | bytes) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return None
