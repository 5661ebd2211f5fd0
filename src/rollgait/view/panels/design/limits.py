"""Weights and bounds: those that have a value, from the profile or the scenario, and a list of the others."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import viser

from rollgait.scenario.profile import PROFILES
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.weights import Bounds, Weights
from rollgait.view.panels.design.actions import Actions
from rollgait.view.panels.design.fields import Fields, by_a_person, choose

NOT_HERE: Final = frozenset({"without"})
"""Keys with a control of their own."""
HINTS: Final = {
    "box": "Half-sizes of the space of each foot: ahead, aside, up (m)",
    "steering_deg": "Of a wheel against the base: smallest, largest (degrees)",
}
SIZE_STEP: Final = 0.01
"""Of a box, m."""
ADD: Final = "set one more …"
DRIFT: Final = 0.1
"""First value of `touchdown_drift`, m/s."""
SHARE_OF_WEIGHT: Final = 0.75
"""First value of `force_max`, in weights of the robot: one foot seldom carries more."""
UNTOUCHED: Final = 1e-6
"""Step of numbers of any size."""


class LimitsPanel:
    """Weights or bounds of a scenario.

    Args:
        gui: of the page.
        actions: what they do to the draft.
        group: `weights` or `bounds`.
    """

    def __init__(self, gui: viser.GuiApi, actions: Actions, group: str) -> None:
        self._gui, self._actions, self._group = gui, actions, group
        self._fields = Fields(actions.change)
        self.boxes: dict[str, Any] = {}
        with gui.add_folder(group, expand_by_default=False):
            self._rows = gui.add_folder(None)
            self._more: Any = gui.add_dropdown("more", (ADD,))
            usual = gui.add_button("Those of the profile", color="gray")
        self._more.on_update(by_a_person(lambda _: self._add(str(self._more.value))))
        usual.on_click(lambda _: self._actions.change({self._group: {}}, ""))

    def show(self, scenario: Scenario) -> None:
        """Shows what has a value."""
        names = [name for name in _model(self._group).model_fields if name not in NOT_HERE]
        shown = tuple(name for name in names if scenario.value_of(self._group, name) is not None)
        others = tuple(name for name in names if name not in shown)
        choose(self._more, (ADD, *others), ADD)
        self._more.visible = bool(others)
        self._fields.rebuild(shown, self._rows, lambda: self._build(scenario, shown))
        self._fields.show(scenario)

    def _build(self, scenario: Scenario, names: tuple[str, ...]) -> None:
        self.boxes = {name: self._row(scenario, name) for name in names}

    def _row(self, scenario: Scenario, name: str) -> Any:
        group, key = self._group, f"{self._group}.{name}"
        value = scenario.value_of(group, name)
        box: Any
        if isinstance(value, bool):
            box = self._gui.add_checkbox(name, value)
        elif isinstance(value, tuple) and len(value) == 3:
            box = self._gui.add_vector3(name, value, step=SIZE_STEP, hint=HINTS.get(name))
        elif isinstance(value, tuple):
            box = self._gui.add_vector2(name, value, step=1.0, hint=HINTS.get(name))
        else:
            value = float(value)
            low = -1.0 if name in ("com_margin", "capture_margin") else 0.0
            box = self._gui.add_number(name, value, min=low, step=UNTOUCHED)
        kind = type(value)

        def read(now: Scenario) -> Any:
            own = now.value_of(group, name)
            return None if own is None else kind(own)

        return self._fields.bind(box, read, lambda new: {key: new}, key)

    def _add(self, name: str) -> None:
        """One more key gets its first value."""
        if name != ADD:
            value = first_value(self._actions.scenario, self._group, name)
            self._actions.change({f"{self._group}.{name}": value}, "")


def first_value(scenario: Scenario, group: str, name: str) -> Any:
    """What a weight or a bound that the scenario does not have begins with."""
    usual = PROFILES["executable"][group].get(name)
    if usual is not None:
        return usual
    if name == "box":
        return scenario.body.box
    if name == "steering_deg":
        return tuple(round(float(np.degrees(side)), 1) for side in scenario.steering_range(0))
    if name == "force_max":
        return round(SHARE_OF_WEIGHT * scenario.body.weight)
    return DRIFT if name == "touchdown_drift" else 1.0


def _model(group: str) -> type[Weights] | type[Bounds]:
    return Weights if group == "weights" else Bounds
