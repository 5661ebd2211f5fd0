"""How often does planning succeed? Plans to random goals and counts the plans that a certificate accepts.

    python benchmarks/random_goals.py [--count 200] [--seed 0] [--workers 2] [--quick]

Half of the goals are driven to, half with steps, each within |x| ≤ 1.5 m, |y| ≤ 0.8 m, |yaw| ≤ 90°. Prints
Markdown and keeps it in docs/benchmarks.md: how many were solved and certified, from which start, and
everything that failed with its reason.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context

import numpy as np

import rollgait as rg
from reporting import keep, load, machine, table

SCENARIOS = ("wheeled", "hybrid-forward")
"""One half of the goals each."""
BOUNDS = np.array([1.5, 0.8, 90.0])
"""Largest |x| (m), |y| (m) and |yaw| (degrees) of a goal."""
PERCENTILES = (50, 90, 99, 100)


@dataclass(frozen=True)
class Case:
    """A scenario and its goal: x (m), y (m), yaw (degrees)."""

    number: int
    scenario: str
    goal: tuple[float, float, float]

    def asked(self) -> rg.Scenario:
        """The scenario to be planned."""
        x, y, yaw = self.goal
        goal = {"goal.x": x, "goal.y": y, "goal.yaw_deg": yaw}
        return rg.find_scenario(self.scenario).with_values(goal)


@dataclass(frozen=True)
class Outcome:
    """What came of a case. `reason` says why it is not certified; "" if it is."""

    case: Case
    solved: bool = False
    reason: str = ""
    start: str = ""
    starts: int = 0
    iterations: int = 0
    solve_time: float = 0.0
    time: float = 0.0

    @property
    def certified(self) -> bool:
        """Whether there is a plan that the certificate accepts."""
        return self.solved and not self.reason


def cases(count: int, seed: int) -> Iterator[Case]:
    """The same ones for the same seed; the first ones are the same for every count."""
    generator = np.random.default_rng(seed)
    for number in range(count):
        x, y, yaw = (float(v) for v in generator.uniform(-BOUNDS, BOUNDS).round(3))
        yield Case(number, SCENARIOS[number % len(SCENARIOS)], (x, y, yaw))


def attempt(case: Case) -> Outcome:
    """Plans and judges; an error is an outcome too."""
    begin = time.perf_counter()
    try:
        plan = rg.plan(case.asked())
    except Exception as error:
        return Outcome(case, reason=f"{type(error).__name__}: {error}", time=time.perf_counter() - begin)
    statistics, failures = plan.statistics, plan.certificate().failures
    return Outcome(
        case,
        solved=plan.solved,
        reason="; ".join(" ".join(str(row).split()) for row in failures),
        start=statistics.start,
        starts=len(statistics.starts),
        iterations=sum(start.iterations for start in statistics.starts),
        solve_time=statistics.solve_time,
        time=time.perf_counter() - begin,
    )


def outcomes(asked: list[Case], workers: int) -> list[Outcome]:
    """All outcomes in order; a case that brings its process down says so."""
    found: dict[int, Outcome] = {}
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        futures = {pool.submit(attempt, case): case for case in asked}
        for future in as_completed(futures):
            case = futures[future]
            try:
                found[case.number] = future.result()
            except BrokenProcessPool:
                found[case.number] = Outcome(case, reason="the process crashed")
            print(f"\r{len(found)} of {len(asked)}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return [found[number] for number in sorted(found)]


def report(results: list[Outcome]) -> str:
    """The tables."""
    parts, rows = [], []
    for name in (*SCENARIOS, "all"):
        mine = [r for r in results if name in (r.case.scenario, "all")]
        certified = sum(r.certified for r in mine)
        share = f"{100.0 * certified / len(mine):.1f} %" if mine else ""
        rows.append((name, len(mine), sum(r.solved for r in mine), certified, share))
    parts.append(table(("scenario", "goals", "solved", "certified", ""), rows))
    starts = Counter(r.start for r in results if r.solved)
    parts.append(table(("start that won", "plans"), starts.most_common()))
    solved = [r for r in results if r.solved]
    if solved:
        parts.append(table(("percentile", *PERCENTILES), _percentiles(solved)))
    failed = [r for r in results if not r.certified]
    if failed:
        parts.append(table(("not certified", "x, m", "y, m", "yaw, deg", "reason"), _reasons(failed)))
    return "\n\n".join(parts)


def _percentiles(solved: list[Outcome]) -> Iterator[tuple[str, ...]]:
    for name, values in (
        ("iterations, all starts", [r.iterations for r in solved]),
        ("solve, s", [r.solve_time for r in solved]),
        ("build, solve and certificate, s", [r.time for r in solved]),
    ):
        yield (name, *(f"{np.percentile(values, p):.3g}" for p in PERCENTILES))


def _reasons(failed: list[Outcome]) -> Iterator[tuple[object, ...]]:
    for r in failed:
        yield (f"{r.case.scenario} {r.case.number}", *r.case.goal, r.reason)


def main() -> None:
    """Plans to all goals and prints the report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=200, help="number of goals (default: 200)")
    parser.add_argument("--seed", type=int, default=0, help="of the goals (default: 0)")
    parser.add_argument(
        "--workers", type=int, default=os.cpu_count() or 1, help="processes (default: as many as cores)"
    )
    parser.add_argument("--quick", action="store_true", help="two goals in one process, to see that it works")
    options = parser.parse_args()
    count, workers = (2, 1) if options.quick else (options.count, options.workers)
    before = load()
    results = outcomes(list(cases(count, options.seed)), workers)
    text = (
        f"## Random goals\n\n{machine()}; load {before} before, {load()} after.\n"
        f"{count} goals, seed {options.seed}, {workers} processes at once.\n\n{report(results)}"
    )
    print(text)
    if not options.quick:
        keep("random_goals", text)


if __name__ == "__main__":
    main()
