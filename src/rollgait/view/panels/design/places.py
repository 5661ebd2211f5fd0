"""Start and goals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import viser

from rollgait.scenario.scenario import Scenario
from rollgait.view.design.handles import Selection
from rollgait.view.design.parts import pose_of, with_goal, without_goal
from rollgait.view.panels.design.actions import Actions
from rollgait.view.panels.design.fields import by_a_person, choose, put

ADD: Final = "add"
REMOVE: Final = "take away"
GOAL: Final = "goal"
START: Final = "start"
PART: Final = "part of the ground"
POSE: Final = "x (m), y (m), yaw (degrees); or drag it on the ground"


class PlacesPanel:
    """Where the robot begins, and where it is wanted from when on.

    Args:
        gui: of the page.
        actions: what they do to the draft.
    """

    def __init__(self, gui: viser.GuiApi, actions: Actions) -> None:
        self._actions = actions
        self._number = 0
        self._goals: tuple[str, ...] = (GOAL,)
        self.which: Any = gui.add_dropdown(
            "handle at", (GOAL, START), hint="What can be dragged in the scene"
        )
        self.goal: Any = gui.add_vector3("goal", (0.0, 0.0, 0.0), step=0.01, hint=POSE)
        self.at: Any = gui.add_number("from (s)", 0.0, min=0.0, step=0.1, visible=False)
        buttons = gui.add_button_group("goals", (ADD, REMOVE))
        self.start: Any = gui.add_vector3("start", (0.0, 0.0, 0.0), step=0.01, hint=POSE)
        self.goal.on_update(by_a_person(lambda _: self._moved(Selection("goal", self._number), self.goal)))
        self.start.on_update(by_a_person(lambda _: self._moved(Selection("start"), self.start)))
        self.which.on_update(by_a_person(lambda _: self._choose()))
        self.at.on_update(by_a_person(lambda _: self._begin()))
        buttons.on_click(lambda event: self._add_or_remove(event.target.value))

    def show(self, scenario: Scenario, selected: Selection) -> None:
        """Shows start and goals, and of the goals the one with the handle."""
        later = scenario.goal.then
        if selected.kind == "goal":
            self._number = selected.number
        self._number = min(self._number, len(later))
        self._goals = tuple(f"{GOAL} {k + 1}" for k in range(1 + len(later))) if later else (GOAL,)
        part = (PART,) if selected.kind == "part" else ()
        at = {"start": START, "part": PART}.get(selected.kind, self._goals[self._number])
        choose(self.which, (*self._goals, START, *part), at)
        goal: Any = scenario.goal if self._number == 0 else later[self._number - 1]
        self.at.visible = self._number > 0
        put(self.at, float(getattr(goal, "at", 0.0)))
        put(self.goal, tuple(pose_of(goal).values()))
        put(self.start, tuple(pose_of(scenario.start).values()))

    def place(self, selected: Selection, pose: Mapping[str, float]) -> None:
        """Shows where the handle is while it is dragged."""
        put(self.start if selected.kind == "start" else self.goal, tuple(pose.values()))

    def _choose(self) -> None:
        name = str(self.which.value)
        if name in self._goals:
            self._actions.select(Selection("goal", self._goals.index(name)))
        elif name == START:
            self._actions.select(Selection("start"))

    def _moved(self, what: Selection, box: Any) -> None:
        values = dict(zip(("x", "y", "yaw_deg"), map(float, box.value), strict=True))
        self._actions.change(what.values(values), what.stroke)
        self._actions.select(what)

    def _begin(self) -> None:
        key = f"goal.then.{self._number - 1}.at"
        if self._number > 0:
            self._actions.change({key: float(self.at.value)}, key)

    def _add_or_remove(self, button: str) -> None:
        scenario = self._actions.scenario
        count = len(scenario.goal.then)
        if button == ADD:
            self._actions.change(with_goal(scenario), "")
            self._actions.select(Selection("goal", count + 1))
        elif count:
            self._actions.change(without_goal(scenario, self._number), "")
            self._actions.select(Selection("goal", max(self._number - 1, 0)))
