"""A terrain of one's own in the browser: designed, planned, saved, opened again, exported."""

from __future__ import annotations

import csv
import io
import json
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from tests.view.browser import SIZE, STILL, at_rest, caught_up, click, near, needs_chromium, seen, wait_until

from rollgait.plan.plan import Plan  # isort: skip  # the line above skips where viser is absent
from rollgait.scenario import Scenario, find_scenario  # isort: skip
from rollgait.view.design.handles import SIZE as HANDLE  # isort: skip
from rollgait.view.design.handles import Selection  # isort: skip
from rollgait.view.rotations import matrix_from_quaternion  # isort: skip
from rollgait.view.scene import Scene  # isort: skip
from rollgait.view.standing_clip import clip_of_scenario  # isort: skip
from rollgait.view.style import GOAL_COLOUR  # isort: skip
from rollgait.view.viewer import Viewer  # isort: skip
from tests.view.builders import motion_plan  # isort: skip
from rollgait.view.clip import clip_of_plan  # isort: skip

pytestmark = [pytest.mark.slow, needs_chromium]

BASE = find_scenario("wheeled")
TYPED = {"horizon (s)": ["1", "12"], "steps": ["7", "6"]}
"""Digit by digit, where one digit alone would be another number."""
IN_ONE_GO = """(typed) => {
  const write = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  for (const [label, texts] of typed) {
    const found = [...document.querySelectorAll("label")].find((each) => each.textContent === label);
    const box = document.getElementById(found.htmlFor);
    box.focus();
    for (const text of texts) {
      write.call(box, text);
      box.dispatchEvent(new Event("input", { bubbles: true }));
    }
  }
  document.activeElement.blur();
}"""
"""As a page does that had something else to do meanwhile."""
OPEN = "Open a plan, joints, a log or a scenario"


@pytest.fixture
def viewer() -> Iterator[Viewer]:
    shown = Viewer(clip_of_scenario(BASE, "wheeled"), port=0)
    yield shown
    shown.close()


@pytest.fixture
def page(viewer: Viewer, sheet: Any) -> Any:
    sheet.goto(viewer.url)
    sheet.get_by_role("tab", name="Design").wait_for()
    return sheet


def press(page: Any, name: str) -> None:
    click(page, page.get_by_role("button", name=name, exact=True))


def fold(page: Any, name: str) -> None:
    """Opens a folder of the panel."""
    click(page, page.get_by_text(name, exact=True).first)


def written(page: Any, label: str, value: str) -> None:
    """Writes into the box beside a label."""
    box = page.get_by_label(label, exact=True)
    box.fill(value)
    box.press("Enter")


def triple(page: Any, label: str, values: tuple[float, float, float]) -> None:
    """Writes into the three boxes beside a label."""
    beside = page.get_by_text(label, exact=True).first
    beside.wait_for()
    row = beside.locator("xpath=ancestor::*[count(.//input) = 3][1]")
    for box, value in zip(row.locator("input").all(), values, strict=True):
        box.fill(f"{value:g}")
        box.press("Enter")


def pick(page: Any, label: str, option: str) -> None:
    """Takes a choice of a list."""
    wanted = page.get_by_role("option", name=option, exact=True)

    def is_open() -> bool:
        if not wanted.is_visible():  # a list closes where the panel moves below it
            click(page, page.get_by_label(label, exact=True).locator("visible=true").first)
            page.wait_for_timeout(STILL)
        return bool(wanted.is_visible())

    wait_until(is_open)
    wanted.click()


def upload(page: Any, button: str, file: Path) -> None:
    with page.expect_file_chooser() as chooser:
        press(page, button)
    chooser.value.set_files(file)


def download(page: Any, button: str, folder: Path) -> Path:
    with page.expect_download() as found:
        press(page, button)
    path = folder / found.value.suggested_filename
    found.value.save_as(path)
    return path


def test_a_terrain_is_designed_planned_saved_opened_again_and_exported(
    page: Any, viewer: Viewer, tmp_path: Path
) -> None:
    def draft() -> Scenario:
        return viewer.designer.draft.scenario

    viewer.designer.change({"goal.x": 1.5, "goal.y": 0.0, "goal.yaw_deg": 0.0, "horizon": 16.0})
    fold(page, "ground")
    press(page, "ramp")
    wait_until(lambda: len(draft().ground.parts) == 1)
    page.get_by_text("must not be where").wait_for()  # the goal stands astride of the ramp's end
    written(page, "length (m)", "3")
    wait_until(lambda: draft().ground.parts[0].length == 3.0)
    page.get_by_text("must not be where").wait_for(state="hidden")
    press(page, "block")
    wait_until(lambda: len(draft().ground.parts) == 2)
    page.keyboard.press("Control+z")
    wait_until(lambda: len(draft().ground.parts) == 1)
    press(page, "↷ redo")
    wait_until(lambda: len(draft().ground.parts) == 2)
    pick(page, "part", "2  block")
    click(page, page.get_by_text("take away").last)
    wait_until(lambda: len(draft().ground.parts) == 1)
    wait_until(lambda: viewer.designer.selected == Selection("part", 0))
    assert viewer.clip.terrain.height(2.0, 0.0) > 0.03  # the scene stands on what was designed
    designed = draft().resolved()

    press(page, "Plan")
    wait_until(lambda: viewer.clip.plan is not None)
    page.get_by_text("certified", exact=True).wait_for()
    plan = viewer.clip.plan
    assert plan is not None
    assert plan.certificate().passed
    press(page, "Pause")

    page.get_by_role("tab", name="Files").click()
    saved = download(page, "Save scenario", tmp_path)
    assert Scenario.from_yaml(saved).resolved() == designed
    assert Plan.load(download(page, "Save plan", tmp_path)).scenario == plan.scenario
    table = download(page, "Export", tmp_path)
    rows = list(csv.DictReader(io.StringIO(table.read_text())))
    assert float(rows[-1]["com_x"]) == pytest.approx(1.5, abs=0.05)
    pick(page, "format", "json")
    assert json.loads(download(page, "Export", tmp_path).read_text())["format"] == "rollgait-motion"
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    press(page, "Copy as Python")
    page.get_by_text("Copied").wait_for()
    names: dict[str, Any] = {}
    wait_until(lambda: "plan = " in page.evaluate("navigator.clipboard.readText()"))
    exec(page.evaluate("navigator.clipboard.readText()").partition("plan = ")[0], names)
    assert names["scenario"].resolved() == designed

    page.get_by_role("tab", name="Design").click()
    pick(page, "scenario", "hybrid-forward")
    wait_until(lambda: draft() == find_scenario("hybrid-forward"))
    page.get_by_role("tab", name="Files").click()
    upload(page, OPEN, saved)
    wait_until(lambda: draft().resolved() == designed)
    page.get_by_text("nothing is planned yet").wait_for()
    assert viewer.clip.terrain.height(2.0, 0.0) > 0.03


def seen_at(viewer: Viewer, point: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where a point of the world (3,), m, is in the window, pixels."""
    (client,) = viewer.server.get_clients().values()
    camera = client.camera
    R_world_camera = matrix_from_quaternion(np.roll(camera.wxyz, -1))  # x right, y down, z ahead
    x, y, z = R_world_camera.T @ (point - camera.position)
    focal = 0.5 * SIZE["height"] / np.tan(0.5 * camera.fov)
    middle = 0.5 * SIZE["height"] * np.array([camera.aspect, 1.0])
    return middle + focal * np.array([x, y]) / z


def test_a_handle_drags_goals_and_start_and_parts(page: Any, viewer: Viewer) -> None:
    press(page, "add")
    wait_until(lambda: viewer.designer.selected == Selection("goal", 1))
    fold(page, "ground")
    press(page, "block")
    wait_until(lambda: viewer.designer.selected == Selection("part", 0))
    for what in (Selection("goal", 1), Selection("goal", 0), Selection("part", 0), Selection("start")):
        viewer.designer.select(what)
        seen(page, viewer.server)
        before = what.of(viewer.designer.draft.scenario)
        gizmo = viewer.designer.handles.gizmo
        at, ahead = np.array(gizmo.position), matrix_from_quaternion(np.roll(gizmo.wxyz, -1))[:, 0]
        page.mouse.move(*seen_at(viewer, at + 0.5 * HANDLE * ahead))
        page.mouse.down()
        for way in (0.6, 0.8, 1.0):
            page.mouse.move(*seen_at(viewer, at + way * HANDLE * ahead), steps=3)
        page.mouse.up()

        def moved(what: Selection = what, before: Any = before, ahead: Any = ahead) -> bool:
            now = what.of(viewer.designer.draft.scenario)
            return bool(ahead[:2] @ [now.x - before.x, now.y - before.y] > 0.1)

        wait_until(moved)
        viewer.designer.step_back()
        assert what.of(viewer.designer.draft.scenario) == before  # a drag is one change


def test_a_map_is_uploaded_and_saved_with_its_scenario(page: Any, viewer: Viewer, tmp_path: Path) -> None:
    x, y = np.meshgrid(np.linspace(-3.0, 3.0, 121), np.linspace(-3.0, 3.0, 121), indexing="ij")
    np.save(tmp_path / "hills.npy", 0.02 * np.sin(2.0 * x) * np.cos(y))
    fold(page, "ground")
    fold(page, "a map of your own")
    upload(page, "Upload a map", tmp_path / "hills.npy")
    wait_until(lambda: viewer.designer.draft.scenario.ground.map is not None)
    wait_until(lambda: viewer.clip.terrain.map is not None)
    page.get_by_role("tab", name="Files").click()
    saved = download(page, "Save scenario", tmp_path)
    assert sorted(zipfile.ZipFile(saved).namelist()) == ["hills.npy", "wheeled.yaml"]
    heights = viewer.designer.draft.scenario.ground.heights
    assert heights is not None
    page.get_by_role("tab", name="Design").click()
    press(page, "↶ undo")
    wait_until(lambda: viewer.designer.draft.scenario == BASE)
    page.get_by_role("tab", name="Files").click()
    upload(page, OPEN, saved)
    wait_until(lambda: viewer.designer.draft.scenario.ground.map is not None)
    again = viewer.designer.draft.scenario.ground.heights
    assert again is not None
    assert again.digest == heights.digest
    (tmp_path / "broken.npy").write_bytes(b"\x93NUMPY")
    page.get_by_role("tab", name="Design").click()
    upload(page, "Upload a map", tmp_path / "broken.npy")
    page.get_by_text("broken.npy").first.wait_for()
    assert viewer.designer.draft.scenario.ground.heights is again


def test_loads_boxes_and_terms_left_out_are_designed_saved_and_opened_again(
    page: Any, viewer: Viewer, tmp_path: Path
) -> None:
    def draft() -> Scenario:
        return viewer.designer.draft.scenario

    fold(page, "loads")
    press(page, "payload")
    wait_until(lambda: len(draft().loads.payload) == 1)
    wait_until(lambda: "loads" in scene_of(viewer).layers)  # a box on the robot
    written(page, "mass (kg)", "20")
    wait_until(lambda: draft().loads.payload[0].mass == 20.0)
    triple(page, "carried at", (0.1, 0.15, 0.3))
    wait_until(lambda: draft().loads.payload[0].at == (0.1, 0.15, 0.3))
    assert draft().body.mass == pytest.approx(BASE.body.mass + 20.0)
    triple(page, "carried at", (9.0, 0.15, 0.3))
    page.get_by_text("loads.payload").first.wait_for()  # it would fall over: said, and not done
    assert draft().loads.payload[0].at == (0.1, 0.15, 0.3)
    press(page, "pull")
    wait_until(lambda: len(draft().loads.wrench) == 1)
    triple(page, "force (N)", (-100.0, 5.0, 0.0))
    wait_until(lambda: draft().loads.wrench[0].force == (-100.0, 5.0, 0.0))
    pick(page, "axes", "world")
    written(page, "acts until (s)", "2")
    wait_until(lambda: draft().loads.wrench[0].end == 2.0)
    written(page, "acts until (s)", "0")
    wait_until(lambda: draft().loads.wrench[0].end is None)
    press(page, "pull")
    wait_until(lambda: len(draft().loads.wrench) == 2)
    press(page, "Take this load away")
    wait_until(lambda: len(draft().loads.wrench) == 1)
    fold(page, "loads")

    fold(page, "bounds")
    pick(page, "more", "box")
    wait_until(lambda: draft().bounds.box == BASE.body.box)
    triple(page, "box", (0.2, 0.15, 0.1))
    wait_until(lambda: draft().bounds.box == (0.2, 0.15, 0.1))
    fold(page, "bounds")
    fold(page, "constraints left out")
    pick(page, "without", "com_margin")
    wait_until(lambda: draft().bounds.without == ("com_margin",))
    pick(page, "without", "reach")
    wait_until(lambda: draft().bounds.without == ("com_margin", "reach"))
    click(page, page.get_by_label("without com_margin"))
    wait_until(lambda: draft().bounds.without == ("reach",))
    press(page, "↶ undo")
    wait_until(lambda: draft().bounds.without == ("com_margin", "reach"))

    designed = draft()
    page.get_by_role("tab", name="Files").click()
    saved = download(page, "Save scenario", tmp_path)
    viewer.designer.pick("hybrid-forward")
    assert draft() == find_scenario("hybrid-forward")
    upload(page, OPEN, saved)
    wait_until(lambda: draft().to_dict() == designed.to_dict())


def scene_of(viewer: Viewer) -> Scene:
    assert viewer.scene is not None
    return viewer.scene


def test_two_runs_are_compared_side_by_side(page: Any, viewer: Viewer) -> None:
    short = {"goal": {"x": 0.6}, "horizon": 3.0, "interval": 0.25, "profile": "paper"}
    plan = motion_plan(BASE.with_values(short))
    viewer.show(clip_of_plan(plan, "first"))
    slower = plan.scenario.with_values({"horizon": 4.0})
    viewer.show(clip_of_plan(motion_plan(slower), "second"))
    page.get_by_role("tab", name="Runs").click()
    pick(page, "compared with", "1  first")
    wait_until(lambda: viewer.ghost is not None and viewer.ghost.clip.name == "first")
    page.get_by_text("asked differently").wait_for()
    row = page.get_by_role("row", name="horizon")
    assert row.inner_text().split() == ["horizon", "4", "3"]
    click(page, page.get_by_label("side by side"))
    wait_until(lambda: viewer.ghost is not None and viewer.ghost.root.position[1] > 0.5)
    pick(page, "shown", "1  first")
    wait_until(lambda: viewer.clip.name == "first" and viewer.ghost is None)
    viewer.server.in_order.submit(lambda: None).result()
    caught_up(page, viewer.server)  # the panel has grown shorter: a click while it does so is lost
    press(page, "Forget this run")
    wait_until(lambda: len(viewer.runs) == 1)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_phone_shows_design_and_goal_in_its_colours(page: Any, viewer: Viewer, scheme: str) -> None:
    phone = page.context.new_page()
    try:
        phone.set_viewport_size({"width": 390, "height": 844})
        phone.emulate_media(color_scheme=scheme)
        phone.goto(viewer.url)
        button = phone.get_by_role("button", name="Plan", exact=True)
        # in the lower half, without scrolling
        at_rest(phone, button, lambda box: box["width"] > 350 and 420 < box["y"] < 700)
        wide = phone.evaluate("document.documentElement.scrollWidth")
        assert wide <= 390

        def goal_is_seen() -> bool:
            image = Image.open(io.BytesIO(phone.screenshot())).convert("RGB")
            return bool(near(np.asarray(image, dtype=float)[:420] / 255.0, GOAL_COLOUR, 0.25).sum() > 50)

        wait_until(goal_is_seen)  # as soon as it is drawn
    finally:
        phone.close()


def test_numbers_that_a_slow_page_takes_in_one_go_all_count(page: Any, viewer: Viewer) -> None:
    viewer.designer.pick("hybrid-forward")
    for label in TYPED:
        page.get_by_label(label, exact=True).locator("visible=true").first.wait_for()
    page.evaluate(IN_ONE_GO, list(TYPED.items()))

    def all_count() -> bool:
        draft = viewer.designer.draft.scenario
        return (draft.horizon, getattr(draft.gait, "steps", 0)) == (12.0, 6)

    wait_until(all_count)


def test_keys_are_told(page: Any) -> None:
    page.get_by_text("keys and mouse").click()
    page.get_by_text("play, pause").wait_for()
    page.get_by_text("undo, redo").wait_for()
