"""The page, driven in a browser by keys, buttons and the mouse."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.view.browser import centre, near, needs_chromium, picture, wait_until

pytest.importorskip("mujoco", reason="needs the extra whole-body")
pytest.importorskip("pinocchio", reason="needs the extra whole-body")

from rollgait.mpc.gaits import GAITS  # isort: skip
from rollgait.mpc.log import MpcLog  # isort: skip
from rollgait.mpc.plans.manoeuvres import manoeuvres_of  # isort: skip
from rollgait.robot.library import find_robot  # isort: skip
from rollgait.view.driving.page import DrivePage  # isort: skip
from rollgait.view.driving.process import Setup  # isort: skip
from rollgait.view.opening import open_clip  # isort: skip
from rollgait.view.style import LEG_COLOURS  # isort: skip

pytestmark = [pytest.mark.slow, needs_chromium]

GAMEPAD = """navigator.getGamepads = () => {
    const { axes, pressed } = window;
    return axes ? [{ connected: true, axes, buttons: [{}, { pressed }] }] : [];
}"""
"""A browser in a test has no gamepad: this one is moved by the test."""
HELD = 2000
"""How long a key is held, ms."""
DRIVEN = 0.8
"""How far the robot drives at least, m: about 40 pixels, however slow the machine."""
ON_THE_BODY = (350, 250)
"""Place of the robot's body in the window at first, pixels."""


@pytest.fixture(scope="module")
def drive() -> Iterator[DrivePage]:
    page = DrivePage(
        Setup("centauro", "mujoco", "drive", manoeuvres=manoeuvres_of(find_robot("centauro"))), port=0
    )
    yield page
    page.close()


@pytest.fixture(scope="module")
def page(drive: DrivePage, sheet: Any) -> Any:
    sheet.add_init_script(GAMEPAD)
    sheet.goto(drive.url)
    sheet.get_by_text("real time").wait_for()
    joystick(sheet).get_by_text("connected", exact=True).wait_for()
    wait_until(lambda: near(picture(sheet), LEG_COLOURS[1]).sum() > 500)
    return sheet


def joystick(page: Any) -> Any:
    return page.frame_locator("iframe[title=joystick]")


def middle(page: Any, name: str) -> tuple[float, float]:
    """Of a handle of the joystick, pixels in the window; brought into sight, as other tests scroll."""
    handle = joystick(page).get_by_label(name)
    handle.scroll_into_view_if_needed()
    box = handle.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def place(drive: DrivePage) -> np.ndarray:
    return drive.snapshot.state.com_position.copy()


def comes_to_rest(drive: DrivePage) -> None:
    """For half a second of the robot's: on its way to rest it may sway."""
    wait_until(lambda: drive.hands.wish.rests and max(map(abs, drive.snapshot.wanted)) == 0.0)
    since = drive.snapshot.state.time

    def rests() -> bool:
        nonlocal since
        now = drive.snapshot
        if max(map(abs, now.actual)) >= 0.03:
            since = now.state.time
        return bool(now.state.time > since + 0.5)

    wait_until(rests)


@contextmanager
def stopped(drive: DrivePage) -> Iterator[None]:
    """What is held counts no more once the page has said stop; a slow page may have been silent before."""
    stops = drive.hands.stops
    yield
    wait_until(lambda: drive.hands.stops > stops)
    assert drive.hands.wish.rests
    time.sleep(0.3)
    assert drive.hands.wish.rests  # though it is still held


@contextmanager
def pushes_on(drive: DrivePage) -> Iterator[list[Any]]:
    """The pushes that the loop is asked for meanwhile: a busy machine may miss to see one act."""
    asked: list[Any] = []
    take = drive.panel.take

    def watched(yaw: float) -> Any:
        pushes, reset = take(yaw)
        asked.extend(np.array(push.force) for push in pushes)
        return pushes, reset

    drive.panel.take = watched  # type: ignore[method-assign]
    try:
        yield asked
    finally:
        drive.panel.take = take  # type: ignore[method-assign]


def test_w_drives_forward_and_letting_go_stops_it(page: Any, drive: DrivePage) -> None:
    page.get_by_label("keep the robot in the middle").click()
    wait_until(lambda: not drive.scene.follows)
    before, begin = picture(page), place(drive)
    page.keyboard.down("w")
    page.wait_for_timeout(HELD)
    wait_until(lambda: place(drive)[0] > begin[0] + DRIVEN)
    page.keyboard.up("w")
    comes_to_rest(drive)
    rest = place(drive)
    page.wait_for_timeout(500)
    assert np.abs(place(drive) - rest).max() < 0.02
    origin = centre(near(before, LEG_COLOURS[1]))

    def has_moved() -> bool:
        """Pixels: the camera looks from behind on the right, so forward is right and up."""
        leg = near(picture(page), LEG_COLOURS[1])
        if not leg.any():
            return False
        right, down = centre(leg) - origin
        return bool(right > 15.0 and down < -5.0)

    wait_until(has_moved)  # a slow browser shows it later
    page.get_by_label("keep the robot in the middle").click()
    wait_until(lambda: drive.scene.follows)


def test_the_joystick_drives_to_the_left_and_the_lever_turns(page: Any, drive: DrivePage) -> None:
    x, y = middle(page, "joystick")
    begin = place(drive)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 60, y, steps=3)
    wait_until(lambda: drive.hands.wish.lateral > 0.95)
    wait_until(lambda: place(drive)[1] > begin[1] + 0.1)
    page.mouse.up()
    comes_to_rest(drive)
    x, y = middle(page, "lever")
    yaw = float(drive.snapshot.state.euler[0])
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 60, y, steps=3)
    wait_until(lambda: float(drive.snapshot.state.euler[0]) > yaw + 0.1)
    page.mouse.up()
    comes_to_rest(drive)


def test_space_stops_what_is_held(page: Any, drive: DrivePage) -> None:
    page.keyboard.down("s")
    wait_until(lambda: drive.hands.wish.forward == -1.0)
    with stopped(drive):
        page.keyboard.press("Space")
    page.keyboard.up("s")
    comes_to_rest(drive)


def test_a_button_changes_the_gait_and_feet_leave_the_ground(page: Any, drive: DrivePage) -> None:
    page.get_by_role("button", name="crawl").click()
    wait_until(lambda: drive.snapshot.gait == "crawl")
    wait_until(lambda: not drive.snapshot.contact.all())
    page.get_by_role("button", name="drive").click()
    wait_until(lambda: drive.snapshot.gait == "drive")
    wait_until(lambda: bool(drive.snapshot.contact.all()))


def test_the_push_button_and_a_click_on_the_body_push(page: Any, drive: DrivePage) -> None:
    with pushes_on(drive) as asked:
        page.get_by_role("button", name="Push").click()
        wait_until(lambda: bool(asked))
    assert np.linalg.norm(asked[0]) == pytest.approx(100.0)
    wait_until(lambda: not drive.snapshot.pushed.any())
    with pushes_on(drive) as asked:
        page.mouse.click(*ON_THE_BODY)
        wait_until(lambda: bool(asked))
    x, y, z = asked[0]
    assert x > 0.0  # away from the camera, which stands behind the robot on its right
    assert y > 0.0
    assert z == 0.0
    wait_until(lambda: not drive.snapshot.pushed.any() and drive.snapshot.mode == "tracking")


def test_a_manoeuvre_is_planned_carried_out_and_stopped_by_a_key(page: Any, drive: DrivePage) -> None:
    begin = place(drive)
    page.get_by_role("button", name="Climb what is ahead").click()
    wait_until(lambda: "following" in drive.snapshot.manoeuvre)
    wait_until(lambda: np.hypot(*(place(drive) - begin)[:2]) > 0.1)
    page.keyboard.press("Space")
    wait_until(lambda: drive.snapshot.manoeuvre == "")
    comes_to_rest(drive)
    wait_until(lambda: drive.snapshot.mode == "tracking")


def test_a_gamepad_drives_and_stops(page: Any, drive: DrivePage) -> None:
    page.evaluate("window.axes = [0.05, -1, 0, 0]; window.pressed = false")
    wait_until(lambda: drive.hands.wish.forward == 1.0)
    joystick(page).get_by_text("connected, gamepad").wait_for()
    page.evaluate("window.axes = [0, 0, -1, 0]")
    wait_until(lambda: drive.hands.wish.turn == 1.0 and drive.hands.wish.forward == 0.0)
    with stopped(drive):
        page.evaluate("window.pressed = true")
    page.evaluate("window.axes = null")
    joystick(page).get_by_text("connected", exact=True).wait_for()
    comes_to_rest(drive)


def test_a_run_is_paused_recorded_and_saved(page: Any, drive: DrivePage, tmp_path: Path) -> None:
    page.get_by_role("button", name="Record", exact=True).click()
    page.get_by_text("● ").wait_for()
    page.keyboard.press("p")
    wait_until(lambda: drive.snapshot.mode == "paused")
    still = drive.snapshot.state.time
    page.wait_for_timeout(500)
    assert drive.snapshot.state.time == still
    page.get_by_role("button", name="Go on").click()
    wait_until(lambda: drive.snapshot.state.time > still + 0.3)
    with page.expect_download() as download:
        page.get_by_role("button", name="Stop recording and save").click()
    saved = tmp_path / "drive.npz"
    download.value.save_as(saved)
    log = MpcLog.load(saved)
    assert log.time[0] == 0.0
    assert np.diff(log.time).max() < 2.0 * log.period  # the pause is no part of it
    clip = open_clip(saved)
    assert clip.joints is not None
    assert clip.horizon == pytest.approx(log.time[-1])


def test_numbers_choose_gaits_and_keys_are_told(page: Any, drive: DrivePage) -> None:
    page.get_by_text("keys and mouse").click()
    page.get_by_text("record, stop and save").wait_for()
    for number, gait in enumerate(GAITS, start=1):
        page.keyboard.press(str(number))
        wait_until(lambda gait=gait: drive.panel.gait == gait)
    page.get_by_role("button", name="drive", exact=True).click()
    wait_until(lambda: drive.snapshot.gait == "drive")


def test_a_page_that_is_gone_holds_nothing(page: Any, drive: DrivePage) -> None:
    page.keyboard.down("w")
    wait_until(lambda: drive.hands.wish.forward == 1.0)
    page.goto("about:blank")
    comes_to_rest(drive)
    assert drive.error is None
