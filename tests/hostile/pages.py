"""The pages under attack, and the ways in."""

from __future__ import annotations

import base64
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from http import HTTPStatus
from typing import Any

import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")

import viser
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from rollgait.scenario import find_scenario
from rollgait.view.clip import clip_of_plan
from rollgait.view.driving.page import DrivePage
from rollgait.view.driving.process import Setup
from rollgait.view.gate.access import LOOPBACK, authority
from rollgait.view.viewer import Viewer
from tests.view.builders import motion_plan

SUBPROTOCOL: Any = f"viser-v{viser.__version__}"
PATIENCE = 300.0
"""What comes at all has come by then, s: only a test that fails waits for so long."""
SCENARIO = find_scenario("wheeled").with_values(
    {"goal": {"x": 0.6}, "horizon": 3.0, "interval": 0.25, "profile": "paper"}
)


@contextmanager
def viewer(host: str = LOOPBACK) -> Iterator[Viewer]:
    """`rollgait view`."""
    with closing(Viewer(clip_of_plan(motion_plan(SCENARIO), "by hand"), host=host, port=0)) as shown:
        yield shown


@contextmanager
def drive() -> Iterator[DrivePage]:
    """`rollgait drive`."""
    with closing(DrivePage(Setup("centauro", "rigid", "drive"), port=0)) as driven:
        yield driven


def status(port: int, *headers: tuple[str, str], path: str = "/") -> int:
    """What a plain request is answered; `headers` are all that it has."""
    lines = [f"GET {path} HTTP/1.1", *(f"{name}: {value}" for name, value in headers), "", ""]
    with socket.create_connection((LOOPBACK, port), timeout=PATIENCE) as stream:
        stream.sendall("\r\n".join(lines).encode())
        first = stream.makefile("rb").readline()
    return int(first.split()[1])


def host(port: int, name: str = LOOPBACK) -> tuple[str, str]:
    """The header that says whom a browser thinks it asks."""
    return "Host", authority(name, port)


@contextmanager
def socket_from(
    port: int, origin: str | None, name: str = LOOPBACK, **headers: str
) -> Iterator[ClientConnection]:
    """A WebSocket as a page of this origin opens it that knows this machine by this name.

    What it is told it takes and forgets: a page that takes nothing is held to be dead after a while.
    """
    asked: Any = origin
    with (
        socket.create_connection((LOOPBACK, port)) as stream,
        connect(
            f"ws://{name}:{port}",
            sock=stream,
            origin=asked,
            subprotocols=[SUBPROTOCOL],
            additional_headers=headers,
            open_timeout=PATIENCE,
            ping_interval=None,
        ) as connection,
    ):
        listening = threading.Thread(target=_take_all, args=(connection,))
        listening.start()
        try:
            yield connection
        finally:
            connection.close()
            listening.join()


def _take_all(connection: ClientConnection) -> None:
    with suppress(ConnectionClosed):
        for _ in connection:
            pass


@contextmanager
def silent_page(port: int) -> Iterator[None]:
    """A page that is let in, reads no more, and never says goodbye, as one of a browser that hangs."""
    lines = [
        "GET / HTTP/1.1",
        f"Host: {LOOPBACK}:{port}",
        "Upgrade: websocket",
        "Connection: Upgrade",
        f"Sec-WebSocket-Key: {base64.b64encode(bytes(16)).decode()}",
        "Sec-WebSocket-Version: 13",
        f"Sec-WebSocket-Protocol: {SUBPROTOCOL}",
        f"Origin: http://{LOOPBACK}:{port}",
    ]
    with socket.create_connection((LOOPBACK, port)) as stream:
        stream.sendall("\r\n".join([*lines, "\r\n"]).encode())
        assert stream.recv(64).startswith(b"HTTP/1.1 101 ")
        yield


def is_let_in(port: int, origin: str | None, name: str = LOOPBACK, **headers: str) -> bool:
    """Whether it can open one."""
    try:
        with socket_from(port, origin, name, **headers):
            return True
    except InvalidStatus as refused:
        if refused.response.status_code != HTTPStatus.FORBIDDEN:
            raise
        return False


def camera() -> dict[str, Any]:
    """What a page says first."""
    three, four = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0)
    size = {"image_height": 700, "image_width": 1100}
    numbers = {"fov": 1.0, "near": 0.1, "far": 100.0}
    return {
        "type": "ViewerCameraMessage",
        **{"wxyz": four, "position": three, "look_at": three, "up_direction": three},
        **size,
        **numbers,
    }


def until(true: Callable[[], Any]) -> None:
    """Waits until something is true."""
    end = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < end, "it does not happen"
        time.sleep(0.02)
