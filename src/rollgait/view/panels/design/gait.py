"""The gait: which, how many steps, when."""

from __future__ import annotations

from typing import Any, Final

import viser

from rollgait.scenario import Crawl, Discover, Pace, Scenario, Trot, Walk
from rollgait.scenario.scenario import LONGEST
from rollgait.view.panels.design.actions import Actions
from rollgait.view.panels.design.fields import Fields, by_a_person, choose, put

DISCOVER: Final = str(Discover.model_fields["kind"].default)
STEPPING: Final[dict[str, Any]] = {
    str(gait.model_fields["kind"].default): gait for gait in (Crawl, Walk, Trot, Pace)
}
"""Gaits that are told by a number of steps."""
GAITS: Final = ("drive", "crawl", "crawl, wheels locked", "walk", "trot", "pace", DISCOVER)
HORIZON_MAX: Final = LONGEST
"""s"""
TIMES: Final[dict[str, tuple[str, float, float]]] = {
    "pause_start": ("stand at first (s)", 0.0, 0.1),
    "pause_end": ("stand at the end (s)", 0.0, 0.1),
    "swing_fraction": ("share of swing", 0.05, 0.05),
}
"""Further keys of stepping gaits: label, smallest value, step."""


class GaitPanel:
    """Gait and horizon.

    Args:
        gui: of the page.
        actions: what they do to the draft.
    """

    def __init__(self, gui: viser.GuiApi, actions: Actions) -> None:
        self._change = actions.change
        self._base: Scenario | None = None
        self._fields, self._times = Fields(actions.change), Fields(actions.change)
        self.gait: Any = gui.add_dropdown("gait", GAITS)
        self.steps: Any = gui.add_number("steps", 8, min=1, max=100, step=1)
        self.horizon: Any = gui.add_number(
            "horizon (s)", 10.0, min=0.5, max=HORIZON_MAX, step=0.5, hint="longest one, with discover"
        )
        with gui.add_folder("timing", expand_by_default=False) as self._folder:
            interval: Any = gui.add_number("interval (s)", 0.1, min=0.02, max=1.0, step=0.01)
            self.best: Any = gui.add_checkbox("best times", False, hint="The order stays, the times change")
            self._boxes: list[Any] = []
            for name, (label, low, step) in TIMES.items():
                box: Any = gui.add_number(label, 1.0, min=low, step=step)
                self._boxes.append(self._times.key(box, f"gait.{name}"))
        self._fields.key(self.horizon, "horizon")
        self._fields.key(interval, "interval")
        self._fields.bind(
            self.best, _best, lambda value: {"gait.timing": {"optimize": True} if value else None}, "best"
        )
        self.gait.on_update(by_a_person(lambda _: self.choose(str(self.gait.value))))
        self.steps.on_update(
            by_a_person(lambda _: self._change({"gait.steps": int(self.steps.value)}, "steps"))
        )

    def show(self, scenario: Scenario) -> None:
        """Shows the gait of a scenario."""
        self._base = scenario
        kind, locked = scenario.gait.kind, scenario.gait.wheels == "locked"
        as_given = () if kind in GAITS else (kind,)
        choose(
            self.gait, (*GAITS, *as_given), f"{kind}, wheels locked" if kind == "crawl" and locked else kind
        )
        steps = kind in STEPPING
        self.steps.visible = steps
        for box in self._boxes:
            box.visible = steps
        self.best.visible = kind not in ("drive", DISCOVER)
        self._fields.show(scenario)
        if steps:
            put(self.steps, getattr(scenario.gait, "steps", 8))
            self._times.show(scenario)

    def choose(self, name: str) -> None:
        """Another gait begins with its own number of steps; one that is to be found may take its time."""
        kind = name.partition(",")[0]
        values: dict[str, Any] = {"gait.kind": kind}
        if kind in ("drive", "crawl"):
            values["gait.wheels"] = "locked" if "locked" in name else "rolling"
        if kind == DISCOVER:
            values["horizon"] = HORIZON_MAX
        elif kind in STEPPING:
            values["gait.steps"] = int(STEPPING[kind].model_fields["steps"].default)
        if self._base is not None and self._base.gait.kind == kind:
            del values["gait.kind"]  # it keeps its order and its times
        self._change(values, "")


def _best(scenario: Scenario) -> bool:
    timing = scenario.gait.timing
    return timing is not None and timing.optimize
