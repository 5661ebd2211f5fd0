"""What the benchmarks share: Markdown tables, the page that keeps them, and words about the machine."""

from __future__ import annotations

import os
import platform
import re
from collections.abc import Iterable, Sequence
from datetime import date
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "benchmarks.md"
"""Where the results are kept."""
CPU_INFO = Path("/proc/cpuinfo")


def table(columns: Sequence[object], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table; the first column is text, the others are numbers."""
    alignment = ["---", *["---:"] * (len(columns) - 1)]
    lines = [columns, alignment, *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def keep(section: str, text: str, page: Path = PAGE) -> None:
    """Puts a section on the page, in place of what an earlier run has put there."""
    begin, end = f"<!-- begin {section} -->", f"<!-- end {section} -->"
    block = f"{begin}\n\n{text.strip()}\n\n{end}"
    before = page.read_text(encoding="utf-8")
    pattern = re.compile(re.escape(begin) + ".*?" + re.escape(end), re.DOTALL)
    after, count = pattern.subn(lambda _: block, before)
    page.write_text(after if count else f"{before.rstrip()}\n\n{block}\n", encoding="utf-8")


def machine() -> str:
    """Date, cores, CPU and versions, in one line."""
    import casadi
    import numpy

    versions = f"Python {platform.python_version()}, NumPy {numpy.__version__}, CasADi {casadi.__version__}"
    return f"{date.today().isoformat()}; {os.cpu_count()} cores, {_cpu()}; {platform.system()}, {versions}"


def load() -> str:
    """Mean number of busy processes in the last minute, or what is known of it."""
    if not hasattr(os, "getloadavg"):  # Windows
        return "unknown"
    return f"{os.getloadavg()[0]:.2f}"


def _cpu() -> str:
    if CPU_INFO.is_file():
        for line in CPU_INFO.read_text(encoding="utf-8").splitlines():
            name, _, value = line.partition(":")
            if name.strip() == "model name":
                return value.strip()
    return platform.processor() or platform.machine()
