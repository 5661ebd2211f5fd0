"""Controls of the time and of what is shown: timeline, marks, layers, plots."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any, Final

import viser

from rollgait.view import plots
from rollgait.view.clip import Clip
from rollgait.view.in_order import show_values
from rollgait.view.marks import Mark
from rollgait.view.timeline import Timeline

SPEEDS: Final = {"¼ ×": 0.25, "½ ×": 0.5, "1 ×": 1.0, "2 ×": 2.0}
STEPS: Final = {"start": None, "◂ frame": -1, "frame ▸": 1, "end": None}
CAUSES: Final = 3
"""Of a verdict that are told: more would leave no room on a phone."""
APART: Final = 0.035
"""Smallest distance of two marks on the timeline, as a share of it, so that their numbers stand apart."""
GOOD: Final = "light-dark(#2E7D32, #7FC983)"
BAD: Final = "light-dark(#B00020, #FF8A95)"
DIM: Final = "var(--mantine-color-dimmed, #666666)"
"""Read on light and on dark."""


def brief(verdict: str) -> str:
    """A verdict with its first causes: the tab Certificate has all."""
    first, *others = verdict.split(", ")
    more = others[CAUSES - 1 :]
    return ", ".join([first, *others[: CAUSES - 1]]) + (f" and {len(more)} more" if more else "")


class Header:
    """What is shown, and how good it is."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self.html = gui.add_html("", order=0.0)

    def show(self, clip: Clip, ghost: Clip | None) -> None:
        """Says what is shown."""
        colour = DIM if clip.kind == "scenario" else GOOD if clip.passed else BAD
        behind = f'<div style="color:#5B7FA6">ghost: {escape(ghost.name)}</div>' if ghost else ""
        self.html.content = (
            '<div style="margin:0.3em 0.75em;font:12.5px system-ui,sans-serif;line-height:1.45">'
            f"<b>{escape(clip.name)}</b> · {escape(clip.robot.name)} · {clip.horizon:.4g} s<br>"
            f'<span style="color:{colour};font-weight:600">{escape(brief(clip.verdict))}</span>'
            f"{behind}</div>"
        )


class TimePanel:
    """Slider, play, steps and speed. `follow` shows where the time stands."""

    def __init__(self, gui: viser.GuiApi, timeline: Timeline) -> None:
        self._gui, self._timeline = gui, timeline
        self.slider: Any = None
        self.play = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY, color="blue", order=2.0)
        self.steps = gui.add_button_group("step", tuple(STEPS), order=2.1)
        self.speed = gui.add_dropdown("speed", tuple(SPEEDS), initial_value="1 ×", order=2.2)
        self.loop = gui.add_checkbox("loop", timeline.loop, order=2.3)
        self.play.on_click(lambda _: self.toggle())
        self.steps.on_click(lambda event: self._step(event.target.value))
        self.speed.on_update(lambda event: setattr(timeline, "speed", SPEEDS[event.target.value]))
        self.loop.on_update(lambda event: setattr(timeline, "loop", event.target.value))
        gui.add_command("Play or pause", hotkey="space").on_trigger(lambda _: self.toggle())
        gui.add_command("One frame back", hotkey="arrowleft").on_trigger(lambda _: timeline.step(-1))
        gui.add_command("One frame ahead", hotkey="arrowright").on_trigger(lambda _: timeline.step(1))

    def build(self, clip: Clip) -> None:
        """The slider of a clip, with its marks."""
        if self.slider is not None:
            self.slider.remove()
        marks = tuple((mark.time, str(number)) for number, mark in numbered(clip))
        self.slider = self._gui.add_slider(
            "time (s)",
            min=0.0,
            max=round(clip.horizon, 3),
            step=0.001,
            initial_value=0.0,
            marks=marks or None,
            hint="The numbers are the moments nearest to a limit; the tab Certificate says which. Click one.",
            order=1.0,
        )
        self.slider.on_update(self._scrubbed)
        moves = clip.kind != "scenario"  # what stands still needs the room for its design
        for handle in (self.slider, self.play, self.steps, self.speed, self.loop):
            handle.visible = moves

    def follow(self) -> None:
        """Shows the time of the timeline."""
        show_values([(self.slider, round(self._timeline.time, 3))])
        playing = self._timeline.playing
        label = "Pause" if playing else "Play"
        if self.play.label != label:
            self.play.label = label
            self.play.icon = viser.Icon.PLAYER_PAUSE if playing else viser.Icon.PLAYER_PLAY

    def toggle(self) -> None:
        """Play, or pause."""
        if self._timeline.playing:
            self._timeline.pause()
        else:
            self._timeline.play()
        self.follow()

    def _scrubbed(self, event: Any) -> None:
        if event.client is None:
            return  # our own move
        self._timeline.pause()
        self._timeline.go(float(event.target.value))

    def _step(self, name: str) -> None:
        frames = STEPS[name]
        if frames is None:
            self._timeline.pause()
            self._timeline.go(0.0 if name == "start" else self._timeline.horizon)
        else:
            self._timeline.step(frames)


class LayerPanel:
    """A switch for each layer."""

    def __init__(self, gui: viser.GuiApi, switch: Callable[[str, bool], None]) -> None:
        self._gui, self._switch = gui, switch
        self._place = gui.add_folder("show")
        self._boxes: list[Any] = []

    def build(self, layers: dict[str, bool]) -> None:
        """The switches of a scene; where there was one of this title, it keeps its state."""
        for box in self._boxes:
            box.remove()
        with self._place:
            self._boxes = [self._gui.add_checkbox(title, shown) for title, shown in layers.items()]
        for title, box in zip(layers, self._boxes, strict=True):
            box.on_update(lambda event, title=title: self._switch(title, event.target.value))


class PlotPanel:
    """Plots with a line at the time."""

    def __init__(self, gui: viser.GuiApi, place: Any) -> None:
        self._gui, self._place = gui, place
        self._handles: list[tuple[Any, Any, plots.Plot]] = []
        gui.add_html(plots.legend())

    def build(self, clip: Clip) -> None:
        """The plots of a clip."""
        for cursor, picture, _ in self._handles:
            cursor.remove()
            picture.remove()
        self._clip = clip
        with self._place:
            self._handles = [
                (
                    self._gui.add_html(plots.cursor(plot, clip, 0)),
                    self._gui.add_html(plots.draw(plot, clip)),
                    plot,
                )
                for plot in plots.plots_of(clip)
            ]

    def follow(self, index: int) -> None:
        """Moves the lines to a frame."""
        for cursor, _, plot in self._handles:
            cursor.content = plots.cursor(plot, self._clip, index)


def numbered(clip: Clip) -> list[tuple[int, Mark]]:
    """The marks of a clip with their numbers, without those too near to a worse one on the timeline."""
    kept: list[tuple[int, Mark]] = []
    for number, mark in enumerate(clip.marks, start=1):
        if all(abs(mark.time - other.time) >= APART * clip.horizon for _, other in kept):
            kept.append((number, mark))
    return sorted(kept, key=lambda item: item[1].time)
