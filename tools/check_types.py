"""Checks with mypy, strictly, the ```python blocks of README.md and docs/, and the examples.

The blocks of a page are one module, as a reader types them one after the other. `.venv/bin/python
tools/check_types.py` checks all; with Markdown files as arguments, those. With `--pyright` it asks Pyright
instead, which fetches itself from the network when it is first used: `pip install pyright`, not part of CI.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Final

sys.path.insert(0, str(Path(__file__).parent))
from page_blocks import all_blocks

ROOT: Final = Path(__file__).parents[1]


def module_of(markdown: str) -> str:
    """The Python blocks of a page as one module, each line where it stands on the page."""
    lines = [""] * (markdown.count("\n") + 1)
    for block in all_blocks(markdown):
        if block.language == "python":
            text = block.text.splitlines()
            lines[block.line - 1 : block.line - 1 + len(text)] = text
    return "\n".join(lines) + "\n"


MYPY: Final = (sys.executable, "-m", "mypy", "--strict")
PYRIGHT: Final = (sys.executable, "-m", "pyright", "--pythonpath", sys.executable)


def check(pages: Sequence[Path], modules: Sequence[Path] = (), checker: Sequence[str] = MYPY) -> int:
    """Checks pages and modules; returns the checker's exit status, after what it says."""
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for page in pages:
            text = module_of(page.read_text(encoding="utf-8"))
            if text.strip():
                file = Path(folder) / f"{page.stem.replace('-', '_')}_page.py"
                file.write_text(text, encoding="utf-8")
                files.append(file)
        command = [*checker, *map(str, [*files, *modules])]
        return subprocess.run(command, cwd=ROOT, check=False).returncode


def main(arguments: Sequence[str]) -> int:
    """The pages that are named, or all and the examples."""
    checker = PYRIGHT if "--pyright" in arguments else MYPY
    named = [Path(name) for name in arguments if name != "--pyright"]
    if named:
        return check(named, checker=checker)
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return check(pages, sorted((ROOT / "examples").glob("*.py")), checker)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
