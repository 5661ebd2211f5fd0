"""What a user waits for: whole plans in a warm process, and whole processes from cold.

    python benchmarks/whole_time.py [--runs 5] [--quick]

Warm: `rollgait.plan` of each of the paper's motions, then of another goal and of another gait in the same
process, with where the time went. Cold: `import rollgait`, `rollgait --help` and `rollgait plan`, kernels in
the cache. Medians; prints Markdown and keeps it in docs/benchmarks.md.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from statistics import median

import rollgait as rg
from reporting import keep, load, machine, table

MOTIONS = ("legged-forward", "wheeled", "hybrid-forward", "hybrid-goback")
OTHER_GOAL = {"goal.x": 0.6, "goal.y": 0.1}
OTHER_GAIT = {"gait": {"kind": "crawl", "steps": 4}}
PARTS = ("load", "build", "guess", "solve", "certify", "other")
COLD = {
    "import rollgait": [sys.executable, "-c", "import rollgait"],
    "rollgait --help": [sys.executable, "-m", "rollgait", "--help"],
    "rollgait plan hybrid-forward": [
        sys.executable,
        "-m",
        "rollgait",
        "plan",
        "hybrid-forward",
        "--out",
        "plan.npz",
    ],
}
"""Whole processes, run in an empty folder."""


def warm(motions: tuple[str, ...], runs: int) -> str:
    """The table of plans in this process; the first of each motion is not counted."""
    rows = []
    for motion in motions:
        scenario = rg.find_scenario(motion)
        cases: Mapping[str, Callable[[], rg.Scenario]] = {
            motion: lambda asked=scenario: asked,
            "… another goal": lambda asked=scenario: asked.with_values(OTHER_GOAL),
            "… another gait": lambda asked=scenario: asked.with_values(OTHER_GAIT),
        }
        rg.plan(scenario)
        for name, make in cases.items():
            if name.endswith("gait") and motion == "legged-forward":
                continue  # its wheels are locked by its gait
            asked = make()
            wholes, parts, plan = [], [], None
            for _ in range(runs):
                begin = time.perf_counter()
                plan = rg.plan(asked)
                wholes.append(time.perf_counter() - begin)
                parts.append(plan.statistics.seconds)
            assert plan is not None
            split = (f"{median(part.get(name, 0.0) for part in parts):.3f}" for name in PARTS)
            passed = "yes" if plan.certificate().passed else "no"
            rows.append((name, f"{median(wholes):.2f}", *split, plan.statistics.iterations, passed))
    return table(("`rollgait.plan`, warm", "whole, s", *PARTS, "iterations", "certified"), rows)


def cold(runs: int) -> str:
    """The table of whole processes."""
    rows = []
    # compiled Python files are kept, as they are where the package is installed
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    with tempfile.TemporaryDirectory() as folder:
        for name, command in COLD.items():
            times = []
            for _ in range(runs + 1):
                begin = time.perf_counter()
                subprocess.run(
                    command, cwd=Path(folder), env=environment, stdout=subprocess.DEVNULL, check=True
                )
                times.append(time.perf_counter() - begin)
            rows.append((name, f"{median(times[1:]):.2f}"))
    return table(("process, cold", "s"), rows)


def main() -> None:
    """Measures, prints and keeps both tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=5, help="runs of each (default: 5)")
    parser.add_argument("--quick", action="store_true", help="one motion, one run: to see that it works")
    options = parser.parse_args()
    motions, runs = (("wheeled",), 1) if options.quick else (MOTIONS, options.runs)
    before = load()
    tables = (warm(motions, runs), cold(runs))
    text = "\n\n".join(
        ["## What a user waits for", f"{machine()}; load {before} before, {load()} after.", *tables]
    )
    print(text)
    if not options.quick:
        keep("whole_time", text)


if __name__ == "__main__":
    main()
