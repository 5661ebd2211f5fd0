"""What keeps draft, controls and handles alike."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from rollgait.config import validate
from rollgait.diagnosis.report import Suggestion
from rollgait.errors import RollgaitError, UnknownNameError
from rollgait.scenario import find_scenario, scenario_names
from rollgait.scenario.scenario import Scenario
from rollgait.terrain.ground import Ground
from rollgait.view.design.draft import Draft
from rollgait.view.design.files import as_python, kept_map
from rollgait.view.design.handles import Handles, Selection
from rollgait.view.panels.design.actions import Actions
from rollgait.view.panels.design.gait import DISCOVER
from rollgait.view.panels.planning import PlanningPanel
from rollgait.view.server import Server

OWN: Final = "my "
"""Before the name of a scenario of the library that was changed."""
NEEDS_RESOLUTION: Final = (".npy", ".png")
"""Maps that do not say themselves where their values are."""


class Designer(Actions):
    """The draft, the tab in which it is designed, and its handles in the scene.

    Args:
        server: of the page.
        lock: of all that the page shows.
        maps: folder for maps that pages send.
        scenario: with which it begins.
        name: of the scenario.
        on_plan: plans the draft.
        on_cancel: stops that.
        on_change: is called when the draft has changed, with the lock held.
    """

    def __init__(
        self,
        server: Server,
        lock: threading.RLock,
        maps: Path,
        scenario: Scenario,
        name: str,
        on_plan: Callable[[], None],
        on_cancel: Callable[[], None],
        on_change: Callable[[], None],
    ) -> None:
        self._server, self._lock, self.maps = server, lock, maps
        self._on_plan, self._on_change = on_plan, on_change
        self.selected = Selection()
        self.draft = Draft(scenario, name, self._changed)
        self.panel = PlanningPanel(server.gui, self, on_plan, on_cancel)
        self.handles = Handles(server, self._moved)
        gui = server.gui
        gui.add_command("Undo", hotkey="Z", modifier="cmd/ctrl").on_trigger(lambda _: self.step_back())
        gui.add_command("Redo", hotkey="Y", modifier="cmd/ctrl").on_trigger(lambda _: self.step_ahead())
        gui.add_command("Plan", hotkey="P").on_trigger(lambda _: on_plan())

    def show(self) -> None:
        """Shows the draft in all controls and in the scene."""
        with self._lock, self._server.atomic():
            if self.selected.of(self.draft.scenario) is None:
                self.selected = Selection()
            self.panel.show(self.draft, self.selected)
            self.handles.show(self.draft.scenario, self.selected)

    def python(self) -> str:
        """The draft as a program."""
        return as_python(self.draft.scenario, self.draft.name)

    # -- what controls do --

    def change(self, values: Mapping[str, Any], stroke: str = "") -> None:
        """Changes the draft; what cannot be is said, and the controls show the draft again."""
        with self._lock:
            name = self.draft.name
            own = OWN + name if name in scenario_names() else name
            try:
                edited = self.draft.scenario.edited(values)
                _ = edited.body  # who falls over with what it carries cannot be shown
                self.draft.put(edited, own, stroke)
            except RollgaitError as error:
                self.show()
                self.panel.say(str(error), good=False)

    def put(self, scenario: Scenario, name: str) -> None:
        """Goes on with another scenario."""
        with self._lock:
            self.selected = Selection()
            self.draft.put(scenario, name)

    def select(self, what: Selection) -> None:
        """Gives the handle to something."""
        with self._lock:
            self.selected = what
            self.show()

    def pick(self, name: str) -> None:
        """Begins with a scenario of the library: never with a file."""
        if name in scenario_names():
            self.put(find_scenario(name), name)
        elif name != self.draft.name:
            self.panel.say(str(UnknownNameError("scenario", name, scenario_names())), good=False)

    def step_back(self) -> None:
        """Undoes."""
        with self._lock:
            self.draft.undo()

    def step_ahead(self) -> None:
        """Does again what was undone."""
        with self._lock:
            self.draft.redo()

    def take(self, suggestion: Suggestion) -> None:
        """Takes up what would help."""
        with self._lock:
            self.change(suggestion.change)
            if not self.draft.fault:
                self.panel.say(f"{suggestion.text}: press Plan", good=True)

    def take_map(self, file: Any, keys: dict[str, Any]) -> None:
        """Puts the draft on the map in a file that a page sent."""
        with self._lock:
            try:
                ground = self._on_map(kept_map(self.maps, file.name, file.content), keys)
            except RollgaitError as error:
                self.panel.say(str(error), good=False)
                return
            fresh = self.draft.scenario.edited({})  # nothing of it was worked out on the ground before
            self.draft.put(fresh.model_copy(update={"ground": ground}), self.draft.name)

    def _on_map(self, name: str, keys: dict[str, Any]) -> Ground:
        """The ground of the draft on a map in the folder of maps."""
        suffix = Path(name).suffix
        own: dict[str, Any] = {"file": name}
        if suffix in NEEDS_RESOLUTION:
            own |= {"resolution": keys["resolution"], "origin": keys["origin"]}
        if suffix == ".png":
            own["scale"] = keys["scale"]
        data = self.draft.scenario.ground.model_dump(mode="json")
        return validate(Ground, {**data, "map": own}, "ground").read(self.maps)

    def _moved(self, what: Selection, pose: dict[str, float], done: bool) -> None:
        """The handle was dragged: numbers follow at once, the draft when the hand lets go."""
        self.panel.place(what, pose)
        if done:
            self._server.in_turn(self._let_go, what, pose)

    def _let_go(self, what: Selection, pose: dict[str, float]) -> None:
        self.change(what.values(pose), what.stroke)
        if what.kind == "goal" and self.draft.scenario.gait.kind == DISCOVER and not self.draft.fault:
            self._on_plan()  # who drags the goal over the ground wants to see how to get there

    def _changed(self) -> None:
        self.show()
        self._on_change()
