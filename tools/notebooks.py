"""Executes the notebooks of docs/, each in an empty folder: `.venv/bin/python tools/notebooks.py [FILE …]`.

They are kept without what they print; `--out FOLDER` writes them as executed. The first cell that fails is
shown, and the exit status is 1.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from typing import Final

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError

NOTEBOOKS: Final = Path(__file__).parents[1] / "docs" / "notebooks"
SECONDS: Final = 600
"""For one cell on a busy machine."""


def execute(file: Path) -> nbformat.NotebookNode:
    """A notebook with what its cells print and show. Raises `CellExecutionError`."""
    book = nbformat.read(file, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        resources = {"metadata": {"path": folder}}
        NotebookClient(book, timeout=SECONDS, kernel_name="python3", resources=resources).execute()
    return book


def main() -> int:
    """The notebooks that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="where to write them as executed")
    options = parser.parse_args()
    for file in options.files or sorted(NOTEBOOKS.glob("*.ipynb")):
        print(file.name, flush=True)
        try:
            book = execute(file)
        except CellExecutionError as error:
            print(error, file=sys.stderr)
            return 1
        if options.out is not None:
            options.out.mkdir(parents=True, exist_ok=True)
            nbformat.write(book, options.out / file.name)
    return 0


if __name__ == "__main__":
    sys.exit(main())
