"""How long does planning take? The paper's four motions by every way of solving them.

    python benchmarks/table1.py [--runs 5] [--reference-runs 1] [--quick]

Each run is a process of its own, `rollgait plan …`, from its start to the file that it writes; compiled
kernels are on disk before. Times within are those that the plan states. Figures are medians over the runs,
which go round so that a change of the machine's load meets all ways alike. Prints Markdown and keeps it in
docs/benchmarks.md.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from statistics import median
from typing import Any

from reporting import keep, load, machine, table

MOTIONS = {"legged-forward": 19.0, "wheeled": 20.0, "hybrid-forward": 98.0, "hybrid-goback": 63.0}
"""The paper's four motions and its times (Table I), s."""
PROFILES = ("executable", "paper")
INTERVALS = (0.1, 0.05)
"""s"""
REFERENCE = "collocation + IPOPT"
COMPILED = "condensed + fatrop, compiled"
UNCOMPILED = "condensed + fatrop"
METHODS = {
    REFERENCE: ("--transcription", "collocation", "--solver", "ipopt"),
    "condensed + IPOPT": ("--transcription", "condensed", "--solver", "ipopt"),
    UNCOMPILED: ("--no-kernels",),
    COMPILED: (),
}
"""Ways of solving, and how they are asked for."""
COLD_GOAL, RATIO_GOAL = 1.2, 20.0
"""Goals for the profile `executable` at 0.1 s: cold process (s) and how much faster than the reference."""
SOLVE_GOALS = {"hybrid-goback": (0.5, 1.5)}
"""Goals for the time in the solver, compiled and not, s; of the other motions:"""
SOLVE_GOAL = (0.2, 0.6)


@dataclass(frozen=True)
class Problem:
    """What is planned."""

    motion: str
    profile: str
    interval: float


@dataclass(frozen=True)
class Run:
    """One process: how long it lived (s), and what it said of the plan; nothing where it was cut off."""

    cold: float
    said: dict[str, Any] | None

    @property
    def statistics(self) -> dict[str, Any]:
        """Of the plan; empty if there is none."""
        return (self.said or {}).get("statistics") or {}


def run(problem: Problem, method: str, timeout: float) -> Run:
    """Plans in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        command = [
            *(sys.executable, "-m", "rollgait", "plan", problem.motion, "--json"),
            *("--profile", problem.profile, "--set", f"interval={problem.interval}"),
            *("--out", str(Path(folder) / "plan.npz"), *METHODS[method]),
        ]
        begin = time.perf_counter()
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
        except subprocess.TimeoutExpired:
            return Run(timeout, None)
        cold = time.perf_counter() - begin
    return Run(cold, json.loads(done.stdout) if done.stdout else {"message": done.stderr})


@dataclass(frozen=True)
class Result:
    """The medians over runs of the same."""

    method: str
    runs: tuple[Run, ...]

    @property
    def finished(self) -> bool:
        """Whether every run ended by itself."""
        return all(r.said is not None for r in self.runs)

    @property
    def cold(self) -> float:
        """Time of the process, s."""
        return median(r.cold for r in self.runs)

    def value(self, name: str) -> float:
        """A figure of the plan's statistics; not-a-number if there is none."""
        return median(float(r.statistics.get(name, "nan")) for r in self.runs)

    @property
    def certified(self) -> str:
        """Whether the plans are."""
        if not self.finished:
            return "not finished"
        words = {bool(r.said and r.said.get("certified")) for r in self.runs}
        return {(True,): "yes", (False,): "no"}.get(tuple(words), "not always")


Results = dict[Problem, dict[str, Result]]


def measure(
    problems: list[Problem], runs: int, reference_runs: int, timeout: float, budget: float
) -> Results:
    """All runs, round after round; the reference's are spread over the rounds, as long as time is left."""
    begin = time.perf_counter()
    found: dict[tuple[Problem, str], list[Run]] = {}
    quick = [(p, m) for p, m in product(problems, METHODS) if m != REFERENCE]
    # coarse meshes first: they are what the goals are about
    slow = [(p, REFERENCE) for p in sorted(problems, key=lambda p: -p.interval)] * reference_runs
    share = -(-len(slow) // runs)
    for problem in problems:
        run(problem, COMPILED, timeout)  # puts the kernels on disk
    for number in range(runs):
        for problem, method in quick + slow[number * share : (number + 1) * share]:
            left = budget - (time.perf_counter() - begin)
            if method == REFERENCE and left < timeout:
                continue
            print(f"\r\033[Kround {number + 1}: {problem} {method}", end="", file=sys.stderr, flush=True)
            found.setdefault((problem, method), []).append(run(problem, method, timeout))
    print(file=sys.stderr)
    return {p: {m: Result(m, tuple(found[p, m])) for m in METHODS if (p, m) in found} for p in problems}


def tables(results: Results) -> Iterator[str]:
    """One table for each motion."""
    columns = (
        *("profile, interval, method", "runs", "process s", "build s", "solve s", "iterations", "cost"),
        *("certified", "solve: × reference", "× paper"),
    )
    for motion in dict.fromkeys(problem.motion for problem in results):
        mine = [(p, r) for p, by_method in results.items() if p.motion == motion for r in by_method.values()]
        rows = [_row(p, r, results[p].get(REFERENCE)) for p, r in mine]
        yield f"**{motion}** (the paper: {MOTIONS[motion]:.0f} s)\n\n{table(columns, rows)}"


def _row(problem: Problem, result: Result, reference: Result | None) -> tuple[object, ...]:
    name = f"{problem.profile}, {problem.interval} s, {result.method}"
    if not result.finished:
        return name, len(result.runs), f"> {result.cold:.0f}", *[""] * 4, result.certified, "", ""
    solve = result.value("solve_time")
    return (
        name,
        len(result.runs),
        f"{result.cold:.2f}",
        f"{result.value('build_time'):.2f}",
        f"{solve:.3f}",
        f"{result.value('iterations'):.0f}",
        f"{result.value('cost'):.2f}",
        result.certified,
        _times(_reference_time(reference), solve),
        f"{MOTIONS[problem.motion] / solve:.0f}",
    )


def _reference_time(reference: Result | None) -> tuple[str, float]:
    """The reference's time in the solver; a lower bound if it was cut off."""
    if reference is None:
        return "", float("nan")
    return ("", reference.value("solve_time")) if reference.finished else ("> ", reference.cold)


def _times(reference: tuple[str, float], solve: float) -> str:
    sign, time_needed = reference
    return f"{sign}{time_needed / solve:.1f}"


def goals(results: Results) -> str:
    """What was measured, and in brackets what we aim at."""
    rows = []
    for problem, by_method in results.items():
        if (problem.profile, problem.interval) != ("executable", 0.1):
            continue
        limits = SOLVE_GOALS.get(problem.motion, SOLVE_GOAL)
        compiled, uncompiled = by_method[COMPILED], by_method[UNCOMPILED]
        sign, reference = _reference_time(by_method.get(REFERENCE))
        ratio = reference / compiled.value("solve_time")
        rows.append(
            (
                problem.motion,
                _with_aim(compiled.value("solve_time"), limits[0]),
                _with_aim(uncompiled.value("solve_time"), limits[1]),
                _with_aim(compiled.cold, COLD_GOAL),
                f"{sign}{ratio:.0f} (at least {RATIO_GOAL:.0f})",
            )
        )
    columns = (
        "executable, 0.1 s; in brackets: aim",
        "solve, compiled, s",
        "not compiled, s",
        "process, s",
        "× reference",
    )
    return table(columns, rows) if rows else ""


def _with_aim(value: float, limit: float) -> str:
    return f"{value:.2f} (at most {limit})"


def main() -> None:
    """Measures, prints and keeps the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=5, help="runs of each way (default: 5)")
    parser.add_argument(
        "--reference-runs", type=int, default=1, help=f"runs of {REFERENCE}, which takes long (default: 1)"
    )
    parser.add_argument(
        "--timeout", type=float, default=180.0, help="s after which a process is given up (default: 180)"
    )
    parser.add_argument(
        "--budget", type=float, default=1800.0, help=f"s after which no {REFERENCE} is begun (default: 1800)"
    )
    parser.add_argument("--quick", action="store_true", help="one motion, one run: to see that it works")
    options = parser.parse_args()
    if options.quick:
        problems, runs, reference_runs = [Problem("wheeled", "paper", 0.1)], 1, 1
    else:
        problems = [Problem(*which) for which in product(MOTIONS, PROFILES, INTERVALS)]
        runs, reference_runs = options.runs, options.reference_runs
    before = load()
    results = measure(problems, runs, reference_runs, options.timeout, options.budget)
    text = "\n\n".join(
        [
            "## The paper's four motions",
            f"{machine()}; load {before} before, {load()} after. The reference is {REFERENCE}.",
            *tables(results),
            *filter(None, [goals(results)]),
        ]
    )
    print(text)
    if not options.quick:
        keep("table1", text)


if __name__ == "__main__":
    main()
