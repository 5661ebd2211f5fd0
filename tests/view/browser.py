"""Headless Chromium for the tests of pages. They are skipped where it, Playwright or viser is absent."""

from __future__ import annotations

import io
import itertools
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
SIZE = {"width": 1100, "height": 700}
PANEL = 400
"""Width of the page that the controls may cover, pixels."""
PATIENCE = 300_000
"""A software renderer on a busy machine is slow, and only a test that fails waits for so long; ms."""

pytest.importorskip("viser", reason="the extra 'view' is not installed")
DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
"""Comes when the page has drawn again."""
STILL = 300
"""What has not moved for so long lies still, ms."""
MARKS = itertools.count()

sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

needs_chromium = pytest.mark.skipif(
    CHROMIUM is None, reason="chromium is not installed: apt-get install chromium"
)


@contextmanager
def browser(profile: Path, *flags: str) -> Iterator[Any]:
    """A browser with an empty profile, and with some more flags."""
    with sync_api.sync_playwright() as playwright:
        context = playwright.chromium.launch_persistent_context(
            str(profile), executable_path=CHROMIUM, args=[*FLAGS, *flags], headless=True, viewport=SIZE
        )
        context.set_default_timeout(PATIENCE)
        try:
            yield context
        finally:
            context.close()


def picture(page: Any) -> NDArray[np.float64]:
    """What is seen of the scene, (height, width, 3), 0 to 1, without the controls."""
    image = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    return np.asarray(image, dtype=float)[:, :-PANEL] / 255.0


def near(image: NDArray[np.float64], colour: str, tolerance: float = 0.17) -> NDArray[np.bool_]:
    """Where the picture has about this colour."""
    wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    return np.asarray(np.abs(image - wanted).max(axis=-1) < tolerance)


def centre(mask: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Mean place of what is marked, (x, y), pixels."""
    rows, columns = np.nonzero(mask)
    assert rows.size, "nothing of this colour is seen"
    return np.array([columns.mean(), rows.mean()])


def caught_up(page: Any, server: Any) -> None:
    """Waits until a page has drawn all that its server has said so far: it takes that in its order."""
    mark = f"said-until-{next(MARKS)}"
    handle = server.gui.add_html(f'<span id="{mark}"></span>')
    page.locator(f"#{mark}").wait_for(state="attached")
    handle.remove()
    page.evaluate(DRAWN)


def seen(page: Any, server: Any) -> NDArray[np.float64]:
    """The picture of all that a server has said, once it no longer changes."""
    caught_up(page, server)
    return settled(page)


def settled(page: Any, tries: int = 100) -> NDArray[np.float64]:
    """The picture once it no longer changes; whether all has come that is to be seen says `seen`."""
    before = picture(page)
    for _ in range(tries):
        page.wait_for_timeout(400)
        page.evaluate(DRAWN)
        now = picture(page)
        if np.abs(now - before).max() < 0.02:
            return now
        before = now
    raise AssertionError("the picture does not come to rest")


def at_rest(page: Any, part: Any, lies: Callable[[dict[str, float]], bool] = bool) -> None:
    """Waits until a part of a page lies where it belongs, and still does when the page has drawn again.

    Controls of a phone slide in from below once the page is there.
    """

    def rests() -> bool:
        before = part.bounding_box()
        page.wait_for_timeout(STILL)
        page.evaluate(DRAWN)
        return before is not None and lies(before) and part.bounding_box() == before

    part.wait_for()
    wait_until(rests)


def click(page: Any, part: Any) -> None:
    """Clicks on a part of a page that lies still: a click is lost while what is above it grows or folds."""
    at_rest(page, part)
    part.click()


def wait_until(true: Callable[[], bool], seconds: float = PATIENCE / 1000) -> None:
    """Waits until something is true."""
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "it does not happen"
        time.sleep(0.05)
