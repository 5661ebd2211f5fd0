"""Checks with mypy, strictly, and with Pyright the ```python blocks of README.md and docs/, and the examples.

The blocks of a page are one module, as a reader types them one after the other. `.venv/bin/python
tools/check_types.py` checks all; with Markdown files as arguments, those. Neither asks the network: the
wheels of the extra `dev` hold Pyright and the Node.js by which it runs.
"""

from __future__ import annotations

import os
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


CHECKERS: Final = (
    (sys.executable, "-m", "mypy", "--strict"),
    (sys.executable, "-m", "pyright", "--pythonpath", sys.executable),
)
OFFLINE: Final = {"PYRIGHT_PYTHON_IGNORE_WARNINGS": "1"}
"""Environment without which Pyright asks the network for its newest version."""


def check(pages: Sequence[Path], modules: Sequence[Path] = ()) -> int:
    """Checks pages and modules; returns the largest exit status of the checkers, after what they say."""
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for page in pages:
            text = module_of(page.read_text(encoding="utf-8"))
            if text.strip():
                file = Path(folder) / f"{page.stem.replace('-', '_')}_page.py"
                file.write_text(text, encoding="utf-8")
                files.append(file)
        sources = [str(file) for file in (*files, *modules)]
        environment = os.environ | OFFLINE
        return max(
            subprocess.run([*checker, *sources], cwd=ROOT, env=environment, check=False).returncode
            for checker in CHECKERS
        )


def main(arguments: Sequence[str]) -> int:
    """The pages that are named, or all and the examples."""
    if arguments:
        return check([Path(name) for name in arguments])
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return check(pages, sorted((ROOT / "examples").glob("*.py")))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
