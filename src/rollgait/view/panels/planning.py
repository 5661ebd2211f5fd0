"""The tab in which a motion is designed and planned. Shows the draft; changes go to it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from html import escape
from typing import Any, Final

import viser

from rollgait.diagnosis.report import Diagnosis
from rollgait.robot.library import robot_names
from rollgait.robot.robot import Robot
from rollgait.scenario import scenario_names
from rollgait.view.design.draft import Draft
from rollgait.view.design.handles import Selection
from rollgait.view.panels.design.actions import Actions
from rollgait.view.panels.design.fields import Fields, by_a_person, choose
from rollgait.view.panels.design.gait import GaitPanel
from rollgait.view.panels.design.ground import GroundPanel
from rollgait.view.panels.design.limits import LimitsPanel
from rollgait.view.panels.design.loads import LoadsPanel
from rollgait.view.panels.design.places import PlacesPanel
from rollgait.view.panels.design.terms import TermsPanel
from rollgait.view.panels.diagnosis import DiagnosisPanel
from rollgait.view.panels.motion import BAD, DIM, GOOD
from rollgait.view.solving import SolvingProgress

UNDO: Final = "↶ undo"
REDO: Final = "↷ redo"
SAID: Final = "margin:0.4em 0.75em;font:12px system-ui,sans-serif"
PROFILES: Final = ("executable", "paper")


class PlanningPanel:
    """The controls.

    Args:
        gui: of the page.
        actions: what they do to the draft.
        on_plan: of the button *Plan*.
        on_cancel: of the button *Cancel*.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        actions: Actions,
        on_plan: Callable[[], None],
        on_cancel: Callable[[], None],
    ) -> None:
        self._busy = False
        self.picker: Any = gui.add_dropdown("scenario", tuple(scenario_names()))
        history = gui.add_button_group("design", (UNDO, REDO), hint="Ctrl+Z, Ctrl+Y")
        self.button = gui.add_button("Plan", icon=viser.Icon.ROUTE, color="blue")
        self.cancel = gui.add_button("Cancel", icon=viser.Icon.X, color="gray", visible=False)
        self.message = gui.add_html("")
        self._diagnosis = DiagnosisPanel(gui, actions.take)
        self._fields = Fields(actions.change)
        self.robot: Any = gui.add_dropdown("robot", tuple(robot_names()))
        self.places = PlacesPanel(gui, actions)
        self.gait = GaitPanel(gui, actions)
        self.ground = GroundPanel(gui, actions)
        self.loads = LoadsPanel(gui, actions)
        self._profile: Any = gui.add_dropdown("profile", PROFILES, hint="Of the weights and bounds not given")
        self._fields.key(self._profile, "profile")
        self.weights = LimitsPanel(gui, actions, "weights")
        self.bounds = LimitsPanel(gui, actions, "bounds")
        self.terms = TermsPanel(gui, actions)
        self.keep: Any = gui.add_checkbox("motion before as ghost", True)
        self.robot.on_update(by_a_person(lambda _: self._choose_robot(actions)))
        self.picker.on_update(by_a_person(lambda _: actions.pick(str(self.picker.value))))
        history.on_click(
            lambda event: actions.step_back() if event.target.value == UNDO else actions.step_ahead()
        )
        self.button.on_click(lambda _: on_plan())
        self.cancel.on_click(lambda _: on_cancel())

    def show(self, draft: Draft, selected: Selection) -> None:
        """Shows the draft, and says why it cannot be planned, if so."""
        scenario = draft.scenario
        names = tuple(scenario_names())
        own = () if draft.name in names else (draft.name,)
        choose(self.picker, (*own, *names), draft.name)
        robot = scenario.robot.name if isinstance(scenario.robot, Robot) else scenario.robot
        robots = tuple(robot_names())
        choose(self.robot, robots if robot in robots else (robot, *robots), robot)
        self.places.show(scenario, selected)
        self.gait.show(scenario)
        self.ground.show(scenario, selected)
        self.loads.show(scenario)
        self._fields.show(scenario)
        self.weights.show(scenario)
        self.bounds.show(scenario)
        self.terms.show(scenario)
        if not self._busy:
            self._diagnosis.show(None)
            self.say(draft.fault, good=False)

    def place(self, selected: Selection, pose: Mapping[str, float]) -> None:
        """Shows where the handle is while it is dragged."""
        (self.ground.drag if selected.kind == "part" else lambda p: self.places.place(selected, p))(pose)

    def _choose_robot(self, actions: Actions) -> None:
        if self.robot.value in robot_names():
            actions.change({"robot": str(self.robot.value)})

    # -- state of the button --

    def busy(self, text: str = "building the problem …") -> None:
        """Says that a scenario is being planned."""
        self._busy = True
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
        self._busy = False
        self.button.disabled, self.cancel.visible = False, False
        self._diagnosis.show(diagnosis)
        self._say(text, GOOD if good else BAD)

    def say(self, text: str, good: bool) -> None:
        """Says something of the draft."""
        self._say(text, GOOD if good else BAD)

    def _say(self, text: str, colour: str) -> None:
        content = f'<div style="{SAID};color:{colour}">{escape(text)}</div>' if text else ""
        if self.message.content != content:
            self.message.content = content
