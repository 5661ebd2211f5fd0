"""Controls of a new motion: scenario, goal, gait, horizon, weights; plan, cancel, save."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from html import escape
from typing import Any, Final

import numpy as np
import viser

from rollgait.diagnosis.report import Diagnosis, Suggestion
from rollgait.errors import RollgaitError, UnknownNameError
from rollgait.scenario import Crawl, Discover, Pace, Scenario, Trot, Walk, find_scenario, scenario_names
from rollgait.view.clip import Clip
from rollgait.view.layers.goal import pad
from rollgait.view.layers.layer import rgb, segments, single
from rollgait.view.on_ground import heights
from rollgait.view.panels.diagnosis import DiagnosisPanel
from rollgait.view.panels.motion import BAD, DIM, GOOD
from rollgait.view.rotations import turn_z, wxyz
from rollgait.view.solving import SolvingProgress
from rollgait.view.style import GOAL_COLOUR

THE_SHOWN: Final = "the one shown"
DISCOVER: Final = str(Discover.model_fields["kind"].default)
STEPS: Final = {
    str(gait.model_fields["kind"].default): int(gait.model_fields["steps"].default)
    for gait in (Crawl, Walk, Trot, Pace)
}
"""Gaits that are told by a number of steps, and how many by default."""
GAITS: Final = ("drive", "crawl", "crawl, wheels locked", "walk", "trot", "pace", DISCOVER)
HORIZON_MAX: Final = 120.0
"""s"""
SIX: Final = ("acc", "goal", "force", "feet", "speed", "yaw")
"""The paper's weights."""
GIZMO: Final = "/goal"
SAID: Final = "margin:0.4em 0.75em;font:12px system-ui,sans-serif"
GIZMO_SIZE: Final = 0.55
"""m"""


class PlanningPanel:
    """The controls. What is asked for is `scenario()`; `on_plan` and `on_cancel` are the buttons."""

    def __init__(
        self,
        server: viser.ViserServer,
        on_plan: Callable[[], None],
        on_cancel: Callable[[], None],
        save_plan: Callable[[viser.ClientHandle], None],
    ) -> None:
        gui = server.gui
        self._server = server
        self._lock = threading.RLock()
        self._base: Scenario | None = None
        self._shown: Scenario | None = None
        self._asked: Scenario | None = None
        self._on_plan = on_plan
        self.picker: Any = gui.add_dropdown("scenario", tuple(scenario_names()))
        self.goal: Any = gui.add_vector3(
            "goal", (0.0, 0.0, 0.0), step=0.01, hint="x (m), y (m), yaw (degrees); or drag it on the ground"
        )
        self.gait: Any = gui.add_dropdown("gait", GAITS)
        self.steps: Any = gui.add_number("steps", 8, min=1, max=100, step=1)
        self.horizon: Any = gui.add_number(
            "horizon (s)", 10.0, min=0.5, max=HORIZON_MAX, step=0.5, hint="longest one, with discover"
        )
        with gui.add_folder("weights", expand_by_default=False):
            self.weights: dict[str, Any] = {
                name: gui.add_number(name, 1.0, min=0.0, step=1e-6) for name in SIX
            }
        self.button = gui.add_button("Plan", icon=viser.Icon.ROUTE, color="blue")
        self.cancel = gui.add_button("Cancel", icon=viser.Icon.X, color="gray", visible=False)
        self.message = gui.add_html("")
        self._diagnosis = DiagnosisPanel(gui, self._take)
        self.keep: Any = gui.add_checkbox("keep the motion before as a ghost", True)
        self.save = gui.add_button("Save plan", icon=viser.Icon.DOWNLOAD, color="gray")
        self.save_yaml = gui.add_button("Save scenario", icon=viser.Icon.DOWNLOAD, color="gray")
        self.picker.on_update(_by_a_person(lambda _: self.pick(self.picker.value)))
        self.goal.on_update(_by_a_person(lambda _: self._place()))
        self.gait.on_update(lambda _: self._fit())
        self.gait.on_update(_by_a_person(lambda _: self._usual_steps()))
        self.button.on_click(lambda _: on_plan())
        self.cancel.on_click(lambda _: on_cancel())
        self.save.on_click(_by_a_person(save_plan))
        self.save_yaml.on_click(_by_a_person(self._save_yaml))
        self.gizmo: Any = None

    def build(self, clip: Clip) -> None:
        """Begins with the scenario of a clip, or with the first of the library."""
        self._shown = clip.scenario
        if clip.plan is not None and clip.plan.statistics.discovery and self._asked is not None:
            self._shown = self._asked  # the next goal is to have a gait of its own, too
        self._asked = None
        names = tuple(scenario_names())
        self.picker.options = names if self._shown is None else (THE_SHOWN, *names)
        self._clip = clip
        self.picker.value = self.picker.options[0]
        self.pick(self.picker.options[0])
        self.save.disabled = clip.plan is None

    def pick(self, name: str) -> None:
        """Fills the controls with the scenario that is shown or one of the library: never with a file."""
        with self._lock:
            if name == THE_SHOWN and self._shown is not None:
                self._fill(self._shown)
            elif name in scenario_names():
                self._fill(find_scenario(name))
            else:
                self._say(str(UnknownNameError("scenario", name, scenario_names())), BAD)

    def _fill(self, base: Scenario) -> None:
        """Begins with a scenario."""
        with self._lock:
            self._base = base
            self.goal.value = (base.goal.x, base.goal.y, base.goal.yaw_deg)
            self.horizon.value = base.horizon
            kind, locked = base.gait.kind, base.gait.wheels == "locked"
            as_given = () if kind in GAITS else (kind,)
            self.gait.options = (*GAITS, *as_given)
            self.gait.value = f"{kind}, wheels locked" if kind == "crawl" and locked else kind
            self.steps.value = getattr(base.gait, "steps", 8)
            for weight, handle in self.weights.items():
                handle.value = float(base.value_of("weights", weight) or 0.0)
            self._fit()
            self._place()

    def scenario(self) -> Scenario:
        """What is asked for: the chosen scenario with what differs from it. Raises `InputError`."""
        base = self._base or find_scenario(scenario_names()[0])
        values: dict[str, Any] = {}
        for key, value in zip(("goal.x", "goal.y", "goal.yaw_deg"), self.goal.value, strict=True):
            values[key] = round(float(value), 4)
        values |= self._gait_values(base)
        values["horizon"] = float(self.horizon.value)
        for weight, handle in self.weights.items():
            if float(handle.value) != float(base.value_of("weights", weight) or 0.0):
                values[f"weights.{weight}"] = float(handle.value)
        return base.with_values(values)

    @property
    def _kind(self) -> str:
        """Kind of the chosen gait."""
        return str(self.gait.value).partition(",")[0]

    def _usual_steps(self) -> None:
        """Another gait begins with its own number of steps; one that is to be found may take its time."""
        if self._kind == DISCOVER:
            self.horizon.value = HORIZON_MAX
        self.steps.value = STEPS.get(self._kind, self.steps.value)

    def _gait_values(self, base: Scenario) -> dict[str, Any]:
        kind = self._kind
        values: dict[str, Any] = {} if kind == base.gait.kind else {"gait.kind": kind}
        if kind in ("drive", "crawl"):
            locked = "locked" in self.gait.value
            values["gait.wheels"] = "locked" if locked else "rolling"
        if kind in STEPS:
            values["gait.steps"] = int(self.steps.value)
        return values

    def _take(self, suggestion: Suggestion) -> None:
        """Takes up what would help."""
        try:
            self._fill(self.scenario().with_values(suggestion.change))
        except RollgaitError as error:
            self._say(str(error), BAD)
            return
        self._diagnosis.show(None)
        self._say(f"{suggestion.text}: press Plan", GOOD)

    # -- state of the button --

    def busy(self, asked: Scenario, text: str = "building the problem …") -> None:
        """Says that a scenario is being planned."""
        self._asked = asked
        self.button.disabled, self.cancel.visible = True, True
        self._diagnosis.show(None)
        self._say(text, DIM)

    def progress(self, progress: SolvingProgress) -> None:
        """Says how far the solver is."""
        self._say(
            f"{progress.stage} … iteration {progress.number}, cost {progress.cost:.5g}, "
            f"violation {progress.violation:.2g}",
            DIM,
        )

    def done(self, text: str, good: bool, diagnosis: Diagnosis | None = None) -> None:
        """Says what came of it."""
        self.button.disabled, self.cancel.visible = False, False
        self._diagnosis.show(diagnosis)
        self._say(text, GOOD if good else BAD)

    def _say(self, text: str, colour: str) -> None:
        self.message.content = f'<div style="{SAID};color:{colour}">{escape(text)}</div>'

    # -- the goal on the ground --

    def _place(self) -> None:
        """Puts the handle on the ground where the numbers say."""
        x, y, yaw = self.goal.value
        if self.gizmo is None:
            self._add_gizmo()
        height = float(heights(self._clip.terrain, np.array([x, y]))) + 0.01
        self.gizmo.position = (x, y, height)
        self.gizmo.wxyz = wxyz(turn_z(np.radians(yaw)))

    def _add_gizmo(self) -> None:
        scene = self._server.scene
        self.gizmo = scene.add_transform_controls(
            GIZMO,
            scale=GIZMO_SIZE,
            active_axes=(True, True, False),
            depth_test=False,
            line_width=3.0,
            opacity=0.7,
        )
        points = np.column_stack([pad(self._clip), np.zeros(len(pad(self._clip)))])
        scene.add_line_segments(
            f"{GIZMO}/wanted", single(segments(points)), rgb(GOAL_COLOUR, 0.3), thickness=0.01
        )
        self.gizmo.on_update(self._dragged)

    async def _dragged(self, event: Any) -> None:
        x, y, _ = event.target.position
        w, _, _, z = event.target.wxyz
        yaw = float(np.degrees(2.0 * np.arctan2(z, w)))
        turns = round((self.goal.value[2] - yaw) / 360.0)  # a full turn stays one
        self.goal.value = (round(float(x), 3), round(float(y), 3), round(yaw + 360.0 * turns, 1))
        if event.phase == "end" and self._kind == DISCOVER:
            # who drags the goal over the ground wants to see how to get there
            asyncio.get_running_loop().run_in_executor(None, self._on_plan)

    def _fit(self) -> None:
        """Shows the number of steps only where there are steps."""
        self.steps.visible = self._kind in STEPS

    def _save_yaml(self, client: viser.ClientHandle) -> None:
        try:
            text = self.scenario().to_yaml(brief=True)
        except RollgaitError as error:
            self._say(str(error), BAD)
            return
        client.send_file_download("scenario.yaml", text.encode(), save_immediately=True)


def _by_a_person(action: Callable[[viser.ClientHandle], None]) -> Callable[[Any], None]:
    """The action, done only for what comes from a browser: our own changes of a control come back, too."""

    def act(event: Any) -> None:
        if event.client is not None:
            action(event.client)

    return act
