"""Runs side by side: which one is shown, which is its ghost, and how they compare."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any, Final

import viser

from rollgait.view.clip import Clip
from rollgait.view.design.runs import Run, Runs, differences, figures
from rollgait.view.panels.design.fields import by_a_person, choose
from rollgait.view.panels.motion import DIM

NONE: Final = "none"
CELL: Final = "padding:1px 6px 1px 0;vertical-align:top;overflow-wrap:anywhere"


class RunsPanel:
    """The runs of this page.

    Args:
        gui: of the page.
        runs: that there are.
        show: shows a run, and another one as its ghost.
        design: goes on with the scenario of a run.
        beside: puts the ghost beside the motion, or back onto it.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        runs: Runs,
        show: Callable[[Run, Run | None], None],
        design: Callable[[Run], None],
        beside: Callable[[bool], None],
    ) -> None:
        self._runs, self._show = runs, show
        self.first: Any = gui.add_dropdown("shown", (NONE,))
        self.second: Any = gui.add_dropdown("compared with", (NONE,), hint="Stands behind it as a ghost")
        side: Any = gui.add_checkbox("side by side", False, hint="The ghost moves beside, not inside")
        take: Any = gui.add_button("Go on with this design", icon=viser.Icon.PENCIL, color="gray")
        forget: Any = gui.add_button("Forget this run", icon=viser.Icon.TRASH, color="gray")
        self._table = gui.add_html("")
        self.first.on_update(by_a_person(lambda _: self._chosen()))
        self.second.on_update(by_a_person(lambda _: self._chosen()))
        side.on_update(by_a_person(lambda _: beside(bool(side.value))))
        take.on_click(lambda _: self._with_shown(design))
        forget.on_click(lambda _: self._with_shown(self._forget))
        self.build(None, None)

    def build(self, clip: Clip | None, ghost: Clip | None) -> None:
        """Shows which runs there are, and compares those that are seen."""
        names = tuple(run.name for run in self._runs)
        first, second = self._runs.of(clip), self._runs.of(ghost)
        choose(self.first, (NONE, *names), NONE if first is None else first.name)
        choose(self.second, (NONE, *names), NONE if second is None else second.name)
        self._table.content = _table([run for run in (first, second) if run is not None])

    def _chosen(self) -> None:
        first = self._runs.named(str(self.first.value))
        second = self._runs.named(str(self.second.value))
        if first is not None:
            self._show(first, None if second is first else second)

    def _with_shown(self, action: Callable[[Run], None]) -> None:
        run = self._runs.named(str(self.first.value))
        if run is not None:
            action(run)

    def _forget(self, run: Run) -> None:
        self._runs.remove(run)
        self.build(None, None)


def _table(runs: list[Run]) -> str:
    """Figures of one or two runs in columns, and what was asked differently."""
    if not runs:
        return f'<p style="margin:0.5em 0.75em;color:{DIM}">What is planned or opened is kept here.</p>'
    told = [figures(run.clip) for run in runs]
    keys = list(dict.fromkeys(key for each in told for key in each))
    rows = [(key, [each.get(key, "–") for each in told]) for key in keys]
    lines = [_row("", [f"<b>{escape(run.name)}</b>" for run in runs])]
    lines += [_row(key, [escape(value) for value in values]) for key, values in rows]
    if len(runs) == 2 and runs[0].asked is not None and runs[1].asked is not None:
        different = differences(runs[0].asked, runs[1].asked)
        lines.append(_row("asked differently" if different else "asked alike", ["", ""]))
        lines += [_row(key, [escape(value) for value in values]) for key, values in different.items()]
    return (
        '<div style="margin:0.5em 0.75em"><table style="width:100%;table-layout:fixed;border-spacing:0;'
        f'font:11.5px system-ui,sans-serif;font-variant-numeric:tabular-nums">{"".join(lines)}</table></div>'
    )


def _row(name: str, values: list[str]) -> str:
    cells = "".join(f'<td style="{CELL}">{value}</td>' for value in values)
    return f'<tr><td style="{CELL};color:{DIM}">{escape(name)}</td>{cells}</tr>'
