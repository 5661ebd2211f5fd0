"""What controls of the draft may do."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rollgait.diagnosis.report import Suggestion
from rollgait.scenario.scenario import Scenario
from rollgait.view.design.draft import Draft
from rollgait.view.design.handles import Selection


class Actions:
    """What the buttons of the tab do; `Designer` is all of it."""

    draft: Draft

    @property
    def scenario(self) -> Scenario:
        """The one that is designed now."""
        return self.draft.scenario

    def change(self, values: Mapping[str, Any], stroke: str = "") -> None:
        """Changes the draft."""
        raise NotImplementedError

    def select(self, what: Selection) -> None:
        """Gives the handle in the scene to something."""
        raise NotImplementedError

    def pick(self, name: str) -> None:
        """Begins with a scenario of the library."""
        raise NotImplementedError

    def step_back(self) -> None:
        """Undoes."""
        raise NotImplementedError

    def step_ahead(self) -> None:
        """Does again what was undone."""
        raise NotImplementedError

    def take_map(self, file: Any, keys: dict[str, Any]) -> None:
        """Puts the draft on a map."""
        raise NotImplementedError

    def take(self, suggestion: Suggestion) -> None:
        """Takes up what would help."""
        raise NotImplementedError
