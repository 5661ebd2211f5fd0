"""The controls of a drive, and what it says of itself."""

from __future__ import annotations

import math
import random
import threading
from collections.abc import Callable, Sequence
from functools import partial
from html import escape
from typing import Any, Final

import viser

from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.gaits import GAITS
from rollgait.mpc.plans.manoeuvres import AHEAD as WAY_AHEAD
from rollgait.mpc.settings import CommandLimits
from rollgait.view.driving.hands import Hands
from rollgait.view.driving.messages import AHEAD, NO_FORCE, PUSHES_MAX, PushRequest, Snapshot, Vector
from rollgait.view.panels.keys import add_keys
from rollgait.view.panels.motion import BAD, DIM, GOOD

PUSH_OF_WEIGHT: Final = 0.087
"""Force of a push over the robot's weight: 100 N for CENTAURO, and no robot is thrown over by a click."""
PUSH_DURATION: Final = 0.2
"""s"""
PULL_STIFFNESS: Final = 3.0
"""Force of a pull with the mouse over its way, pushes per m."""
PULL_MAX: Final = 1.5
"""Largest, in pushes."""
SPEED: Final = 0.4
"""Limit of the speed at first, m/s."""
SPEED_MIN: Final = 0.05
"""Its smallest one: at 0 the joystick would seem dead, m/s."""
DIRECTIONS: Final = {"random": None, "forward": 0.0, "left": 90.0, "back": 180.0, "right": -90.0}
"""Of the push button, from the robot's nose to its left, degrees."""
MODE_COLOURS: Final = {
    "tracking": GOOD,
    "coasting": "light-dark(#B26A00, #FFB74D)",
    "standing": BAD,
    "fallen": BAD,
    "paused": "light-dark(#41648B, #8FB4DC)",
}
DISTANCE: Final = 2.4
"""How far ahead the robot is to get at first, m: over a step and a length of its body beyond."""
RECORD: Final = "Record"
STOP: Final = "Stop recording and save"
HOTKEYS: Final[tuple[Any, ...]] = tuple("123456789")
KEYS: Final = {
    "w s, a d": "forward, back, to the left, to the right",
    "q e": "turn to the left, to the right",
    "space": "stop, a manoeuvre too",
    "P": "pause, go on",
    "R": "record, stop and save",
    "gamepad": "left stick: drive, right stick: turn, B: stop",
    "Ctrl+K": "all commands by name",
}
MODE_NOTES: Final = {"standing": "after a fault; press Reset", "fallen": "press Reset"}


class Panel:
    """What a person can set. Values are read by the page's thread; clicks wait until it takes them.

    Args:
        gui: of the page.
        hands: who hold joysticks.
        pad: the joystick as HTML.
        limits: of commands.
        gait: with which it begins.
        weight: of the robot, N: the heavier, the stronger it is pushed and pulled.
    """

    def __init__(
        self, gui: viser.GuiApi, hands: Hands, pad: str, limits: CommandLimits, gait: str, weight: float
    ) -> None:
        self._hands, self._limits = hands, limits
        self._force = push_force(weight)
        self._lock = threading.Lock()
        self._clicked: list[float | None] = []
        self._pushes: list[PushRequest] = []
        self._reset = False
        self._manoeuvre, self._halt = "", False
        self.pull: Vector = NO_FORCE
        self._pulls: int | None = None
        self.gait = gait
        gui.add_html(pad)  # first: on a phone there is room for little more
        self._status = gui.add_html("")
        gaits = gui.add_button_group("gait", tuple(GAITS))
        self.speed = gui.add_slider(
            "speed limit (m/s)",
            min=SPEED_MIN,
            max=limits.speed,
            step=0.05,
            initial_value=min(SPEED, limits.speed),
        )
        high = limits.height_change
        self.height = gui.add_slider("height (m)", min=-high, max=high, step=0.005, initial_value=0.0)
        self.direction = gui.add_dropdown("push to", tuple(DIRECTIONS), initial_value="random")
        push = gui.add_button(
            f"Push: {self._force:g} N, {PUSH_DURATION:g} s", icon=viser.Icon.HAND_FINGER, color="gray"
        )
        gui.add_markdown("Or click the robot's body to push it, and drag it to pull.")
        reset = gui.add_button("Reset", icon=viser.Icon.REFRESH, color="gray", hint="After a fall or a fault")
        self._motions = gui.add_folder("manoeuvres", visible=False)
        self.follow = gui.add_checkbox("keep the robot in the middle", True)
        self.pause = gui.add_button(
            "Pause", icon=viser.Icon.PLAYER_PAUSE, color="gray", hint="Time stands still"
        )
        self.record = gui.add_button(
            RECORD, icon=viser.Icon.PLAYER_RECORD, color="gray", hint="A log that rollgait view shows"
        )
        self._folder = gui.add_folder("show", expand_by_default=False)
        self._gui = gui
        gaits.on_click(lambda event: self._choose(event.target.value))
        push.on_click(lambda _: self._click())
        reset.on_click(lambda _: self._ask_reset())
        self.paused, self._records, self._recordings = False, False, 0
        self._browser = -1
        self.pause.on_click(lambda _: self.toggle_pause())
        self.record.on_click(lambda event: self.toggle_record(event.client_id or 0))
        gui.add_command("Pause or go on", hotkey="P").on_trigger(lambda _: self.toggle_pause())
        gui.add_command("Record or stop recording", hotkey="R").on_trigger(
            lambda event: self.toggle_record(event.client_id or 0)
        )
        for number, name in enumerate(GAITS, start=1):
            gui.add_command(f"Gait {name}", hotkey=HOTKEYS[number - 1]).on_trigger(
                partial(self._choose_by_key, name)
            )
        add_keys(gui, {**KEYS, f"1 … {len(GAITS)}": ", ".join(GAITS)})

    def add_switches(self, titles: tuple[str, ...], switch: Callable[[str, bool], None]) -> None:
        """A switch for each layer of the scene."""
        with self._folder:
            for title in titles:
                box = self._gui.add_checkbox(title, True)
                box.on_update(partial(_switched, switch, title))

    def add_manoeuvres(self, names: Sequence[str]) -> None:
        """Buttons of motions that are planned from where the robot stands, and one for what is ahead."""
        low, high = WAY_AHEAD
        self._motions.visible = True
        with self._motions:
            for name in names:
                button = self._gui.add_button(name, color="gray", hint="Planned from here")
                button.on_click(partial(self._ask_manoeuvre, name))
            self.distance = self._gui.add_slider(
                "distance (m)", min=low, max=high, step=0.1, initial_value=DISTANCE
            )
            over = self._gui.add_button(
                "Climb what is ahead",
                icon=viser.Icon.STAIRS_UP,
                color="gray",
                hint="Finds a way to there, by wheels or steps, and takes it",
            )
            over.on_click(partial(self._ask_manoeuvre, AHEAD))
            stop = self._gui.add_button("Stop the manoeuvre", icon=viser.Icon.HAND_STOP, color="gray")
            stop.on_click(lambda _: self._ask_halt())

    def _ask_manoeuvre(self, name: str, _: Any) -> None:
        with self._lock:
            self._manoeuvre = name

    def _ask_halt(self) -> None:
        with self._lock:
            self._manoeuvre, self._halt = "", True

    def take_manoeuvre(self) -> tuple[str, float, bool]:
        """Which one was asked for since the last call, "" if none; how far ahead, m; whether to end."""
        low, high = WAY_AHEAD
        with self._lock:
            asked, self._manoeuvre = self._manoeuvre, ""
            halt, self._halt = self._halt, False
        return asked, _within(self.distance.value, low, high), halt

    def add_grip(self, handle: Any) -> None:
        """Lets a mesh be clicked and dragged."""
        handle.on_click(lambda event: self._push_along(event.ray_direction))
        handle.on_drag(self._dragged)

    # -- what the page asks for --

    def command(self) -> VelocityCommand:
        """What is asked for now."""
        limits = self._limits
        speed = _within(self.speed.value, SPEED_MIN, limits.speed)
        height = _within(self.height.value, -limits.height_change, limits.height_change)
        turn_rate = limits.turn_rate * speed / limits.speed
        return self._hands.wish.velocity(speed, turn_rate, gait=self.gait, height_change=height)

    def take(self, yaw: float) -> tuple[tuple[PushRequest, ...], bool]:
        """Pushes that were asked for since the last call, and whether a reset was.

        Args:
            yaw: of the robot, rad: from it the directions of the button count.
        """
        with self._lock:
            pushes = [*self._pushes, *(_push(self._force, yaw, angle) for angle in self._clicked)]
            reset = self._reset
            self._pushes, self._clicked, self._reset = [], [], False
        return tuple(pushes), reset

    def _choose(self, gait: str) -> None:
        if gait in GAITS:
            self.gait = gait

    def _choose_by_key(self, gait: str, _: Any) -> None:
        self._choose(gait)

    def _click(self) -> None:
        direction = self.direction.value
        with self._lock:
            if direction in DIRECTIONS and self._waiting < PUSHES_MAX:
                self._clicked.append(DIRECTIONS[direction])

    @property
    def _waiting(self) -> int:
        return len(self._clicked) + len(self._pushes)

    def _ask_reset(self) -> None:
        self._hands.stop()
        with self._lock:
            self._reset = True

    def _push_along(self, direction: Any) -> None:
        """A push along the horizontal part of a ray; one from straight above pushes nowhere."""
        x, y, _ = (float(part) for part in direction)
        length = math.hypot(x, y)
        if not 1e-3 < length < math.inf:
            return
        force = self._force / length
        with self._lock:
            if self._waiting < PUSHES_MAX:
                self._pushes.append(PushRequest((force * x, force * y, 0.0), PUSH_DURATION))

    async def _dragged(self, event: Any) -> None:
        """In the loop of the server: in threads its updates could overtake the end of a pull.

        Who has begun last pulls. Where a browser is gone, viser says the end of what that has begun.
        """
        if event.phase == "start":
            self._pulls = event.client_id
        if event.client_id != self._pulls:
            return
        if event.phase == "end":
            self._pulls, self.pull = None, NO_FORCE
        else:
            self.pull = pull_of(event.start_position, event.end_position, self._force)

    # -- pauses and recordings --

    def toggle_pause(self) -> None:
        """Pauses, or goes on."""
        self.paused = not self.paused
        self.pause.label = "Go on" if self.paused else "Pause"
        self.pause.icon = viser.Icon.PLAYER_PLAY if self.paused else viser.Icon.PLAYER_PAUSE

    def toggle_record(self, browser: int) -> None:
        """Begins to record, or ends; who has asked last gets the file."""
        with self._lock:
            self._browser = browser
            self._records = not self._records
            self._recordings += self._records
            self.record.label = STOP if self._records else RECORD

    @property
    def recording(self) -> int:
        """Number of the recording that runs; 0 if none does."""
        return self._recordings if self._records else 0

    def end_recording(self) -> tuple[str, int]:
        """A recording has ended: the name of its file, and the number of the browser that shall have it."""
        with self._lock:
            self._records = False
            self.record.label = RECORD
            return f"drive-{self._recordings}.npz", self._browser

    # -- what it says --

    def show(self, snapshot: Snapshot) -> None:
        """Says how it goes."""
        self._status.content = status_html(snapshot)

    def show_error(self, text: str) -> None:
        """Says that it has come to an end."""
        self._status.content = f'<div style="margin:0.5em 0.75em;color:{BAD}"><b>{escape(text)}</b></div>'


def _switched(switch: Callable[[str, bool], None], title: str, event: Any) -> None:
    switch(title, bool(event.target.value))


def push_force(weight: float) -> float:
    """Force of a push, N, with one digit that counts, for a robot of a weight, N."""
    return float(f"{PUSH_OF_WEIGHT * weight:.1g}")


def pull_of(begin: Any, end: Any, push: float) -> Vector:
    """The horizontal force of a spring between two points, N, by that of a push; none if they are nowhere."""
    x, y = (push * PULL_STIFFNESS * (float(end[axis]) - float(begin[axis])) for axis in (0, 1))
    length = math.hypot(x, y)
    if not length < math.inf:
        return NO_FORCE
    share = min(1.0, push * PULL_MAX / max(length, 1e-9))
    return share * x, share * y, 0.0


def _within(value: Any, low: float, high: float) -> float:
    """A number cut to a range; what is no number is its lower end."""
    return min(high, float(value)) if value >= low else low


def _push(force: float, yaw: float, degrees: float | None) -> PushRequest:
    angle = random.uniform(-math.pi, math.pi) if degrees is None else yaw + math.radians(degrees)
    return PushRequest((force * math.cos(angle), force * math.sin(angle), 0.0), PUSH_DURATION)


def status_html(snapshot: Snapshot) -> str:
    """How it goes, as HTML."""
    mode = snapshot.mode
    note = f" ({MODE_NOTES[mode]})" if mode in MODE_NOTES else ""
    x, y, z = snapshot.state.com_position.tolist()
    command = snapshot.command
    rows = [
        ("mode", f'<b style="color:{MODE_COLOURS[mode]}">{mode}</b>{note}'),
        ("gait", escape(snapshot.gait)),
        ("asked for", _velocity((command.forward, command.lateral, command.turn_rate))),
        ("wanted now", _velocity(snapshot.wanted)),
        ("actual", _velocity(snapshot.actual)),
        ("place", f"{x:.2f}, {y:.2f}, {z:.3f} m"),
        ("solve", f"{1e3 * snapshot.solve[0]:.1f} ms median, {1e3 * snapshot.solve[1]:.1f} ms p99"),
        ("real time", f"× {snapshot.factor:.2f} at {snapshot.rate:.0f} Hz"),
    ]
    if snapshot.manoeuvre:
        rows.insert(1, ("manoeuvre", f"<b>{escape(snapshot.manoeuvre)}</b>"))
    if snapshot.recorded:
        rows.insert(0, ("recording", f'<b style="color:{BAD}">● {snapshot.recorded:.1f} s</b>'))
    cells = "".join(
        f'<tr><td style="color:{DIM};padding-right:1em">{name}</td><td>{value}</td></tr>'
        for name, value in rows
    )
    events = "".join(f"<div>{time:.1f} s: {escape(text)}</div>" for time, text in reversed(snapshot.events))
    return (
        '<div style="margin:0.3em 0.75em;font:12.5px system-ui,sans-serif;line-height:1.45;'
        f'font-variant-numeric:tabular-nums"><table>{cells}</table>'
        f'<div style="color:{DIM};height:2.9em;overflow:auto">{events or "no events"}</div></div>'
    )


def _velocity(values: Vector) -> str:
    forward, lateral, turn = values
    return f"{forward:+.2f}, {lateral:+.2f} m/s, {turn:+.2f} rad/s"
