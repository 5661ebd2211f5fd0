"""No page of another site, no other name of this machine and nobody without the token operates a page."""

from __future__ import annotations

import http.server
import io
import logging
import socket
import threading
import tracemalloc
import zipfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.hostile.pages import (  # skips where viser is absent
    SUBPROTOCOL,
    camera,
    drive,
    host,
    is_let_in,
    silent_page,
    socket_from,
    status,
    until,
    viewer,
)

from rollgait.view.driving.page import DrivePage  # isort: skip  # the lines above skip where viser is absent
from rollgait.view.gate import connections, uploads  # isort: skip
from rollgait.view.gate.access import LOOPBACK, Access, Site, is_loopback  # isort: skip
from rollgait.view.viewer import Viewer  # isort: skip

OURS = ("127.0.0.1", "localhost", "[::1]")
FOREIGN_HOSTS = (
    "evil.example",
    "localhost.evil.example",
    "127.0.0.1.evil.example",
    "192.168.0.1",
    "[::2]",
)


@pytest.fixture(scope="module")
def shown() -> Iterator[Viewer]:
    with viewer() as page:
        yield page


@pytest.fixture(scope="module")
def driven() -> Iterator[DrivePage]:
    with drive() as page:
        yield page


@pytest.fixture(scope="module")
def ports(shown: Viewer, driven: DrivePage) -> list[tuple[int, int]]:
    """Each port that listens, and the port of its page."""
    view, page, joysticks = shown.server.get_port(), port_of(driven), endpoint_of(driven)
    return [(view, view), (page, page), (joysticks, page)]


def port_of(page: DrivePage) -> int:
    return int(page.url.rpartition(":")[2])


def endpoint_of(page: DrivePage) -> int:
    assert page._endpoint is not None
    return page._endpoint.port


# -- origins and hosts ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", OURS)
def test_the_page_itself_is_let_in(ports: list[tuple[int, int]], name: str) -> None:
    for port, page in ports:
        assert is_let_in(port, f"http://{name}:{page}", name)


@pytest.mark.parametrize(
    "origin", [None, "null", "http://evil.example", "https://127.0.0.1:{}", "http://127.0.0.1"]
)
def test_another_origin_is_refused(ports: list[tuple[int, int]], origin: str | None) -> None:
    for port, page in ports:
        assert not is_let_in(port, origin and origin.format(page))
        if origin is not None:
            assert status(port, host(port), ("Origin", origin.format(page))) == 403


def test_a_page_of_another_port_of_this_machine_is_another_origin(ports: list[tuple[int, int]]) -> None:
    for port, page in ports:
        assert not is_let_in(port, f"http://{LOOPBACK}:{page + 1}")


@pytest.mark.parametrize("name", FOREIGN_HOSTS)
def test_a_foreign_host_is_refused(ports: list[tuple[int, int]], name: str) -> None:
    for port, page in ports:
        foreign = f"{name}:{port}"
        assert status(port, ("Host", foreign)) == 403
        assert not is_let_in(port, f"http://{foreign}", name)
        assert not is_let_in(port, f"http://{LOOPBACK}:{page}", name)


def test_hosts_that_are_none_or_two_are_refused(ports: list[tuple[int, int]]) -> None:
    for port, _ in ports:
        assert status(port) == 403
        assert status(port, host(port), host(port)) == 403
        assert status(port, ("Host", LOOPBACK)) == 403  # of port 80
        assert status(port, ("Host", f":{port}")) == 403


def test_a_link_cannot_make_the_page_obey_another_server(shown: Viewer) -> None:
    port = shown.server.get_port()
    assert status(port, host(port)) == 200
    for query in (
        "websocket=ws://evil.example",
        "playbackPath=//evil.example/x",
        "token=x&websocket=x",
        "%77=1",
    ):
        assert status(port, host(port), path=f"/?{query}") == 403


def test_no_other_page_may_lay_itself_over_this_one(shown: Viewer) -> None:
    port = shown.server.get_port()
    with socket.create_connection((LOOPBACK, port)) as stream:
        stream.sendall(f"GET / HTTP/1.1\r\nHost: {LOOPBACK}:{port}\r\n\r\n".encode())
        assert b"X-Frame-Options: DENY" in stream.recv(4096)


def test_a_page_that_hangs_does_not_keep_the_server_from_ending() -> None:
    with ExitStack() as browser:
        with viewer() as page:
            thread = page.server._websock_server._server_thread
            browser.enter_context(silent_page(page.server.get_port()))
        assert thread is not None
        assert not thread.is_alive()


@pytest.mark.slow
def test_a_notebook_of_this_machine_shows_the_page_and_no_other_site_does(
    sheet: Any, other_site: int
) -> None:
    with viewer() as page:
        cell = page._repr_html_()
        for site, is_seen in ((LOOPBACK, True), ("localhost", True), ("evil.example", False)):
            sheet.goto(f"http://{site}:{other_site}")
            show = "html => { document.body.innerHTML = html }"
            if is_seen:
                sheet.evaluate(show, cell)
                sheet.frame_locator("iframe").get_by_text("by hand").wait_for()
            else:
                with sheet.expect_console_message(lambda message: "frame-ancestors" in message.text):
                    sheet.evaluate(show, cell)


names = st.from_regex(r"[a-z0-9.:_-]{1,30}|\[[0-9a-f:.]{1,20}\]", fullmatch=True) | st.text(max_size=20)


@given(names, st.integers(0, 99_999))
def test_nothing_but_its_own_names_belongs_to_a_page(name: str, port: int) -> None:
    site = Site(LOOPBACK, 8080)
    assert site.owns(f"{name}:{port}") == (name.lower() in OURS and port == 8080)


# -- the token --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def public() -> Iterator[Viewer]:
    with viewer("0.0.0.0") as page:
        yield page


def token_of(page: Viewer) -> str:
    return page.url.rpartition("=")[2]


def test_beyond_this_machine_only_the_token_opens_the_page(public: Viewer) -> None:
    port, token = public.server.get_port(), token_of(public)
    origin, cookie = f"http://{LOOPBACK}:{port}", f"rollgait-{port}="
    assert len(token) >= 20
    assert status(port, host(port)) == 403
    assert status(port, host(port), path="/?token=") == 403
    assert status(port, host(port), path=f"/?token={token}x") == 403
    assert status(port, host(port), path="/?token=%C3%A4%00") == 403
    assert status(port, host(port), ("Cookie", f"{cookie}ä")) == 403
    assert status(port, host(port), path=f"/?token={token}") == 200
    assert status(port, host(port), ("Cookie", f"other=1; {cookie}{token}")) == 200
    assert not is_let_in(port, origin)
    assert not is_let_in(port, origin, Cookie=f"{cookie}{token[:-1]}")
    assert is_let_in(port, origin, Cookie=f"{cookie}{token}")
    assert not is_let_in(port, "http://evil.example", Cookie=f"{cookie}{token}")
    assert not is_let_in(port, "http://evil.example", "evil.example", Cookie=f"{cookie}{token}")


def test_each_page_has_a_token_of_its_own_and_the_loopback_needs_none() -> None:
    tokens = {
        Access(Site(name, 8080)).token for name in ("0.0.0.0", "::", "192.168.0.7", "robot.example", "")
    }
    assert len(tokens) == 5
    assert None not in tokens
    for name in ("localhost", "127.0.0.1", "127.1.2.3", "::1"):
        assert is_loopback(name)
        assert Access(Site(name, 8080)).token is None


def test_addresses_are_printed_as_browsers_take_them() -> None:
    assert Access(Site("::1", 8080)).url == "http://[::1]:8080"
    assert Access(Site(LOOPBACK, 8080)).url == "http://127.0.0.1:8080"
    assert Access(Site("2001:db8::7", 80)).url.startswith("http://[2001:db8::7]:80/?token=")
    assert Access(Site("0.0.0.0", 8080)).url.startswith(f"http://{socket.gethostname()}:8080/?token=")
    assert Site("2001:DB8::0:7", 80).owns("[2001:db8::7]")


# -- files that are sent ----------------------------------------------------------------------------------


def uuid_of(page: Viewer, label: str) -> str:
    handles = page.server.gui._gui_input_handle_from_uuid
    return next(uuid for uuid, handle in handles.items() if handle.label == label)


def start_of(page: Viewer, size: int, parts: int) -> dict[str, Any]:
    return {
        "type": "FileTransferStartUpload",
        "source_component_uuid": uuid_of(page, "Open a plan, joints, a log or a scenario"),
        "transfer_uuid": "mine",
        "filename": "bomb.npz",
        "mime_type": "",
        "part_count": parts,
        "size_bytes": size,
    }


def part_of(number: int, content: bytes) -> dict[str, Any]:
    return {
        "type": "FileTransferPart",
        "source_component_uuid": None,
        "transfer_uuid": "mine",
        "part_index": number,
        "content": content,
    }


def bomb(size: int) -> bytes:
    """A small archive of much."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        with archive.open("header.npy", "w") as member:
            np.save(member, np.array("{}"))
        with archive.open("more.npy", "w", force_zip64=True) as member:
            for _ in range(size // 2**20):
                member.write(bytes(2**20))
    return stream.getvalue()


def test_a_file_that_unpacks_to_much_is_refused_before_it_does(shown: Viewer) -> None:
    content, clip = bomb(uploads.UNPACKED_MAX + 2**20), shown.clip
    tracemalloc.start()
    with socket_from(shown.server.get_port(), shown.url) as page:
        for message in (camera(), start_of(shown, len(content), 1), part_of(0, content)):
            page.send(msgspec.msgpack.encode(message))
        until(lambda: "unpacks" in shown._files._note.content)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 32 * 2**20
    assert shown.clip is clip


@pytest.mark.parametrize(("size", "parts"), [(2**40, 1), (-1, 1), (100, 10**9), (100, 0), (0, 3)])
def test_a_file_that_is_too_large_is_not_even_begun(
    shown: Viewer, caplog: pytest.LogCaptureFixture, size: int, parts: int
) -> None:
    with socket_from(shown.server.get_port(), shown.url) as page:
        page.send(msgspec.msgpack.encode(start_of(shown, size, parts)))
        until(lambda: caplog.records)
        page.send(msgspec.msgpack.encode(part_of(0, b"x")))
        until(lambda: len(caplog.records) == 2)
    assert "which is not being sent" in caplog.messages[1]


@pytest.mark.parametrize("leaves", [True, False])
def test_what_is_never_finished_is_forgotten(
    shown: Viewer, monkeypatch: pytest.MonkeyPatch, leaves: bool
) -> None:
    held: list[uploads.Upload] = []
    begin = uploads.Upload.begin

    def watched(upload: uploads.Upload, start: Any) -> Any:
        held.append(upload)
        return begin(upload, start)

    monkeypatch.setattr(uploads.Upload, "begin", watched)
    monkeypatch.setattr(connections, "UPLOAD_SILENCE", 3600.0)
    with socket_from(shown.server.get_port(), shown.url) as page:
        page.send(msgspec.msgpack.encode(start_of(shown, 8 * 2**18, 8)))
        for number in range(7):
            page.send(msgspec.msgpack.encode(part_of(number, bytes(2**18))))
        until(lambda: held and len(held[0]._parts) == 7)
        assert not shown.server.gui._current_file_upload_states
        if not leaves:
            monkeypatch.setattr(connections, "UPLOAD_SILENCE", 0.1)
            page.send(msgspec.msgpack.encode(camera()))  # its last word
            until(lambda: not held[0].unfinished)
    until(lambda: not held[0].unfinished and not held[0]._parts)


# -- in a browser -----------------------------------------------------------------------------------------

TRIES = """async (ports) => {
  const answers = [];
  for (const port of ports) {
    answers.push(await new Promise((done) => {
      const socket = new WebSocket(`ws://${location.hostname}:${port}`, PROTOCOL);
      socket.onopen = () => done("open");
      socket.onerror = () => done("refused");
    }));
  }
  return answers;
}"""


class _Quiet(http.server.BaseHTTPRequestHandler):
    """Another site, of one empty page."""

    def do_GET(self) -> None:
        self.send_response(200)
        self.end_headers()

    def log_message(self, *_: Any) -> None:
        pass


@pytest.fixture(scope="module")
def other_site() -> Iterator[int]:
    with http.server.ThreadingHTTPServer((LOOPBACK, 0), _Quiet) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield server.server_port
        server.shutdown()
        thread.join()


@pytest.fixture(scope="module")
def sheet(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    from tests.view.browser import CHROMIUM, browser

    if CHROMIUM is None:
        pytest.skip("chromium is not installed: apt-get install chromium")
    names = f"MAP evil.example {LOOPBACK}, MAP {socket.gethostname()} {LOOPBACK}"
    profile: Path = tmp_path_factory.mktemp("profile")
    with browser(profile, f"--host-resolver-rules={names}") as context:
        yield context.pages[0]


def tries(sheet: Any, ports: list[tuple[int, int]]) -> set[str]:
    numbers = [port for port, _ in ports]
    return set(sheet.evaluate(TRIES.replace("PROTOCOL", f"[{str(SUBPROTOCOL)!r}]"), numbers))


@pytest.mark.slow
@pytest.mark.parametrize("site", [LOOPBACK, "localhost", "evil.example"])
def test_another_site_cannot_connect_to_any_port(
    sheet: Any, ports: list[tuple[int, int]], other_site: int, site: str
) -> None:
    sheet.goto(f"http://{site}:{other_site}")
    assert tries(sheet, ports) == {"refused"}


@pytest.mark.slow
def test_a_name_that_was_made_to_point_here_gets_nothing(sheet: Any, ports: list[tuple[int, int]]) -> None:
    for port, page in ports:
        if port == page:
            answer = sheet.goto(f"http://evil.example:{port}")
            assert answer.status == 403
            assert tries(sheet, ports) == {"refused"}


@pytest.mark.slow
def test_the_pages_themselves_connect_and_are_never_refused(
    sheet: Any, shown: Viewer, driven: DrivePage, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING, logger="rollgait")
    sheet.goto(shown.url)
    sheet.get_by_text("by hand").wait_for()
    sheet.get_by_role("button", name="Play", exact=True).click()
    until(lambda: shown.timeline.time > 0.1)
    sheet.get_by_role("button", name="Pause", exact=True).click()
    sheet.goto(driven.url)
    sheet.get_by_text("real time").wait_for()
    sheet.frame_locator("iframe[title=joystick]").get_by_text("connected", exact=True).wait_for()
    assert not [text for text in caplog.messages if "refused" in text]


@pytest.mark.slow
def test_beyond_this_machine_the_printed_address_is_enough(sheet: Any, public: Viewer) -> None:
    name, port = socket.gethostname(), public.server.get_port()
    assert sheet.goto(f"http://{name}:{port}").status == 403
    sheet.goto(public.url)
    sheet.get_by_text("by hand").wait_for()
    sheet.get_by_role("button", name="Play", exact=True).click()
    until(lambda: public.timeline.playing)
    sheet.goto(f"http://{name}:{port}")  # from here on the cookie is enough
    sheet.get_by_text("by hand").wait_for()
