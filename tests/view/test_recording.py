"""Recordings: the page opens offline, asks nobody for anything, and moves; the others are films."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from tests.view.browser import browser, centre, near, needs_chromium, picture, settled, wait_until

from rollgait.cli.app import run  # isort: skip  # the line above skips where viser is absent
from rollgait.scenario import find_scenario  # isort: skip
from rollgait.view.clip import Clip, clip_of_plan  # isort: skip
from rollgait.view.recording import record_page  # isort: skip
from rollgait.view.style import LEG_COLOURS  # isort: skip
from rollgait.view.video import VIDEO_RATE, VIDEO_SIZE, record_gif, record_video, still  # isort: skip
from tests.view.builders import motion_plan  # isort: skip

MEGABYTE = 1_000_000
FR = LEG_COLOURS[1]
CLIP = clip_of_plan(motion_plan(find_scenario("hybrid-forward")), "hybrid <b>forward</b>")
SHORT = clip_of_plan(
    motion_plan(find_scenario("wheeled").with_values({"horizon": 1.0, "goal": {"x": 0.3}})), "short"
)


def go(page: Any, time: str) -> Any:
    """The picture of a recording at a time."""
    box = page.locator("input").first
    box.fill(time)
    box.press("Enter")
    return settled(page)


@pytest.mark.slow
@needs_chromium
def test_the_page_opens_offline_and_moves(tmp_path: Path) -> None:
    file = record_page(CLIP, tmp_path / "motion.html")
    assert file.stat().st_size < 5 * MEGABYTE
    with browser(tmp_path / "profile") as context:
        context.set_offline(True)
        page = context.pages[0]
        asked: list[str] = []
        page.on("request", lambda request: asked.append(request.url))
        page.goto(file.as_uri())
        page.get_by_text("hybrid <b>forward</b>").wait_for()  # a name is text, never markup
        wait_until(lambda: bool(near(picture(page), FR).any()))  # it is drawn, and plays
        page.keyboard.press("Space")
        early, late = near(go(page, "0.5"), FR), near(go(page, "5"), FR)
        assert all(url.startswith(("file:", "data:", "blob:")) for url in asked)
    gone_ahead = (
        centre(late & ~early)[0] - centre(early & ~late)[0]
    )  # without what stands still in this colour
    assert gone_ahead > 40.0  # pixels


def test_a_gif_has_every_moment(tmp_path: Path) -> None:
    film = Image.open(record_gif(SHORT, tmp_path / "short.gif"))
    frames = getattr(film, "n_frames", 1)
    assert frames == 10
    first = np.asarray(film.convert("RGB"), dtype=float)
    film.seek(frames - 1)
    last = np.asarray(film.convert("RGB"), dtype=float)
    film.close()
    assert np.abs(last - first).mean() > 1.0


@pytest.mark.parametrize("ghost", [None, SHORT])
def test_a_film_has_every_moment(ghost: Clip | None, tmp_path: Path) -> None:
    ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="the extra 'video' is not installed")
    file = record_video(SHORT, tmp_path / "short.mp4", ghost)
    count, seconds = ffmpeg.count_frames_and_secs(str(file))
    assert count == round(SHORT.horizon * VIDEO_RATE)
    assert seconds == pytest.approx(SHORT.horizon, abs=1.0 / VIDEO_RATE)
    command = [ffmpeg.get_ffmpeg_exe(), "-v", "error", "-i", file, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    raw = subprocess.run(command, capture_output=True, check=True).stdout
    frames = np.frombuffer(raw, dtype=np.uint8).reshape(-1, VIDEO_SIZE[1], VIDEO_SIZE[0], 3)
    assert len(frames) == count
    before = centre(near(frames[0] / 255.0, FR))
    moved = centre(near(frames[-1] / 255.0, FR)) - before
    assert moved[0] > 20.0  # pixels: forward is to the right


def test_a_film_without_its_extra_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)  # as where it is not installed
    plan = SHORT.plan
    assert plan is not None
    target = tmp_path / "short.mp4"
    assert run(["record", str(plan.save(tmp_path / "plan.npz")), "--out", str(target)]) == 2
    assert "rollgait[video]" in capsys.readouterr().err
    assert not target.exists()


def test_a_picture_shows_all_legs_and_the_goal() -> None:
    image = np.asarray(still(CLIP, 5.0, (640, 360)), dtype=float) / 255.0
    for colour in LEG_COLOURS:
        assert near(image, colour, 0.2).sum() > 20


@pytest.mark.parametrize("name", ["a.avi", "a"])
def test_the_command_refuses_other_formats(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = SHORT.plan
    assert plan is not None
    file = plan.save(tmp_path / "plan.npz")
    assert run(["record", str(file), "--out", str(tmp_path / name)]) == 2
    assert "valid: " in capsys.readouterr().err
    assert not (tmp_path / name).exists()


def test_the_command_writes_a_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan = SHORT.plan
    assert plan is not None
    target = tmp_path / "short.html"
    assert run(["record", str(plan.save(tmp_path / "plan.npz")), "--out", str(target)]) == 0
    assert capsys.readouterr().out == f"{target}\n"
    assert "<title>plan</title>" in target.read_text(encoding="utf-8")
