"""What judges the motion: the moments nearest to a limit, to be clicked, and all rows."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any, Literal

import viser

from rollgait.plan.plan import Plan
from rollgait.view.clip import Clip
from rollgait.view.marks import Mark, measure
from rollgait.view.panels.motion import BAD, DIM, GOOD

SHADES = {"pass": GOOD, "fail": BAD, "not promised": DIM}


class CertificatePanel:
    """Buttons that go to the worst moments, and the rows of the certificate."""

    def __init__(self, gui: viser.GuiApi, place: Any, go: Callable[[float], None]) -> None:
        self._gui, self._place, self._go = gui, place, go
        self._handles: list[Any] = []

    def build(self, clip: Clip) -> None:
        """The marks of a clip, and the certificate of a plan."""
        for handle in self._handles:
            handle.remove()
        note = "Nearest to a limit: click to go there." if clip.marks else "Nothing is near a limit."
        with self._place:
            self._handles = [self._gui.add_markdown(note)]
            self._handles += [self._button(number, mark) for number, mark in enumerate(clip.marks, start=1)]
            if clip.plan is not None:
                self._handles.append(self._gui.add_html(_table(clip.plan)))

    def _button(self, number: int, mark: Mark) -> Any:
        """A button that goes to a moment."""
        colour: Literal["red", "gray"] = "red" if mark.failed else "gray"
        button = self._gui.add_button(f"{number}  {mark.label}", hint=mark.value, color=colour)
        button.on_click(lambda _: self._go(mark.time))
        return button


def _table(plan: Plan) -> str:
    """All rows of the certificate as an HTML table."""
    rows = []
    for row in plan.certificate().rows:
        value = measure(row.worst, row.limit, row.unit, row.sense == "at least")
        rows.append(
            f'<tr title="{escape(row.description)}"><td>{escape(row.name)}</td>'
            f'<td style="text-align:right;white-space:nowrap">{escape(value)}</td>'
            f"<td>{escape(row.leg or '')}</td>"
            f'<td style="text-align:right">{"" if row.time is None else f"{row.time:.2f}"}</td>'
            f'<td style="color:{SHADES[row.verdict]}">{_SIGNS[row.verdict]}</td></tr>'
        )
    return (
        '<div style="margin:0.5em 0.75em;overflow-x:auto">'
        '<table style="width:100%;border-spacing:0.4em 0.15em;'
        'font:11px system-ui,sans-serif;font-variant-numeric:tabular-nums">'
        "<tr style='text-align:left;color:#888'><th>row</th><th>worst and limit</th><th>leg</th><th>s</th>"
        f"<th></th></tr>{''.join(rows)}</table></div>"
    )


_SIGNS = {"pass": "✓", "fail": "✗", "not promised": "–"}
