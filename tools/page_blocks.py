"""Runs the code blocks of Markdown pages, each page in a folder and a process of its own.

    .venv/bin/python tools/page_blocks.py README.md docs

runs pages and all pages of folders, two at a time. On a page, in order:

- ```bash is run by bash, ```python by one interpreter for the whole page, as a reader types it;
- ```yaml after `<!-- file: NAME -->` is written to that file, for the blocks below it; after
  `<!-- part of: NAME -->` its keys are put into that scenario of the library, which must still be one;
- ```text is nothing to be run: what a program prints, a drawing;
- a block after `<!-- not run: REASON -->` is skipped; of any other language each must be.

Commands are found in the environment of the Python that runs this.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Final, NamedTuple

FENCE: Final = re.compile(
    r"(?:^<!-- (?P<mark>not run|file|part of): (?P<value>[^>]*?) -->\n)?"
    r"^```(?P<language>[^\n`]*)\n(?P<text>.*?)^```$",
    re.M | re.S,
)
RUN: Final = ("bash", "python", "yaml")
"""Languages that are run."""
PAGES_AT_ONCE: Final = 2
"""The machines that test this have two cores."""


class Block(NamedTuple):
    """A block of a page."""

    language: str
    text: str
    mark: str
    """What the comment before it says: `not run`, `file`, `part of`, or empty."""
    value: str
    """The rest of that comment."""
    line: int
    """Of its first line of text, from 1."""


def all_blocks(markdown: str) -> list[Block]:
    """Every block of a page but the directives of the site."""
    found = []
    for match in FENCE.finditer(markdown):
        language = match["language"].strip()
        if not language.startswith("{"):
            line = markdown.count("\n", 0, match.start("text")) + 1
            found.append(Block(language, match["text"], match["mark"] or "", match["value"] or "", line))
    return found


def blocks(markdown: str) -> list[Block]:
    """The blocks that are to be run."""
    return [block for block in all_blocks(markdown) if block.language in RUN and block.mark != "not run"]


def unexplained(markdown: str) -> list[str]:
    """What is wrong with blocks of a page: neither run nor marked with the reason why not."""
    wrong = []
    for block in all_blocks(markdown):
        if block.mark == "not run" or block.language == "text":
            continue
        if block.language not in RUN:
            wrong.append(f"line {block.line}: {block.language or 'no language'}: is neither run nor marked")
        elif block.language == "yaml" and not block.mark:
            wrong.append(f"line {block.line}: YAML without a file or a scenario that it is part of")
    return wrong


def run_page(page: Path) -> None:
    """Runs the blocks of a page in the current folder; what goes wrong is raised."""
    namespace: dict[str, Any] = {"__name__": "page"}
    for block in blocks(page.read_text(encoding="utf-8")):
        print("\n".join(f"  {line}" for line in block.text.splitlines()), flush=True)
        where, begin = f"{page}:{block.line}", time.monotonic()
        if block.language == "bash":
            subprocess.run(["bash", "-euo", "pipefail", "-c", block.text], check=True)
        elif block.language == "python":
            exec(compile("\n" * (block.line - 1) + block.text, str(page), "exec"), namespace)
        elif block.mark == "file":
            Path(block.value).write_text(block.text, encoding="utf-8")
        else:
            _check_part(block, where)
        print(f"  -- line {block.line}: {time.monotonic() - begin:.1f} s", flush=True)


def _check_part(block: Block, where: str) -> None:
    from rollgait.config import parse_yaml
    from rollgait.scenario.library import find_scenario

    find_scenario(block.value).with_values(parse_yaml(block.text, where))


def run_apart(page: Path) -> tuple[bool, str, float]:
    """Runs a page in an empty folder: whether all went well, what was printed, and how long it took, s."""
    environment = dict(os.environ) | {"MPLBACKEND": "Agg"}
    environment["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{environment['PATH']}"
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, str(Path(__file__).resolve()), "--here", str(page.resolve())],
            cwd=folder,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
    return done.returncode == 0, done.stdout, time.monotonic() - begin


def pages_of(names: Iterable[Path]) -> list[Path]:
    """Pages, and those of folders, that have something to run; those with most of it first, so that no long
    one is left to the end."""
    pages = [page for name in names for page in (sorted(name.rglob("*.md")) if name.is_dir() else [name])]
    count = {page: len(blocks(page.read_text(encoding="utf-8"))) for page in pages}
    return sorted((page for page in pages if count[page]), key=lambda page: -count[page])


def run_all(names: Iterable[Path], all_printed: bool = False) -> int:
    """Runs all pages, two at a time; 1 if a block of one fails, which ends that page only."""
    failed = 0
    pages = pages_of(names)
    with ThreadPoolExecutor(PAGES_AT_ONCE) as pool:
        for page, (good, printed, seconds) in zip(pages, pool.map(run_apart, pages), strict=True):
            print(f"{page}: {seconds:.0f} s", flush=True)
            if not good:
                failed = 1
                print(printed, f"error: a block of {page} fails", sep="\n", file=sys.stderr)
            elif all_printed:
                print(printed, flush=True)
    return failed


def main(arguments: Sequence[str]) -> int:
    """What the command line asks for."""
    parser = argparse.ArgumentParser(description="Runs the code blocks of Markdown pages.")
    parser.add_argument("pages", nargs="+", type=Path, help="pages, or folders of pages")
    parser.add_argument("--here", action="store_true", help="run one page, in this folder and process")
    parser.add_argument(
        "-v", "--verbose", action="store_true", help="show what they print and how long each takes"
    )
    options = parser.parse_args(arguments)
    if not options.here:
        return run_all(options.pages, options.verbose)
    try:
        run_page(options.pages[0])
    except BaseException:  # whatever a page does is its failure
        traceback.print_exc(file=sys.stdout)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
