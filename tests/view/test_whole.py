"""A frame reaches a page whole, whenever it is taken for sending, and however slow the page is."""

from __future__ import annotations

import asyncio
import base64
import io
import threading
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

import numpy as np
import pytest
from PIL import Image

from tests.view.browser import caught_up, centre, near, needs_chromium, seen, wait_until

from viser import _messages as wire  # isort: skip
from viser.infra._async_message_buffer import AsyncMessageBuffer  # isort: skip

from rollgait.scenario import find_scenario  # isort: skip
from rollgait.view.clip import clip_of_plan  # isort: skip
from rollgait.view.style import LEG_COLOURS  # isort: skip
from rollgait.view.viewer import Viewer  # isort: skip
from rollgait.view.whole import Blocks  # isort: skip
from tests.view.builders import motion_plan  # isort: skip

NODES: Final = 300
"""More than viser sends at once."""
FRAMES: Final = 400
SLOW: Final = """(() => {
    const soon = window.requestAnimationFrame.bind(window);
    window.pictures = [];
    const drawn = draw => setTimeout(() => soon(now => {
        draw(now);
        const [scene] = [...document.querySelectorAll('canvas')].sort((a, b) => b.width - a.width);
        const picture = scene.toDataURL();
        if (picture !== window.pictures.at(-1)) window.pictures.push(picture);
    }), 333);
    window.requestAnimationFrame = draw => window.slow ? drawn(draw) : soon(draw);
})()"""
"""Once it is slow: three pictures a second, and all that were drawn."""
PICTURES: Final = 15
"""Of a motion of 3 s that begins again, three a second: all of its way is seen."""
APART: Final = 0.015
"""In heights of the picture: a sixth of the way in a third of a second."""
YELLOW: Final = "#DCC03C"
"""The ball at the CoM, as it is lit."""


@pytest.fixture
def loop() -> Iterator[asyncio.AbstractEventLoop]:
    made = asyncio.new_event_loop()
    thread = threading.Thread(target=made.run_forever)
    thread.start()
    yield made
    made.call_soon_threadsafe(made.stop)
    thread.join()
    made.close()


def test_every_window_leaves_all_nodes_in_one_frame(loop: asyncio.AbstractEventLoop) -> None:
    buffer = AsyncMessageBuffer(loop, persistent_messages=True, window_duration_sec=0.0)
    blocks = Blocks(buffer)
    seen: list[set[float]] = []

    async def take() -> None:
        state: dict[str, float] = {}
        async for window in buffer.window_generator(0):
            for message in window:
                assert isinstance(message, wire.SetPositionMessage)
                state[message.name] = message.position[0]
            seen.append(set(state.values()))
            if state.get("0") == FRAMES - 1:
                return

    taking = asyncio.run_coroutine_threadsafe(take(), loop)
    for frame in range(FRAMES):
        with blocks.block():
            for node in range(NODES):
                buffer.push(wire.SetPositionMessage(str(node), (float(frame), 0.0, 0.0)))
    taking.result(300.0)
    assert len(seen) > 3
    assert all(len(frames) == 1 for frames in seen)


def test_blocks_within_blocks_and_within_the_loop_end(loop: asyncio.AbstractEventLoop) -> None:
    buffer = AsyncMessageBuffer(loop, persistent_messages=True)
    blocks = Blocks(buffer)

    async def inside() -> int:
        with blocks.block():
            return buffer.atomic_counter

    with blocks.block(), blocks.block():
        assert buffer.atomic_counter == 2
    assert asyncio.run_coroutine_threadsafe(inside(), loop).result(300.0) == 1
    with pytest.raises(ZeroDivisionError), blocks.block():
        _ = 1 / 0
    assert asyncio.run_coroutine_threadsafe(inside(), loop).result(300.0) == 1


@pytest.mark.slow
@needs_chromium
def test_a_page_of_three_pictures_a_second_shows_the_base_above_its_feet(sheet: Any) -> None:
    asked = {"goal": {"x": 1.9}, "horizon": 3.0, "interval": 0.25, "profile": "paper"}
    clip = clip_of_plan(motion_plan(find_scenario("wheeled").with_values(asked)), "fast")
    viewer = Viewer(replace(clip, goals=()), port=0)
    try:
        assert viewer.scene is not None
        for title in viewer.scene.layers:
            viewer._switch(title, title in ("robot", "CoM"))
        viewer.designer.handles.gizmo.visible = False  # it is yellow, too
        sheet.add_init_script(SLOW)
        sheet.goto(viewer.url)
        sheet.get_by_text("fast").wait_for()
        seen(sheet, viewer.server)
        sheet.evaluate("window.slow = true")
        still = []
        for time in np.linspace(0.0, 3.0, 7):
            viewer.timeline.go(float(time))
            caught_up(sheet, viewer.server)
            still.append(place_of(sheet.evaluate("window.pictures.at(-1)")))
        sheet.evaluate("window.pictures.length = 0")
        viewer.timeline.play()
        wait_until(lambda: sheet.evaluate("window.pictures.length") >= PICTURES)
        viewer.timeline.pause()
        moving = [place_of(each) for each in sheet.evaluate("window.pictures")]
    finally:
        viewer.close()
    (feet, ahead), (still_feet, still_ahead) = np.array(moving).T, np.array(still).T
    assert np.ptp(feet) > 0.5  # it was seen on its way
    assert np.abs(ahead - np.interp(feet, still_feet, still_ahead)).max() < APART


def place_of(picture: str) -> tuple[float, float]:
    """Of the front wheels on their way to the right, and of the CoM from there, in heights of the picture."""
    image = Image.open(io.BytesIO(base64.b64decode(picture.partition(",")[2]))).convert("RGB")
    seen = np.asarray(image, dtype=float) / 255.0
    feet = np.mean([centre(near(seen, colour))[0] for colour in LEG_COLOURS[:2]])
    size = image.height  # a slow page draws fewer pixels after a while
    return float(feet / size), float((centre(near(seen, YELLOW))[0] - feet) / size)
