"""Weights and bounds: those that have a value, from the profile or the scenario, and a list of the others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import viser

from rollgait.scenario.profile import PROFILES
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.weights import Bounds, Weights
from rollgait.view.panels.design.fields import Change, Fields, by_a_person, choose

NOT_HERE: Final = frozenset({"box", "steering_deg", "without"})
"""Keys that are no single number or switch: the YAML file has them."""
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
        change: of the draft.
        scenario: that is designed now.
        group: `weights` or `bounds`.
    """

    def __init__(
        self, gui: viser.GuiApi, change: Change, scenario: Callable[[], Scenario], group: str
    ) -> None:
        self._gui, self._change, self._scenario, self._group = gui, change, scenario, group
        self._fields = Fields(change)
        self._shown: tuple[str, ...] = ()
        self.boxes: dict[str, Any] = {}
        with gui.add_folder(group, expand_by_default=False):
            self._rows = gui.add_folder(None)
            self._more: Any = gui.add_dropdown("more", (ADD,))
            usual = gui.add_button("Those of the profile", color="gray")
        self._more.on_update(by_a_person(lambda _: self._add(str(self._more.value))))
        usual.on_click(lambda _: self._change({self._group: {}}, ""))

    def show(self, scenario: Scenario) -> None:
        """Shows what has a value."""
        names = [name for name in _model(self._group).model_fields if name not in NOT_HERE]
        shown = tuple(name for name in names if scenario.value_of(self._group, name) is not None)
        others = tuple(name for name in names if name not in shown)
        choose(self._more, (ADD, *others), ADD)
        self._more.visible = bool(others)
        if shown != self._shown:
            self._shown = shown
            self._fields.forget()
            with self._rows:
                self.boxes = {name: self._row(scenario, name) for name in shown}
        self._fields.show(scenario)

    def _row(self, scenario: Scenario, name: str) -> Any:
        group, key = self._group, f"{self._group}.{name}"
        value = scenario.value_of(group, name)
        if isinstance(value, bool):
            box: Any = self._gui.add_checkbox(name, value)
            read: Callable[[Scenario], Any] = lambda now: bool(now.value_of(group, name))  # noqa: E731
        else:
            low = -1.0 if name in ("com_margin", "capture_margin") else 0.0
            box = self._gui.add_number(name, float(value), min=low, step=UNTOUCHED)
            read = lambda now: float(now.value_of(group, name) or 0.0)  # noqa: E731
        return self._fields.bind(box, read, lambda new: {key: new}, key)

    def _add(self, name: str) -> None:
        """One more key gets its first value."""
        if name != ADD:
            self._change({f"{self._group}.{name}": first_value(self._scenario(), self._group, name)}, "")


def first_value(scenario: Scenario, group: str, name: str) -> Any:
    """What a weight or a bound that the scenario does not have begins with."""
    usual = PROFILES["executable"][group].get(name)
    if usual is not None:
        return usual
    if name == "force_max":
        return round(SHARE_OF_WEIGHT * scenario.body.weight)
    return DRIFT if name == "touchdown_drift" else 1.0


def _model(group: str) -> type[Weights] | type[Bounds]:
    return Weights if group == "weights" else Bounds
