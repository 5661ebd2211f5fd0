"""The scenario that is being designed, and those before it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from rollgait.errors import RollgaitError
from rollgait.scenario.scenario import Scenario

HISTORY_MAX: Final = 200
"""Scenarios that undo knows: a long afternoon's."""
STROKE: Final = 1.5
"""Changes of one thing that follow each other so closely are one, s: a drag, a number that is typed."""


@dataclass(frozen=True)
class Version:
    """A scenario with its name."""

    scenario: Scenario
    name: str


class Draft:
    """One scenario, always right in itself; `fault` says why it cannot be planned all the same.

    Args:
        scenario: with which it begins.
        name: of the scenario.
        on_change: is called after every change.
        clock: seconds that only go on.

    Attributes:
        fault: what is wrong with start, goals or gait on this ground, "" if nothing is.
    """

    def __init__(
        self,
        scenario: Scenario,
        name: str,
        on_change: Callable[[], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._now = Version(scenario, name)
        self._before: list[Version] = []
        self._after: list[Version] = []
        self._on_change, self._clock = on_change, clock
        self._stroke, self._at = "", 0.0
        self.fault = _fault(scenario)

    @property
    def scenario(self) -> Scenario:
        """What is asked for now."""
        return self._now.scenario

    @property
    def name(self) -> str:
        """What a person calls it."""
        return self._now.name

    @property
    def can_undo(self) -> bool:
        """Whether there is a scenario before this one."""
        return bool(self._before)

    @property
    def can_redo(self) -> bool:
        """Whether something was undone."""
        return bool(self._after)

    def change(self, values: Mapping[str, Any], stroke: str = "") -> None:
        """Sets dotted keys.

        Args:
            values: by their keys.
            stroke: what is being changed: changes of the same in quick succession are undone at once.

        Raises:
            InputError: there is no such key, or a value is out of its range; the draft stays as it was.
        """
        self.put(self.scenario.edited(values), self.name, stroke)

    def put(self, scenario: Scenario, name: str, stroke: str = "") -> None:
        """Goes on with another scenario."""
        if scenario.to_dict() == self.scenario.to_dict() and scenario.ground.heights is (
            self.scenario.ground.heights
        ):
            self._become(Version(scenario, name))  # nothing to undo, but controls may show something else
            return
        now = self._clock()
        if not (stroke and stroke == self._stroke and now - self._at <= STROKE and self._before):
            self._before = [*self._before, self._now][-HISTORY_MAX:]
        self._after = []
        self._stroke, self._at = stroke, now
        self._become(Version(scenario, name))

    def undo(self) -> None:
        """The scenario before, if there is one."""
        if self._before:
            self._after.append(self._now)
            self._stroke = ""
            self._become(self._before.pop())

    def redo(self) -> None:
        """What was undone, if anything was."""
        if self._after:
            self._before.append(self._now)
            self._stroke = ""
            self._become(self._after.pop())

    def _become(self, version: Version) -> None:
        if version.scenario is not self.scenario:
            self.fault = _fault(version.scenario)
        self._now = version
        self._on_change()


def _fault(scenario: Scenario) -> str:
    try:
        scenario.check()
    except RollgaitError as error:
        return str(error)
    return ""
