"""What the robot carries and what pulls at it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, get_args

import viser

from rollgait.robot.loads import Frame
from rollgait.scenario.scenario import Scenario
from rollgait.view.design.loads import KINDS, Place, places, with_load, without_load
from rollgait.view.panels.design.actions import Actions
from rollgait.view.panels.design.fields import Fields, by_a_person, choose

REMOVE: Final = "Take this load away"
NONE: Final = "none"
NAMES: Final = {"payload": "payload", "wrench": "pull"}
"""What people call the lists of `loads`."""
AT: Final = "x, y, z (m) from the CoM of the robot without loads, along the base: ahead, left, up"
ZERO: Final = (0.0, 0.0, 0.0)
STEP: Final = 0.01
"""Of places and sizes, m."""
SMALLEST_MASS: Final = 0.01
"""kg: a box of nothing is no load."""


class LoadsPanel:
    """Payloads and pulls.

    Args:
        gui: of the page.
        actions: what they do to the draft.
    """

    def __init__(self, gui: viser.GuiApi, actions: Actions) -> None:
        self._gui, self._actions = gui, actions
        self._place = 0
        self._fields = Fields(actions.change)
        with gui.add_folder("loads", expand_by_default=False):
            add: Any = gui.add_button_group(
                "add a load", tuple(NAMES.values()), hint="What it carries; what pulls or pushes it"
            )
            self.which: Any = gui.add_dropdown("load", (NONE,), visible=False)
            self._rows = gui.add_folder(None)
            self._remove = gui.add_button(REMOVE, color="gray", visible=False)
        add.on_click(lambda event: self._add(event.target.value))
        self.which.on_update(by_a_person(lambda _: self._choose()))
        self._remove.on_click(lambda _: self._take_away())

    def show(self, scenario: Scenario) -> None:
        """Shows the loads of a scenario, and of one of them what there is to say."""
        there = places(scenario)
        self._place = max(0, min(self._place, len(there) - 1))
        names = tuple(f"{k + 1}  {NAMES[place.kind]}" for k, place in enumerate(there)) or (NONE,)
        choose(self.which, names, names[self._place])
        self.which.visible = self._remove.visible = self._rows.visible = bool(there)
        if there:
            place = there[self._place]
            build = self._payload if place.kind == "payload" else self._wrench
            self._fields.rebuild(place, self._rows, lambda: build(place))
        self._fields.show(scenario)

    def _payload(self, place: Place) -> None:
        gui = self._gui
        self._bind(gui.add_number("mass (kg)", 1.0, min=SMALLEST_MASS, step=0.5), place, "mass")
        self._bind(gui.add_vector3("carried at", ZERO, step=STEP, hint=AT), place, "at")
        size = gui.add_vector3("box (m)", ZERO, min=ZERO, step=STEP, hint="Its edges; three zeros: a point")
        self._bind(size, place, "size", absent=ZERO)

    def _wrench(self, place: Place) -> None:
        gui = self._gui
        hint = "x, y, z (N), on the robot"
        self._bind(gui.add_vector3("force (N)", ZERO, step=1.0, hint=hint), place, "force")
        hint = "x, y, z (N·m), beside that of the force"
        self._bind(gui.add_vector3("torque (N·m)", ZERO, step=1.0, hint=hint), place, "torque")
        self._bind(gui.add_vector3("acts at", ZERO, step=STEP, hint=AT), place, "at")
        hint = "Axes of force and torque: of the world, or of the base, with which they turn"
        self._bind(gui.add_dropdown("axes", get_args(Frame), hint=hint), place, "frame")
        self._bind(gui.add_number("acts from (s)", 0.0, min=0.0, step=0.1), place, "start")
        end = gui.add_number("acts until (s)", 0.0, min=0.0, step=0.1, hint="0: to the end and beyond")
        self._bind(end, place, "end", absent=0.0)

    def _bind(self, handle: Any, place: Place, name: str, absent: Any = None) -> None:
        """A control of one key of a load; shown as `absent`, the key says nothing."""
        key = f"{place.key}.{name}"

        def read(scenario: Scenario) -> Any:
            load = place.of(scenario)
            value = None if load is None else getattr(load, name)
            return absent if value is None else value

        def write(value: Any) -> Mapping[str, Any]:
            return {key: None if value == absent else list(value) if isinstance(value, tuple) else value}

        self._fields.bind(handle, read, write, key)

    def _choose(self) -> None:
        self._place = int(str(self.which.value).split()[0]) - 1
        self.show(self._actions.scenario)

    def _add(self, name: str) -> None:
        scenario = self._actions.scenario
        kind = next(kind for kind in KINDS if NAMES[kind] == name)
        before = KINDS[: KINDS.index(kind) + 1]
        self._place = sum(place.kind in before for place in places(scenario))  # it comes behind these
        self._actions.change(with_load(scenario, kind), "")

    def _take_away(self) -> None:
        scenario = self._actions.scenario
        there = places(scenario)
        if self._place < len(there):
            self._actions.change(without_load(scenario, there[self._place]), "")
