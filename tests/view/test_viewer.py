"""The page, driven in a browser: open, play, scrub, drag the goal, plan, see the new path."""

from __future__ import annotations

import http.client
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.view.browser import (
    PATIENCE,
    at_rest,
    centre,
    near,
    needs_chromium,
    picture,
    seen,
    settled,
    wait_until,
)

from rollgait.cli.app import run  # isort: skip  # the line above skips where viser is absent
from rollgait.errors import InputError  # isort: skip
from rollgait.plan.plan import Plan  # isort: skip
from rollgait.scenario import find_scenario  # isort: skip
from rollgait.view.clip import clip_of_plan  # isort: skip
from rollgait.view.style import LEG_COLOURS  # isort: skip
from rollgait.view.viewer import Viewer  # isort: skip
from tests.view.builders import motion_plan  # isort: skip

pytestmark = [pytest.mark.slow, needs_chromium]

SCENARIO = find_scenario("wheeled").with_values(
    {"goal": {"x": 0.6}, "horizon": 3.0, "interval": 0.25, "profile": "paper"}
)
FR = LEG_COLOURS[1]
GIZMO_X = "#FF2060"
"""The arrow of the handle on the ground that moves the goal along x."""
TYRE = "#22252A"


@pytest.fixture(scope="module")
def viewer() -> Iterator[Viewer]:
    shown = Viewer(clip_of_plan(motion_plan(SCENARIO), "by hand"), port=0)
    yield shown
    shown.close()


@pytest.fixture(scope="module")
def page(viewer: Viewer, sheet: Any) -> Iterator[Any]:
    asked: list[str] = []
    sheet.on("request", lambda request: asked.append(request.url))
    sheet.goto(viewer.url)
    sheet.get_by_text("by hand").wait_for()
    settled(sheet)
    yield sheet
    assert all(url.startswith((viewer.url, "blob:", "data:")) for url in asked)


def scrub(page: Any, viewer: Viewer, to: float) -> NDArray[np.float64]:
    """Writes a time into the box of the slider; the picture then."""

    def is_there() -> bool:
        """A new motion brings a new box: what was written into the old one is lost."""
        if abs(viewer.timeline.time - to) < 2e-3:
            return viewer.scene is not None and viewer.scene.index == viewer.clip.frame(to)
        box = page.locator("input[inputmode=decimal]").first
        box.fill(f"{to:g}")
        box.press("Enter")
        page.wait_for_timeout(100)
        return False

    wait_until(is_there)
    return seen(page, viewer.server)


def test_scrubbing_moves_the_robot_along_its_path(page: Any, viewer: Viewer) -> None:
    start = scrub(page, viewer, 0.0)
    end = scrub(page, viewer, 3.0)
    again = scrub(page, viewer, 0.0)
    assert np.abs(again - start).mean() < 0.3 * np.abs(end - start).mean()  # the same time looks the same
    moved = centre(near(end, FR)) - centre(near(start, FR))
    assert moved[0] > 40.0  # pixels, to the right: forward


def test_play_moves_it_and_pause_stops_it(page: Any, viewer: Viewer) -> None:
    still = scrub(page, viewer, 0.0)

    def is_on_its_way() -> bool:
        """At its end it begins again, and a slow browser may be late with its click."""
        page.get_by_role("button", name="Play", exact=True).click()
        wait_until(lambda: viewer.timeline.time > 1.0)
        page.get_by_role("button", name="Pause", exact=True).click()
        wait_until(lambda: not viewer.timeline.playing)
        return viewer.timeline.time > 1.0

    wait_until(is_on_its_way)
    now = seen(page, viewer.server)
    assert centre(near(now, FR))[0] > centre(near(still, FR))[0] + 10.0
    time_then = viewer.timeline.time
    page.wait_for_timeout(300)
    assert viewer.timeline.time == time_then


def test_a_mark_goes_to_its_moment(page: Any, viewer: Viewer) -> None:
    page.get_by_role("tab", name="Certificate").click()
    mark = viewer.clip.marks[0]
    page.get_by_role("button", name=mark.label).click()
    wait_until(lambda: abs(viewer.timeline.time - min(mark.time, viewer.clip.horizon)) < 1e-3)


def test_a_layer_can_be_switched_off(page: Any, viewer: Viewer) -> None:
    scrub(page, viewer, 1.5)
    page.get_by_role("tab", name="Layers").click()
    full = seen(page, viewer.server)
    assert viewer.scene is not None
    root = viewer.scene.layers["robot"].root
    switch = page.get_by_label("robot", exact=True)
    switch.click()
    wait_until(lambda: not root.visible)
    assert near(seen(page, viewer.server), TYRE).sum() < 0.3 * near(full, TYRE).sum()
    switch.click()
    wait_until(lambda: root.visible)


def test_drag_the_goal_plan_and_see_the_new_path(page: Any, viewer: Viewer, tmp_path: Path) -> None:
    scrub(page, viewer, 0.0)
    page.get_by_role("tab", name="Design").click()
    wait_until(lambda: near(picture(page), GIZMO_X, 0.25).any())
    before = seen(page, viewer.server)
    x, y = centre(near(before, GIZMO_X, 0.25))
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 30, y + 8, steps=6)
    page.mouse.move(x + 60, y + 16, steps=6)
    page.mouse.up()
    wait_until(lambda: viewer.designer.draft.scenario.goal.x > 0.65)
    wanted = viewer.designer.draft.scenario.goal.x
    assert viewer.designer.panel.places.goal.value[0] == wanted
    assert viewer.designer.draft.scenario.goal.y == pytest.approx(0.0, abs=0.02)  # along x only
    page.get_by_role("button", name="Plan", exact=True).click()
    wait_until(lambda: viewer.clip.name == "by hand, planned")
    page.get_by_text("solved in").wait_for()
    assert viewer.clip.plan is not None
    assert viewer.clip.plan.scenario.goal.x == pytest.approx(wanted)
    assert viewer.clip.samples.com_position[-1, 0] == pytest.approx(wanted, abs=0.05)
    viewer.timeline.pause()
    end = scrub(page, viewer, 3.0)
    assert np.abs(end - before).mean() > 0.005
    page.get_by_role("tab", name="Files").click()
    with page.expect_download() as download:
        page.get_by_role("button", name="Save plan").click()
    saved = tmp_path / "saved.npz"
    download.value.save_as(saved)
    assert Plan.load(saved).scenario == viewer.clip.plan.scenario


def test_what_cannot_be_planned_is_said(page: Any, viewer: Viewer) -> None:
    page.get_by_role("tab", name="Design").click()
    viewer.designer.change({"horizon": 0.6, "gait.kind": "crawl"})
    shown = viewer.clip

    def is_said() -> bool:
        """While an earlier plan is being put away nothing is planned."""
        page.get_by_role("button", name="Plan", exact=True).click()
        page.wait_for_timeout(200)
        return bool(page.get_by_text("needs a horizon longer").is_visible())

    wait_until(is_said)
    assert viewer.clip is shown


def test_what_is_in_the_way_is_said_and_what_would_help_can_be_taken_up(page: Any, viewer: Viewer) -> None:
    weak = {"bounds": {"force_max": 100.0}, "horizon": 1.5, "goal": {"x": 0.2}, "profile": "executable"}
    viewer.show(clip_of_plan(motion_plan(SCENARIO.with_values(weak)), "too weak to stand"))
    shown = viewer.clip
    page.get_by_role("tab", name="Design").click()
    page.get_by_role("button", name="Plan", exact=True).click()
    page.get_by_text("In the way:").wait_for()
    page.get_by_text("the normal force would have to leave its limits").first.wait_for()
    assert viewer.clip is shown
    page.get_by_role("button", name="larger forces").click()
    wait_until(lambda: viewer.designer.draft.scenario.bounds.force_max > 100.0)
    page.get_by_text("In the way:").wait_for(state="hidden")
    page.get_by_role("button", name="Plan", exact=True).click()
    wait_until(lambda: viewer.clip is not shown)
    page.get_by_text("solved in").wait_for()
    wait_until(lambda: viewer.timeline.playing)
    assert viewer.clip.passed
    viewer.timeline.pause()


def test_a_second_browser_sees_the_same_and_may_leave_during_a_solve(page: Any, viewer: Viewer) -> None:
    viewer.designer.pick(viewer.designer.panel.picker.options[-1])
    shown = viewer.clip
    second = page.context.new_page()
    try:
        second.goto(viewer.url)
        second.get_by_text(shown.name).first.wait_for()
        scrub(page, viewer, 0.75)
        box = second.locator("input[inputmode=decimal]").first
        wait_until(lambda: abs(float(box.input_value()) - 0.75) < 0.01)
        second.get_by_role("tab", name="Design").click()
        second.get_by_role("button", name="Plan", exact=True).click()
        wait_until(lambda: viewer.planning.busy or viewer.clip is not shown)
    finally:
        second.close()
    wait_until(lambda: viewer.clip is not shown)
    page.get_by_text("solved in").wait_for()
    page.get_by_role("button", name="Pause", exact=True).click()
    scrub(page, viewer, 0.5)


@pytest.mark.parametrize(("content", "said"), [("no plan", "is neither a plan"), ("newer", "version")])
def test_an_uploaded_file_that_cannot_be_shown_is_refused(
    page: Any, viewer: Viewer, tmp_path: Path, content: str, said: str
) -> None:
    path = tmp_path / "mine.npz"
    if content == "newer":
        motion_plan(SCENARIO).save(path)
        with np.load(path) as data:
            arrays = {key: data[key] for key in data.files}
        header = json.loads(str(arrays["header"])) | {"version": 99}
        np.savez(path, **(arrays | {"header": np.array(json.dumps(header))}))
    else:
        path.write_text(content)
    shown = viewer.clip
    page.get_by_role("tab", name="Files").click()
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Open a plan, joints, a log or a scenario").click()
    chooser.value.set_files(path)
    note = page.get_by_text(said)
    note.wait_for()
    assert "mine.npz" in note.inner_text()
    assert str(tmp_path) not in note.inner_text()
    assert viewer.clip is shown


def test_a_saved_scenario_is_short_and_can_be_opened_again(page: Any, viewer: Viewer, tmp_path: Path) -> None:
    viewer.show(clip_of_plan(motion_plan(SCENARIO), "by hand"))
    page.get_by_role("tab", name="Files").click()
    wanted = viewer.designer.draft.scenario.resolved()
    with page.expect_download() as download:
        page.get_by_role("button", name="Save scenario").click()
    assert download.value.suggested_filename == "by-hand.yaml"
    saved = tmp_path / "mine.yaml"
    download.value.save_as(saved)
    assert len(saved.read_text().splitlines()) < 25
    assert "robot: centauro\n" in saved.read_text()
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Open a plan, joints, a log or a scenario").click()
    chooser.value.set_files(saved)
    wait_until(lambda: viewer.clip.name == "mine")
    page.get_by_text("nothing is planned yet").wait_for()
    assert viewer.designer.draft.scenario.resolved().to_yaml() == wanted.to_yaml()


def test_a_scenario_from_a_page_names_no_file_of_this_machine(
    page: Any, viewer: Viewer, tmp_path: Path
) -> None:
    path = tmp_path / "evil.yaml"
    path.write_text("robot: /etc/robots/secret.yaml\ngoal: {x: 1}\n")
    shown = viewer.clip
    page.get_by_role("tab", name="Files").click()
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Open a plan, joints, a log or a scenario").click()
    chooser.value.set_files(path)
    page.get_by_text("names a file").wait_for()
    assert viewer.clip is shown


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_phone_has_controls_of_its_own_width_in_its_own_colours(
    page: Any, viewer: Viewer, scheme: str
) -> None:
    viewer.show(clip_of_plan(motion_plan(SCENARIO), "by hand"))
    phone = page.context.new_page()
    try:
        phone.set_viewport_size({"width": 390, "height": 844})
        phone.emulate_media(color_scheme=scheme)
        phone.goto(viewer.url)
        phone.get_by_text(viewer.clip.name).first.wait_for()
        assert phone.title() == "rollgait"
        button = phone.get_by_role("button", name="Play", exact=True)
        # the upper half is the picture's
        at_rest(phone, button, lambda box: box["width"] > 350 and box["y"] > 420)
        background = phone.evaluate("getComputedStyle(document.body).backgroundColor")
        brightness = sum(int(part) for part in re.findall(r"\d+", background)[:3]) / 3.0
        assert (brightness < 100.0) == (scheme == "dark")
    finally:
        phone.close()


def test_head_is_answered_like_get_without_its_body(viewer: Viewer) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", viewer.server.get_port(), timeout=PATIENCE / 1000)
    try:
        connection.request("HEAD", "/")
        answer = connection.getresponse()
        assert (answer.status, answer.read()) == (200, b"")
        assert int(answer.headers["Content-Length"]) > 100_000
    finally:
        connection.close()


def test_a_port_in_use_is_refused(viewer: Viewer, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    port = viewer.server.get_port()
    with pytest.raises(InputError, match="in use"):
        Viewer(viewer.clip, port=port)
    plan = motion_plan(SCENARIO).save(tmp_path / "plan.npz")
    assert run(["view", str(plan), "--port", str(port)]) == 2
    assert "in use" in capsys.readouterr().err
