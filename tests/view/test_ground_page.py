"""The ground in a browser: in the viewer and in a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.view.browser import needs_chromium, picture, seen, wait_until

from rollgait.scenario import find_scenario  # isort: skip  # the line above skips where viser is absent
from rollgait.terrain import Terrain  # isort: skip
from rollgait.view.clip import clip_of_plan  # isort: skip
from rollgait.view.recording import record_page  # isort: skip
from rollgait.view.viewer import Viewer  # isort: skip
from tests.view.builders import laid_on, motion_plan  # isort: skip

pytestmark = [pytest.mark.slow, needs_chromium]

PLAN = motion_plan(find_scenario("hybrid-forward"))
FLAT = clip_of_plan(PLAN, "flat")
STAIRS = laid_on(
    Terrain.from_parts([{"kind": "stairs", "x": 0.6, "steps": 3, "rise": 0.12, "tread": 0.4}]), FLAT
)


def sand(image: NDArray[np.float64]) -> float:
    """The share of the picture that has the colour of high ground: light, and more red than blue."""
    r, g, b = np.moveaxis(image, -1, 0)
    light = (r > 0.8) & (g > 0.75) & (b > 0.6)
    return float((light & (r - b > 0.04) & (r - b < 0.3)).mean())


def test_the_viewer_shows_the_steps_in_their_colours(sheet: Any) -> None:
    viewer = Viewer(FLAT, port=0)
    try:
        sheet.goto(viewer.url)
        sheet.get_by_text("normal force").wait_for()
        assert sand(seen(sheet, viewer.server)) < 0.02
        viewer.show(STAIRS)
        wait_until(lambda: sand(picture(sheet)) > 0.05)
    finally:
        viewer.close()


def test_a_recording_holds_the_ground(sheet: Any, tmp_path: Path) -> None:
    file = record_page(STAIRS, tmp_path / "stairs.html")
    assert file.stat().st_size < 6_000_000
    sheet.context.set_offline(True)
    sheet.goto(file.as_uri())
    wait_until(lambda: sand(picture(sheet)) > 0.05)
