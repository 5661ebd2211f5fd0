"""Whatever a page says: it is refused in one line, or a person could have meant it; and all goes on."""

from __future__ import annotations

import asyncio
import dataclasses
import logging
import math
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from functools import cache
from typing import Any

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.hostile.pages import PATIENCE, camera, drive, socket_from, until, viewer

import viser  # isort: skip  # the line above skips where it is absent
from viser import _messages as wire  # isort: skip

from rollgait.errors import InputError  # isort: skip
from rollgait.mpc.command import VelocityCommand  # isort: skip
from rollgait.mpc.settings import MpcSettings  # isort: skip
from rollgait.mpc.setup import make_loop  # isort: skip
from rollgait.view.driving.messages import NO_FORCE, PushRequest, Request  # isort: skip
from rollgait.view.driving.page import DrivePage  # isort: skip
from rollgait.view.driving.panel import PULL_MAX, pull_of  # isort: skip
from rollgait.view.driving.session import Session  # isort: skip
from rollgait.view.gate.controls import Controls  # isort: skip
from rollgait.view.gate.inbox import Inbox  # isort: skip
from rollgait.view.gate.messages import NUMBER_MAX, RefusedError, decode  # isort: skip
from rollgait.view.viewer import Viewer  # isort: skip

EXAMPLES = settings(
    max_examples=1000, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
ROUNDS = 5
"""Of the event loop, after which all that was received is heard: viser makes a task of each message."""
MEANT_MIN = 50
"""Of a thousand messages at least so many must be let through, or the test says nothing."""
PATIENT = MpcSettings(deadline=60.0)
"""So that the load of the machine changes nothing."""
LONG_TASKS = {"Plan", "Find the whole body", "Export"}
"""Buttons that begin what takes minutes."""

numbers = (
    st.floats() | st.integers(-(2**63), 2**64 - 1) | st.sampled_from([math.nan, math.inf, 1e9, 1e308, -0.0])
)
plain = st.none() | st.booleans() | numbers | st.text(max_size=20) | st.binary(max_size=20)
values = st.recursive(
    plain,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)
KINDS = {
    kind.__name__: [field.name for field in dataclasses.fields(kind)]
    for kind in wire.Message.get_subclasses()
    if dataclasses.is_dataclass(kind)
}
SCENE_KINDS = {"SceneNodeClickMessage", "SceneNodeDragMessage", "TransformControlsUpdateMessage"}
"""What hands do in the scene."""
ATTRIBUTES = ("value", "value", "value", "update_cb", "removed", "props", "uuid", "__class__")


@pytest.fixture(scope="module")
def driven() -> Iterator[DrivePage]:
    with drive() as page:
        yield page


@pytest.fixture(scope="module")
def shown() -> Iterator[Viewer]:
    with viewer() as page:
        yield page


def handles_of(server: Any) -> dict[str, Any]:
    found: dict[str, Any] = server.gui._gui_input_handle_from_uuid
    return {uuid: handle for uuid, handle in found.items() if handle.label not in LONG_TASKS}


def handle_of(server: Any, label: str) -> tuple[str, Any]:
    return next((uuid, handle) for uuid, handle in handles_of(server).items() if handle.label == label)


def update_of(uuid: str, value: Any) -> bytes:
    """A page sets a control."""
    return msgspec.msgpack.encode({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}})


def fitting(handle: Any) -> st.SearchStrategy[Any]:
    """Values that look right for a control: choices, numbers in and around its range, true."""
    if hasattr(handle, "options"):
        return st.sampled_from(handle.options)
    if isinstance(handle, viser.GuiSliderHandle | viser.GuiNumberHandle):
        return st.floats(-10.0, 200.0) | numbers
    if isinstance(handle, viser.GuiVector3Handle):
        return st.lists(st.floats(-5.0, 5.0) | numbers, min_size=3, max_size=3)
    return st.booleans()


@cache
def messages_of(server: Any) -> st.SearchStrategy[dict[str, Any]]:
    """Messages of all kinds that viser knows, half of them about what there is on this page."""
    handles = handles_of(server)
    # in the order in which they were made: their names are others each time
    known_uuids = st.sampled_from(list(handles))
    uuids = known_uuids | st.text(max_size=5)
    nodes = st.sampled_from(sorted(server.scene._handle_from_node_name)) | st.text(max_size=5)
    kind = st.just("GuiUpdateMessage")
    likely = known_uuids.flatmap(
        lambda uuid: st.fixed_dictionaries(
            {
                "type": kind,
                "uuid": st.just(uuid),
                "updates": st.fixed_dictionaries({"value": fitting(handles[uuid])}),
            }
        )
    )
    changes = st.dictionaries(st.sampled_from(ATTRIBUTES), values | st.just(True), max_size=2)
    unlikely = st.fixed_dictionaries({"type": kind, "uuid": uuids, "updates": changes})
    numbers_here = st.floats(-5.0, 5.0) | numbers
    vectors = st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=3) | st.lists(numbers_here, max_size=4)
    places = ("position", "start_position", "end_position", "ray_direction", "ray_origin")
    known = {
        **dict.fromkeys(places, vectors),
        **dict.fromkeys(("screen_pos", "start_screen_pos", "end_screen_pos"), st.just([0.5, 0.5])),
        **dict.fromkeys(("uuid", "source_component_uuid"), uuids),
        "name": nodes,
        "owner": st.just(""),
        "wxyz": st.lists(numbers_here, min_size=4, max_size=4),
        "phase": st.sampled_from(["start", "update", "end", "other"]),
        "button": st.sampled_from(["left", "right"]),
        "modifier": st.none() | st.just("shift"),
        "instance_index": st.none(),
    }

    def of_kind(kind: str) -> st.SearchStrategy[dict[str, Any]]:
        fields = {name: known.get(name, values) for name in KINDS[kind]}
        return st.fixed_dictionaries({"type": st.just(kind), **fields})

    of_the_scene = st.sampled_from([kind for kind in sorted(KINDS) if kind in SCENE_KINDS]).flatmap(of_kind)
    return likely | likely | of_the_scene | unlikely | st.sampled_from(sorted(KINDS)).flatmap(of_kind)


def admitted(server: Any, raw: bytes | str) -> list[Any]:
    """What viser would hear, as it reads it."""
    return [wire.Message.deserialize(each) for each in Inbox(Controls(server.gui)).admit(raw)]


def sound(value: Any) -> bool:
    """Whether all numbers are numbers."""
    if isinstance(value, dict):
        return all(map(sound, value.values()))
    if isinstance(value, list | tuple):
        return all(map(sound, value))
    return not isinstance(value, float | int) or abs(value) <= NUMBER_MAX


def is_possible(handle: Any, value: Any) -> bool:
    """Whether a person could have set this value."""
    if hasattr(handle, "options"):
        return value in handle.options
    if isinstance(handle, viser.GuiSliderHandle):
        return bool(handle.min <= value <= handle.max)
    if isinstance(handle, viser.GuiNumberHandle):
        return bool(handle.min is None or value >= handle.min) and (handle.max is None or value <= handle.max)
    return sound(value)


@EXAMPLES
@given(data=st.data())
@pytest.mark.parametrize("name", ["driven", "shown"])
def test_viser_hears_nothing_that_a_person_could_not_have_meant(
    name: str, data: st.DataObject, request: pytest.FixtureRequest
) -> None:
    server = server_of(request.getfixturevalue(name))
    message = data.draw(messages_of(server))
    raw = msgspec.msgpack.encode(message)
    heard, why = [], ""
    try:
        heard = admitted(server, raw)
    except RefusedError as refused:
        why = str(refused)
    assert len(why) < 300
    assert why.isprintable()
    for each in heard:
        assert sound(vars(each))
        if isinstance(each, wire.GuiUpdateMessage):
            assert set(each.updates) == {"value"}
            assert is_possible(handles_of(server)[each.uuid], each.updates["value"])


def server_of(page: Any) -> Any:
    return page.server if isinstance(page, Viewer) else page._server


@EXAMPLES
@given(st.binary(max_size=200) | st.text(max_size=50) | values.map(msgspec.msgpack.encode))
def test_what_is_no_message_is_refused(raw: bytes | str) -> None:
    with pytest.raises(RefusedError):
        decode(raw)


def test_what_is_nested_without_end_is_refused() -> None:
    deep = b"\x91" * 500_000 + b"\xc0"
    update = update_of("x", 0)
    assert update.endswith(b"\x00")
    for raw in (deep, update[:-1] + deep):
        with pytest.raises(RefusedError):
            decode(raw)


def many_of(messages: st.SearchStrategy[Any]) -> list[bytes]:
    """Examples, all made before the first is sent: what they do must not get between their making."""
    made: list[bytes] = []

    @EXAMPLES
    @given(messages)
    def make(message: Any) -> None:
        made.append(message if isinstance(message, bytes) else msgspec.msgpack.encode(message))

    make()
    assert len(made) >= EXAMPLES.max_examples
    return made


@contextmanager
def callbacks_of(server: Any) -> Iterator[list[Future[Any]]]:
    """What the page's messages set off, each with what came of it."""
    begun = list[Future[Any]]()
    executors = (server._thread_executor, server.in_order)
    submits = [executor.submit for executor in executors]

    def watched(submit: Any) -> Any:
        def begin(*task: Any) -> Future[Any]:
            begun.append(submit(*task))
            return begun[-1]

        return begin

    for executor, submit in zip(executors, submits, strict=True):
        executor.submit = watched(submit)
    try:
        yield begun
    finally:
        for executor, submit in zip(executors, submits, strict=True):
            executor.submit = submit


def failures_of(server: Any, begun: list[Future[Any]]) -> list[BaseException]:
    """Waits for all of it, also for what viser begins only now; what went wrong."""
    heard = -1
    while heard != len(begun):
        heard = len(begun)
        until(lambda: all(each.done() for each in list(begun)))
        for _ in range(ROUNDS):
            asyncio.run_coroutine_threadsafe(asyncio.sleep(0.0), server._event_loop).result(PATIENCE)
    return [error for each in begun if (error := each.exception()) is not None]


def say(page: Any, messages: list[bytes], caplog: pytest.LogCaptureFixture) -> None:
    """Sends them all, and waits until the last one was heard."""
    page.send(msgspec.msgpack.encode(camera()))
    for message in messages:
        page.send(message)
    page.send("the last word")
    until(lambda: any("it is text" in text for text in caplog.messages))


def test_a_drive_goes_on_whatever_its_page_says(driven: DrivePage, caplog: pytest.LogCaptureFixture) -> None:
    server = server_of(driven)
    messages = many_of(messages_of(server) | st.binary(max_size=50))
    with callbacks_of(server) as begun, socket_from(server.get_port(), driven.url) as page:
        say(page, messages, caplog)
        assert failures_of(server, begun) == []
        before = driven.snapshot
        until(lambda: driven.snapshot is not before)
        if driven.panel.paused:
            page.send(update_of(handle_of(server, "Go on")[0], True))
        page.send(update_of(handle_of(server, "Reset")[0], True))
        until(lambda: driven.snapshot.mode == "tracking")
        assert failures_of(server, begun) == []
    assert len(begun) >= MEANT_MIN
    assert driven.error is None
    assert not [record for record in caplog.records if record.name != "rollgait"]


def test_a_viewer_goes_on_whatever_its_page_says(shown: Viewer, caplog: pytest.LogCaptureFixture) -> None:
    server = server_of(shown)
    controls = server.gui._gui_input_handle_from_uuid
    long = {uuid for uuid, handle in controls.items() if handle.label in LONG_TASKS}
    messages = many_of(messages_of(server).filter(lambda message: message.get("uuid") not in long))
    with callbacks_of(server) as begun, socket_from(server.get_port(), shown.url) as page:
        say(page, messages, caplog)
        assert failures_of(server, begun) == []
        shown.timeline.pause()
        somewhere = round(0.5 * shown.timeline.horizon, 3)  # which the page may have set, too
        shown.timeline.go(somewhere)
        until(lambda: shown.time.slider.value == somewhere)
    assert len(begun) >= MEANT_MIN
    assert not [record for record in caplog.records if record.name != "rollgait"]


# -- one by one ------------------------------------------------------------------------------------------


def told(server: Any, label: str, value: Any) -> Any:
    """What a control is set to when a page sets it."""
    uuid, _ = handle_of(server, label)
    return admitted(server, update_of(uuid, value))[0].updates["value"]


def test_sliders_are_cut_and_choices_must_be_there(driven: DrivePage, shown: Viewer) -> None:
    server = server_of(driven)
    assert told(server, "speed limit (m/s)", 1e9) == handle_of(server, "speed limit (m/s)")[1].max
    assert told(server, "speed limit (m/s)", -1) == handle_of(server, "speed limit (m/s)")[1].min
    assert told(server, "gait", "crawl") == "crawl"
    assert told(server, "push to", "left") == "left"
    assert told(shown.server, "steps", 1e6) == 100
    for label, value in [
        ("speed limit (m/s)", math.nan),
        ("height (m)", math.inf),
        ("height (m)", "0"),
        ("gait", "xyz"),
        ("push to", "up"),
        ("keep the robot in the middle", 1),
    ]:
        with pytest.raises(RefusedError, match=r"^" + label.partition(" (")[0]):
            told(server, label, value)
    for label, value in [("scenario", "/etc/passwd.yaml"), ("speed", "9 ×"), ("goal", [0.0, math.nan, 0.0])]:
        with pytest.raises(RefusedError, match=label):
            told(shown.server, label, value)


def test_a_refused_message_leaves_one_line(shown: Viewer, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.WARNING, logger="rollgait")
    uuid, _ = handle_of(shown.server, "scenario")
    with socket_from(shown.server.get_port(), shown.url) as page:
        page.send(update_of(uuid, "/tmp/\x1b[31m\n.yaml"))
        until(lambda: caplog.messages)
    (line,) = caplog.messages
    assert line.isprintable()
    assert "scenario" in line


def test_the_viewer_opens_no_file_that_is_not_of_the_library(shown: Viewer, tmp_path: Any) -> None:
    secret = tmp_path / "secret.yaml"
    secret.write_text("robot: centauro\ngoal: {x: 0.777}\n")
    before = shown.designer.draft.scenario
    for name in (str(secret), str(tmp_path / "missing.yaml"), "no-such"):
        shown.designer.pick(name)
        assert shown.designer.draft.scenario == before
        assert "scenario" in shown.designer.panel.message.content


@pytest.mark.parametrize(
    "request_of_a_page",
    [
        Request(VelocityCommand().model_copy(update={"forward": math.nan})),
        Request(VelocityCommand().model_copy(update={"gait": "xyz"})),
        Request(VelocityCommand().model_copy(update={"height_change": "up"})),
        Request(VelocityCommand(), pull=(math.inf, 0.0, 0.0)),
        Request(VelocityCommand(), pushes=(PushRequest((math.nan, 0.0, 0.0), 0.1),)),
        Request(VelocityCommand(), pushes=(PushRequest((1.0, 0.0, 0.0), math.inf),)),
    ],
)
def test_the_loop_itself_takes_no_request_that_cannot_be(request_of_a_page: Request) -> None:
    with pytest.raises(InputError):
        request_of_a_page.check()
    session = Session(lambda: make_loop("centauro", "rigid", PATIENT))
    session.handle(request_of_a_page)
    session.step()
    after = session.snapshot()
    assert after.mode == "tracking"
    assert "refused" in after.events[-1][1]


def test_pushes_faster_than_they_pass_do_not_add_up() -> None:
    session = Session(lambda: make_loop("centauro", "rigid", PATIENT))
    session.handle(Request(VelocityCommand(), pushes=(PushRequest((100.0, 0.0, 0.0), 0.2),) * 1000))
    session.step()
    assert session.snapshot().pushed[0] <= 500.0


@given(st.tuples(*[st.floats()] * 3), st.tuples(*[st.floats()] * 3), st.floats(1.0, 200.0))
def test_a_pull_is_a_force_wherever_the_mouse_was(begin: Any, end: Any, push: float) -> None:
    assert math.hypot(*pull_of(begin, end, push)) <= PULL_MAX * push * (1.0 + 1e-9)


def drag_of(name: str, phase: str) -> bytes:
    """A page drags a thing in the scene, 1 m along x."""
    begin, end, on_screen = (0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (0.5, 0.5)
    fields = {"start_position": begin, "end_position": end, "instance_index": None}
    on_page = {"start_screen_pos": on_screen, "end_screen_pos": on_screen, "button": "left", "modifier": None}
    message = {"type": "SceneNodeDragMessage", "phase": phase, "name": name, "owner": "", **fields, **on_page}
    return msgspec.msgpack.encode(message)


def test_a_pull_ends_with_the_hand_or_with_its_page_and_never_lasts(driven: DrivePage) -> None:
    server, panel = server_of(driven), driven.panel
    name = driven.scene.grips[0]._impl.name
    with socket_from(server.get_port(), driven.url) as page:
        page.send(msgspec.msgpack.encode(camera()))
        until(server.get_clients)
        page.send(drag_of(name, "start"))
        until(lambda: panel.pull[0] > 0.0)
        for phase in ("end", "update"):  # that comes too late
            page.send(drag_of(name, phase))
        until(lambda: panel.pull == NO_FORCE)
        assert failures_of(server, []) == []  # all is heard
        assert panel.pull == NO_FORCE
        page.send(drag_of(name, "start"))
        until(lambda: panel.pull != NO_FORCE)
    until(lambda: panel.pull == NO_FORCE)


def test_the_panel_asks_for_a_possible_command_whatever_its_controls_say(driven: DrivePage) -> None:
    panel = driven.panel
    before = panel.speed.value, panel.height.value
    try:
        for value in (math.nan, math.inf, -math.inf, 1e9):
            panel.speed._impl.value = panel.height._impl.value = value
            panel._choose("xyz")
            Request(panel.command()).check()
    finally:
        panel.speed.value, panel.height.value = before
