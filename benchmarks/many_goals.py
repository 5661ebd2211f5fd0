"""How many plans per second do one and two workers make, and does the memory of one stay flat?

    python benchmarks/many_goals.py [--count 200] [--seed 0] [--memory 1000] [--quick]

The goals of `random_goals.py` by `rollgait.plan_many`, with one worker and with two; then one process that
plans over and over, its memory looked at now and then. Prints Markdown and keeps it in docs/benchmarks.md.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

import rollgait as rg
from random_goals import Case, cases
from reporting import keep, load, machine, table

SHORT = 3.0
"""Horizon of the plans of which memory is watched, s: a thousand of them in a few minutes."""
LOOKS = 5
"""How often memory is looked at."""
NEAR = 0.2
"""Their goals, in parts of the others': reached in so short a time."""


def rates(asked: Sequence[Case]) -> list[tuple[object, ...]]:
    """Workers, plans per second, share of certified plans, rate over that of one worker."""
    scenarios = [case.asked() for case in asked]
    rg.plan(scenarios[0])  # what is compiled once is no part of a rate
    rows: list[tuple[object, ...]] = []
    first = 0.0
    for workers in (1, 2):
        begin = time.perf_counter()
        found = rg.plan_many(scenarios, workers=workers, quiet=True)
        rate = len(found) / (time.perf_counter() - begin)
        first = first or rate
        plans = [outcome.plan for outcome in found if outcome.plan is not None]
        certified = sum(plan.certificate().passed for plan in plans)
        rows.append((workers, f"{rate:.2f}", f"{certified} of {len(found)}", f"{rate / first:.2f} ×"))
    return rows


def memory(count: int, seed: int) -> list[tuple[object, ...]]:
    """Plans made and memory of the process, MB."""
    planner = rg.Planner()
    rows = []
    marks = {max(1, round(count * (k + 1) / LOOKS)) for k in range(LOOKS)} | {1}
    for case in cases(count, seed):
        x, y, yaw = (NEAR * value for value in case.goal)
        goal = {"goal.x": x, "goal.y": y, "goal.yaw_deg": yaw}
        planner.plan(rg.find_scenario("wheeled").with_values({"horizon": SHORT, "goal.then": [], **goal}))
        if case.number + 1 in marks:
            rows.append((case.number + 1, f"{resident():.0f}"))
    return rows


def resident() -> float:
    """Memory of this process that is in use, MB (Linux)."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * 4096 / 1e6


def main() -> None:
    """Measures and prints the report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=200, help="number of goals (default: 200)")
    parser.add_argument("--seed", type=int, default=0, help="of the goals (default: 0)")
    parser.add_argument("--memory", type=int, default=1000, help="plans of one process (default: 1000)")
    parser.add_argument("--quick", action="store_true", help="two goals, to see that it works")
    options = parser.parse_args()
    count, plans = (2, 2) if options.quick else (options.count, options.memory)
    before = load()
    made = rates(list(cases(count, options.seed)))
    kept = memory(plans, options.seed)
    text = "\n\n".join(
        [
            "## Many goals",
            f"{machine()}; load {before} before, {load()} after. {count} goals, seed {options.seed}.",
            table(("workers", "plans per second", "certified", "rate"), made),
            table(("plans of one process", "memory, MB"), kept),
        ]
    )
    print(text)
    if not options.quick:
        keep("many_goals", text)


if __name__ == "__main__":
    main()
