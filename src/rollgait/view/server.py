"""The web server of a page: on the loopback, at exactly the port that was asked for, quiet, behind a gate."""

from __future__ import annotations

import contextlib
import errno
import io
import socket
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any, Final

import rich
import viser
from viser._threadpool_exceptions import print_threadpool_errors

from rollgait.errors import InputError
from rollgait.view.gate.access import LOOPBACK, Access, Site, is_loopback
from rollgait.view.gate.connections import Gate, behind
from rollgait.view.gate.controls import Controls
from rollgait.view.gate.dress import Dress
from rollgait.view.in_order import InOrder
from rollgait.view.whole import Blocks

__all__ = ["LOOPBACK", "PORT", "Server", "check_address", "start_server", "stop_server"]

PORT: Final = 8080
PORT_MAX: Final = 65535
TRIES: Final = 5
"""How often a free port is looked for: another program may take it before it is used."""


class Server(viser.ViserServer):
    """Viser's server behind a gate, and without its share button: nothing here asks the outside for anything.

    Args:
        host: address to listen on.
        port: to listen on.
        title: of the page.
    """

    def __init__(self, host: str, port: int, title: str) -> None:
        self._gate = gate = Gate(Access(Site(host, port)), Dress(title))
        self.url = gate.access.url
        """The address that lets a browser in; beyond this machine with a token."""
        self.in_order = InOrder()
        """Does what people do on the page."""
        with behind(gate):
            super().__init__(host=host, port=port, label=title, verbose=False)
        gate.controls = Controls(self.gui)
        self._blocks = Blocks(self._websock_server.get_message_buffer())  # viser tells it in no other way
        self.gui._thread_executor = self.in_order

    def atomic(self) -> AbstractContextManager[None]:
        """What is sent in this block is seen together, or not at all."""
        return self._blocks.block()

    def frame(self) -> bool:
        """Lets pages of this machine, as a notebook is one, hold the page in a frame from now on.

        Returns:
            whether they may: not where other machines reach the page.
        """
        self._gate.framed = is_loopback(self.get_host())
        return self._gate.framed

    def in_turn(self, action: Callable[..., None], *args: Any) -> None:
        """Does what somebody asked for when all that was asked for before is done; returns at once."""
        self.in_order.submit(action, *args).add_done_callback(print_threadpool_errors)

    def beside(self, action: Callable[..., None]) -> Callable[..., None]:
        """The action in a thread of its own: what takes long must not hold up what people do meanwhile."""

        def begin(*args: Any) -> None:
            self._thread_executor.submit(action, *args).add_done_callback(print_threadpool_errors)

        return begin

    def stop(self) -> None:
        """Ends the server, when what people have begun on its page is done."""
        self.in_order.end()
        super().stop()

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Refuses: a page must not be able to publish this server."""
        return None


def start_server(host: str, port: int, title: str) -> Server:
    """Starts a server.

    Args:
        host: address to listen on.
        port: 0 takes a free one.
        title: of the page.

    Raises:
        InputError: the port or the host cannot be had.
    """
    server = _listening(host, port, title)
    server.gui.configure_theme(
        show_logo=False,
        show_share_button=False,
        control_width="large",
        brand_color=(0, 114, 178),
    )
    server.gui.main_panel.dock_right()
    return server


def _listening(host: str, port: int, title: str) -> Server:
    """A server at exactly this port; for 0 at one that nobody else has taken before it listened there."""
    tries = TRIES if port == 0 else 1
    for _ in range(tries):
        free = check_address(host, port)
        with _quiet():  # viser prints a table of its addresses
            server = Server(host, free, title)
        if server.get_port() == free:
            return server
        stop_server(server)  # taken in between: viser goes on to the next one
    raise _taken(free)


def stop_server(server: Any) -> None:
    """Stops a server quietly."""
    with _quiet():
        server.stop()


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Nothing is printed, in a notebook neither, where rich goes around stdout."""
    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            yield
    finally:
        console.quiet = before


def check_address(host: str, port: int) -> int:
    """The port, or a free one for 0. Raises `InputError` if nothing can listen there."""
    if not 0 <= port <= PORT_MAX:
        raise InputError("port", port, f"must lie within [0, {PORT_MAX}]; 0 takes a free one")
    try:
        address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    except OSError:
        raise InputError("host", host, "must be an address of this machine") from None
    with socket.socket(address[0], socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except PermissionError:
            raise InputError("port", port, "must be at least 1024 without special rights") from None
        except OverflowError:
            raise InputError("port", port, f"must lie within [0, {PORT_MAX}]") from None
        except OSError as error:
            if error.errno == errno.EADDRNOTAVAIL:
                raise InputError("host", host, "must be an address of this machine") from None
            raise _taken(port) from None
        return int(probe.getsockname()[1])


def _taken(port: int) -> InputError:
    return InputError("port", port, "is in use by another program; choose another, or 0 for a free one")
