"""Text on the terminal: aligned columns, JSON, and one-line errors."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from rollgait.cli.verbosity import Verbosity, stdout_of_data, verbosity
from rollgait.errors import readable

if TYPE_CHECKING:
    from rich.console import Console

STYLES = {"pass": "green", "fail": "bold red", "not promised": "dim", "not certified": "bold red"}
"""Colours of words that stand alone in a cell; only terminals show them."""

MILLI = 1e3
"""Thousandths of an SI unit in one: people read mm and ms."""

NEGLIGIBLE = 1e-12
"""What a person reads as 0: rounding errors of sums, in SI units."""


@lru_cache
def console_of_stderr() -> Console:
    """One console for all that writes to stderr, so that lines do not run into a progress line."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, soft_wrap=True)


def print_error(message: str) -> None:
    """One line on stderr."""
    print("error:", " ".join(readable(message).split()), file=sys.stderr)


def print_note(message: str) -> None:
    """One dim line on stderr, unless nothing but errors is wanted."""
    if verbosity() is Verbosity.QUIET:
        return
    from rich.text import Text

    console_of_stderr().print(Text(" ".join(readable(message).split()), style="dim"))


def print_json(data: Any) -> None:
    """JSON on stdout; numbers that are not finite, which JSON does not have, become null."""
    print(json.dumps(_finite(data), indent=2, ensure_ascii=False), file=stdout_of_data())


def print_table(rows: Sequence[Sequence[str]], right: Sequence[int] = (), indent: int = 2) -> None:
    """Rows in aligned columns, two spaces apart, never wrapped.

    Args:
        rows: cells of text, all rows of one length.
        right: columns that are flush right, as numbers are.
        indent: spaces at the beginning of each line.
    """
    from rich.console import Console
    from rich.text import Text

    rows = [[readable(cell) for cell in row] for row in rows]
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    console = Console(highlight=False, soft_wrap=True)
    for row in rows:
        line = Text(" " * indent)
        for column, (cell, width) in enumerate(zip(row, widths, strict=True)):
            padding = " " * (width - len(cell))
            text = Text(cell, STYLES.get(cell, ""))
            line.append_text(Text(padding) + text if column in right else text + Text(padding))
            line.append("  ")
        line.rstrip()
        console.print(line)


def number(value: float | None, digits: int = 3) -> str:
    """A number for a person: some significant digits, no needless exponent; "–" for none."""
    if value is None or math.isnan(value):
        return "–"
    if abs(value) < NEGLIGIBLE:
        return "0"
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text and abs(value) < 1e6 else text


def _finite(data: Any) -> Any:
    if isinstance(data, Mapping):
        return {key: _finite(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_finite(value) for value in data]
    if hasattr(data, "item"):  # a NumPy scalar
        data = data.item()
    return None if isinstance(data, float) and not math.isfinite(data) else data
