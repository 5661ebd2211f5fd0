"""What people do on a page counts in its order, and no number that was typed is lost."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import msgspec
import pytest

from tests.hostile.pages import camera, socket_from, until, viewer

from rollgait.view.design.loads import with_load  # isort: skip  # the line above skips where viser is absent
from rollgait.view.in_order import InOrder, show_values  # isort: skip
from rollgait.view.viewer import Viewer  # isort: skip

TYPED = [(0.1, 0.0, 0.3), (0.1, 0.15, 0.3), (0.1, 0.15, 0.25)]
"""Box after box of three."""


@pytest.fixture
def shown() -> Iterator[Viewer]:
    with viewer() as page:
        yield page


def handle_of(page: Viewer, label: str) -> Any:
    found = page.server.gui._gui_input_handle_from_uuid
    return next(handle for handle in found.values() if handle.label == label)


def update_of(handle: Any, value: Any) -> bytes:
    message = {"type": "GuiUpdateMessage", "uuid": handle._impl.uuid, "updates": {"value": value}}
    return msgspec.msgpack.encode(message)


def test_all_is_done_one_after_another_in_its_order() -> None:
    executor, free, done, at_once = InOrder(), threading.Event(), list[int](), list[int]()

    def act(number: int) -> None:
        at_once.append(number)
        assert at_once == [number]
        if number == 0:
            free.wait()
        done.append(number)
        at_once.remove(number)

    tasks = [executor.submit(act, number) for number in range(50)]
    free.set()
    for task in tasks:
        task.result()
    executor.shutdown()
    assert done == list(range(50))


def test_what_is_typed_while_the_number_before_is_taken_stays_and_counts(
    shown: Viewer, monkeypatch: pytest.MonkeyPatch
) -> None:
    designer = shown.designer
    designer.change(with_load(designer.draft.scenario, "payload"))
    box = handle_of(shown, "carried at")
    put, said, queue = designer.draft.put, list[Any](), box._impl.gui_api._websock_interface.queue_message

    def slow(*args: Any) -> None:
        """A machine that is so busy that all is typed before the first number is taken."""
        until(lambda: box.value == TYPED[-1])
        put(*args)

    def spied(message: Any) -> None:
        if getattr(message, "uuid", "") == box._impl.uuid and message.excluded_self_client is None:
            said.append(message)
        queue(message)

    monkeypatch.setattr(designer.draft, "put", slow)
    monkeypatch.setattr(box._impl.gui_api._websock_interface, "queue_message", spied)
    with socket_from(shown.server.get_port(), shown.url) as page:
        page.send(msgspec.msgpack.encode(camera()))
        until(shown.server.get_clients)
        for value in TYPED:
            page.send(update_of(box, value))
        until(lambda: designer.draft.scenario.loads.payload[0].at == TYPED[-1])
        shown.server.in_order.submit(lambda: None).result()
    assert box.value == TYPED[-1]
    assert said == []  # the page knows what was typed there


def test_nothing_is_shown_over_what_waits_to_be_taken(shown: Viewer) -> None:
    free = threading.Event()
    box = handle_of(shown, "friction")
    before = box.value
    shown.server.in_order.submit(free.wait)
    with socket_from(shown.server.get_port(), shown.url) as page:
        page.send(msgspec.msgpack.encode(camera()))
        until(shown.server.get_clients)
        page.send(update_of(box, 0.75))
        until(lambda: shown.server.in_order.has_untaken(box))
        show_values([(box, before)])
        assert box.value == 0.75
        free.set()
        until(lambda: shown.designer.draft.scenario.ground.friction == 0.75)
        shown.server.in_order.submit(lambda: None).result()
    show_values([(box, before)])
    assert box.value == before
