"""The benchmarks run, each in its shortest form, with its table and without a trace on the page."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "benchmarks.md"


@pytest.mark.parametrize(
    ("script", "rows"),
    [
        ("table1", 4),
        ("random_goals", 3),
        ("long_horizon", 2),
        ("whole_time", 3),
        ("random_scenarios", 7),
        ("many_goals", 2),
        ("pushes", 1),
        ("loads", 4),
        ("terrain", 1),
        ("timing", 1),
        ("random_worlds", 1),
        ("flat_goals", 3),
        ("look_alikes", 1),
        ("dataset", 9),
    ],
    ids=lambda value: str(value),
)
def test_quick_run_prints_its_table(script: str, rows: int) -> None:
    before = PAGE.read_bytes()
    command = [sys.executable, str(ROOT / "benchmarks" / f"{script}.py"), "--quick"]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", check=False)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].startswith("## ")
    first = next(i for i, line in enumerate(lines) if line.startswith("| ---"))
    body = [line for line in lines[first + 1 : first + 1 + rows] if line.startswith("|")]
    assert len(body) == rows
    assert "not certified" not in done.stdout
    assert PAGE.read_bytes() == before
