"""Constraints that are left out of the problem."""

from __future__ import annotations

from typing import Any, Final

import viser

from rollgait.scenario.scenario import Scenario
from rollgait.view.panels.design.actions import Actions
from rollgait.view.panels.design.fields import Fields, by_a_person, choose

KEY: Final = "bounds.without"
ADD: Final = "leave one out …"


class TermsPanel:
    """The names in `bounds.without`. Costs are not here: their weight 0 says the same.

    Args:
        gui: of the page.
        actions: what they do to the draft.
    """

    def __init__(self, gui: viser.GuiApi, actions: Actions) -> None:
        self._gui, self._actions = gui, actions
        self._fields = Fields(actions.change)
        with gui.add_folder("constraints left out", expand_by_default=False):
            self._rows = gui.add_folder(None)
            self._more: Any = gui.add_dropdown("without", (ADD,))
        self._more.on_update(by_a_person(lambda _: self._leave_out(str(self._more.value))))

    def show(self, scenario: Scenario) -> None:
        """Shows what is left out, and what else could be."""
        out = scenario.bounds.without
        choose(self._more, (ADD, *(name for name in removable(scenario) if name not in out)), ADD)
        self._fields.rebuild(out, self._rows, lambda: self._build(out))
        self._fields.show(scenario)

    def _build(self, names: tuple[str, ...]) -> None:
        for name in names:
            self._row(name)

    def _row(self, name: str) -> None:
        """A switch that brings a constraint back."""
        box = self._gui.add_checkbox(f"without {name}", True)
        self._fields.bind(
            box, lambda now: name in now.bounds.without, lambda out: {KEY: self._with(name, out)}, ""
        )

    def _with(self, name: str, left_out: bool) -> list[str]:
        names = self._actions.scenario.bounds.without
        return [*(each for each in names if each != name), *([name] if left_out else [])]

    def _leave_out(self, name: str) -> None:
        if name != ADD:
            self._actions.change({KEY: self._with(name, True)}, "")


def removable(scenario: Scenario) -> list[str]:
    """The constraints that a motion could do without and still be one of this robot on this ground."""
    from rollgait.ocp.problem import standard_terms  # here: it needs CasADi
    from rollgait.ocp.term import Cost, Role

    return [
        term.name
        for term in standard_terms(scenario)
        if not isinstance(term, Cost) and term.role is not Role.PHYSICS
    ]
