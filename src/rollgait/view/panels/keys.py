"""Which keys do what."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

import viser

from rollgait.view.panels.motion import DIM


def add_keys(gui: viser.GuiApi, keys: Mapping[str, str]) -> None:
    """A folded table of keys and what they do, below everything else."""
    rows = "".join(
        f'<tr><td style="white-space:nowrap;padding-right:1em"><kbd>{escape(key)}</kbd></td>'
        f'<td style="color:{DIM}">{escape(meaning)}</td></tr>'
        for key, meaning in keys.items()
    )
    with gui.add_folder("keys and mouse", expand_by_default=False, order=9.0):
        gui.add_html(
            f'<table style="margin:0 0.5em;font:12px system-ui,sans-serif;line-height:1.6">{rows}</table>'
        )
