"""Controls that show keys of the draft and change them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import viser

from rollgait.scenario.scenario import Scenario
from rollgait.view.in_order import show_values

Change = Callable[[Mapping[str, Any], str], None]
"""Takes values by their dotted keys, and the stroke."""
Read = Callable[[Scenario], Any]


class Fields:
    """Controls of which each has its key.

    Args:
        change: what a person sets goes here.
    """

    def __init__(self, change: Change) -> None:
        self._change = change
        self._bound: list[tuple[Any, Read]] = []
        self._built: Any = None

    def bind(self, handle: Any, read: Read, write: Callable[[Any], Mapping[str, Any]], stroke: str) -> Any:
        """A control, how its value is read from a scenario, and which keys a value of it sets."""
        self._bound.append((handle, read))
        handle.on_update(by_a_person(lambda _: self._change(write(handle.value), stroke)))
        return handle

    def key(self, handle: Any, key: str) -> Any:
        """A control of one dotted key of the scenario."""
        return self.bind(handle, lambda scenario: _at(scenario, key), lambda value: {key: value}, key)

    def show(self, scenario: Scenario) -> None:
        """Shows the values of a scenario."""
        put_all((handle, read(scenario)) for handle, read in self._bound)

    def rebuild(self, state: Any, folder: Any, build: Callable[[], None]) -> None:
        """Makes the controls anew if they are those of another state.

        Args:
            state: that says which controls there are.
            folder: of the page, that they stand in.
            build: makes and binds them.
        """
        if state == self._built:
            return
        self._built = state
        for handle, _ in self._bound:
            handle.remove()
        self._bound = []
        with folder:
            build()


def put(handle: Any, value: Any) -> None:
    """Shows a value; not over what a person has set there meanwhile."""
    put_all([(handle, value)])


def put_all(values: Iterable[tuple[Any, Any]]) -> None:
    """Shows values in their controls; None leaves what is there."""
    show_values(
        (handle, tuple(value) if isinstance(value, list) else value)
        for handle, value in values
        if value is not None
    )


def choose(handle: Any, options: tuple[str, ...], value: str) -> None:
    """Shows choices, and which one it is."""
    if tuple(handle.options) != options:
        handle.options = options
    put(handle, value)


def by_a_person(action: Callable[[viser.ClientHandle], None]) -> Callable[[Any], None]:
    """The action, done only for what comes from a browser: our own changes of a control come back, too."""

    def act(event: Any) -> None:
        if event.client is not None:
            action(event.client)

    return act


def _at(scenario: Scenario, key: str) -> Any:
    value: Any = scenario
    for name in key.split("."):
        value = getattr(value, name)
    return value
