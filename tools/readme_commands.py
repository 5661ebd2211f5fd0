"""Runs every ```bash and ```python block of a Markdown file, in order, in one temporary folder.

A block after the line `<!-- not run: REASON -->` is skipped. Commands are found in the environment of the
Python that runs this: `.venv/bin/python tools/readme_commands.py README.md`.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

BLOCK = re.compile(
    r"(?P<skip><!-- not run: [^>]*-->\n)?^```(?P<language>bash|python)\n(?P<text>.*?)^```$", re.M | re.S
)


def blocks(markdown: str) -> list[tuple[str, str]]:
    """The language and text of each block that is to be run."""
    return [(m["language"], m["text"]) for m in BLOCK.finditer(markdown) if not m["skip"]]


def run_blocks(path: Path) -> int:
    """Runs the blocks; returns the exit status of the first that fails, else 0."""
    environment = dict(os.environ)
    environment["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{environment['PATH']}"
    with tempfile.TemporaryDirectory() as folder:
        for language, text in blocks(path.read_text(encoding="utf-8")):
            print("\n".join(f"  {line}" for line in text.splitlines()), flush=True)
            command = (
                ["bash", "-euo", "pipefail", "-c", text]
                if language == "bash"
                else [sys.executable, "-c", text]
            )
            done = subprocess.run(
                command, cwd=folder, env=environment, capture_output=True, text=True, check=False
            )
            if done.returncode:
                print(done.stdout, done.stderr, sep="\n", file=sys.stderr)
                print(f"error: a block of {path} ended with status {done.returncode}", file=sys.stderr)
                return done.returncode
    return 0


if __name__ == "__main__":
    sys.exit(run_blocks(Path(sys.argv[1])))
