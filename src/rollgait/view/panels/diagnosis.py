"""Why there is no plan: what is in the way, and buttons that take up what would help."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any

import viser

from rollgait.diagnosis.report import Diagnosis, Reason, Suggestion


class DiagnosisPanel:
    """What is in the way of a plan. `on_take` gets the suggestion whose button is pressed."""

    def __init__(self, gui: viser.GuiApi, on_take: Callable[[Suggestion], None]) -> None:
        self._gui, self._on_take = gui, on_take
        self._reasons = gui.add_html("", visible=False)
        self._place: Any = gui.add_folder("any one of these would help", visible=False)
        self._buttons: list[Any] = []

    def show(self, diagnosis: Diagnosis | None) -> None:
        """Shows a diagnosis; None shows nothing."""
        for button in self._buttons:
            button.remove()
        reasons = () if diagnosis is None else diagnosis.reasons
        suggestions = () if diagnosis is None else tuple(s for s in diagnosis.suggestions if s.change)
        self._reasons.content, self._reasons.visible = _html(reasons), bool(reasons)
        self._place.visible = bool(suggestions)
        with self._place:
            self._buttons = [self._button(suggestion) for suggestion in suggestions]

    def _button(self, suggestion: Suggestion) -> Any:
        settings = ", ".join(f"{key} = {value}" for key, value in suggestion.change.items())
        button = self._gui.add_button(suggestion.text, color="gray", hint=f"Sets {settings}; then press Plan")
        button.on_click(lambda _: self._on_take(suggestion))
        return button


def _html(reasons: tuple[Reason, ...]) -> str:
    """The reasons, those that differ in their leg only as one."""
    legs: dict[str, list[str]] = {}
    for reason in reasons:
        about = f"{reason.begin:.2f} – {reason.end:.2f} s, by {reason.excess:.3g} {reason.unit}".rstrip()
        legs.setdefault(f"{reason.description} ({about})", []).append(reason.leg or "")
    items = "".join(
        f"<li><b>{escape(' '.join(filter(None, names)))}</b> {escape(text)}</li>"
        for text, names in legs.items()
    )
    style = "margin:0 0.75em;font:12px system-ui,sans-serif;line-height:1.4"
    return f'<div style="{style}">In the way:<ul style="margin:0.2em 0;padding-left:1.4em">{items}</ul></div>'
