"""Where the joysticks report: only our own page may, and who is gone wants nothing."""

import json
import time
from collections.abc import Callable, Iterator

import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")

from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from rollgait.view.driving.endpoint import Endpoint
from rollgait.view.driving.hands import REST, Hands, Wish

HOST, PAGE = "127.0.0.1", 8080
OURS = f"http://{HOST}:{PAGE}"
FORWARD = json.dumps({"stick": [0, 1], "turn": 0, "keys": []})
LEFT = json.dumps({"stick": [0, 0], "turn": 0, "keys": ["a"]})

WITHIN = 300.0
"""s, on a machine that is busy."""


@pytest.fixture
def hands() -> Hands:
    return Hands(patience=3600.0)


@pytest.fixture
def endpoint(hands: Hands) -> Iterator[Endpoint]:
    listening = Endpoint(hands, HOST, PAGE)
    yield listening
    listening.close()


def becomes(hands: Hands, wish: Wish) -> bool:
    return happens(lambda: hands.wish == wish)


def happens(true: Callable[[], bool]) -> bool:
    end = time.monotonic() + WITHIN
    while not true() and time.monotonic() < end:
        time.sleep(0.01)
    return true()


def test_what_is_held_is_wanted_until_the_page_is_gone(endpoint: Endpoint, hands: Hands) -> None:
    with connect(f"ws://{HOST}:{endpoint.port}", origin=OURS, open_timeout=WITHIN) as page:  # type: ignore[arg-type]
        page.send(FORWARD)
        assert becomes(hands, Wish(forward=1.0))
        page.send(LEFT)
        assert becomes(hands, Wish(lateral=1.0))
    assert becomes(hands, REST)


def test_a_stop_holds_until_all_is_let_go(endpoint: Endpoint, hands: Hands) -> None:
    with connect(f"ws://{HOST}:{endpoint.port}", origin=OURS, open_timeout=WITHIN) as page:  # type: ignore[arg-type]
        page.send(FORWARD)
        assert becomes(hands, Wish(forward=1.0))
        hands.stop()
        page.send(FORWARD)
        page.send("{}")
        page.send(LEFT)
        assert becomes(hands, Wish(lateral=1.0))
        page.send(json.dumps({"stop": True}))
        assert becomes(hands, REST)


@pytest.mark.parametrize("text", ["", "{", "[1]", "null", '{"stick": 1}', '{"stick": [NaN, 1], "turn": 0}'])
def test_what_cannot_be_read_wants_nothing(endpoint: Endpoint, hands: Hands, text: str) -> None:
    with connect(f"ws://{HOST}:{endpoint.port}", origin=OURS, open_timeout=WITHIN) as page:  # type: ignore[arg-type]
        page.send(FORWARD)
        assert becomes(hands, Wish(forward=1.0))
        page.send(text)
        assert becomes(hands, REST)
        page.send(FORWARD)
        assert becomes(hands, Wish(forward=1.0))


@pytest.mark.parametrize("origin", ["http://example.org", f"http://{HOST}:{PAGE + 1}", None])
def test_other_pages_are_refused(endpoint: Endpoint, origin: str | None) -> None:
    with (
        pytest.raises(InvalidStatus, match="403"),
        connect(f"ws://{HOST}:{endpoint.port}", origin=origin, open_timeout=WITHIN),  # type: ignore[arg-type]
    ):
        pass


def test_closing_ends_all_connections(hands: Hands) -> None:
    endpoint = Endpoint(hands, HOST, PAGE)
    with connect(f"ws://{HOST}:{endpoint.port}", origin=OURS, open_timeout=WITHIN) as page:  # type: ignore[arg-type]
        page.send(FORWARD)
        assert becomes(hands, Wish(forward=1.0))
        endpoint.close()
        assert becomes(hands, REST)


def test_the_joystick_knows_its_port_and_leaves_its_frame_whole(endpoint: Endpoint) -> None:
    html = endpoint.pad()
    assert str(endpoint.port) in html
    assert "__PORT__" not in html
    assert html.count("<") == 2  # the frame and its end: all inside is escaped
