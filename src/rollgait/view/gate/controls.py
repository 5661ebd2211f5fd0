"""Values of controls: of the control's own kind, among its choices, cut to its range."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import viser

from rollgait.view.gate.messages import RefusedError, check, shown


class Controls:
    """The controls of a page.

    Args:
        gui: of the page.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        self._gui = gui

    def find(self, uuid: str) -> Any:
        """The handle of a control. Raises `RefusedError`."""
        handle = self._gui._gui_input_handle_from_uuid.get(uuid)  # viser tells it in no other way
        if handle is None:
            raise RefusedError(f"there is no control {shown(uuid)}")
        return handle

    def cut(self, uuid: str, updates: Mapping[Any, Any]) -> dict[str, Any]:
        """What a page sets of a control, as it may be set. Raises `RefusedError`."""
        handle = self.find(uuid)
        if set(updates) != {"value"}:
            raise RefusedError(f"{shown(sorted(map(str, updates)))} of a control cannot be set")
        try:
            value = value_for(handle, updates["value"])
        except RefusedError as refused:
            raise RefusedError(f"{handle.label}: {refused}") from None
        return {"value": value}


def value_for(handle: Any, value: Any) -> Any:
    """A value for a control, cut to its range. Raises `RefusedError`."""
    if getattr(handle, "disabled", False):
        raise RefusedError("it is switched off")
    if isinstance(handle, viser.GuiButtonHandle | viser.GuiCheckboxHandle):
        if not isinstance(value, bool):
            raise RefusedError(f"{shown(value)} is neither true nor false")
        return value
    if isinstance(handle, viser.GuiDropdownHandle | viser.GuiButtonGroupHandle):
        if not isinstance(value, str) or value not in handle.options:
            raise RefusedError(f"{shown(value)} is no choice")
        return value
    if isinstance(handle, viser.GuiSliderHandle | viser.GuiNumberHandle):
        return _within(value, handle.min, handle.max)
    if isinstance(handle, viser.GuiVector2Handle | viser.GuiVector3Handle):
        count = 3 if isinstance(handle, viser.GuiVector3Handle) else 2
        if not isinstance(value, list | tuple) or len(value) != count:
            raise RefusedError(f"{shown(value)} is not {'three' if count == 3 else 'two'} numbers")
        lows, highs = handle.min or (None,) * count, handle.max or (None,) * count
        return [_within(*parts) for parts in zip(value, lows, highs, strict=True)]
    raise RefusedError("a page cannot set it")


def _within(value: Any, low: float | None, high: float | None) -> float:
    if isinstance(value, bool) or not isinstance(value, float | int):
        raise RefusedError(f"{shown(value)} is no number")
    check("value", value)
    if low is not None and value < low:
        return low
    return high if high is not None and value > high else value
