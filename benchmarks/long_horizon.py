"""Is the effort linear in the horizon? Plans 10 s to 100 s of driving and stepping from goal to goal.

    python benchmarks/long_horizon.py [--intervals 100 200 500 1000] [--runs 3] [--quick]

Each time is the smallest of the runs. Prints Markdown and keeps it in docs/benchmarks.md.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import rollgait as rg
from reporting import keep, load, machine, table

INTERVAL = 0.1
"""h, s."""
LEG_TIME = 10.0
"""Time for each goal, s: as long as hybrid-forward has for its own."""
LEG_STEPS = 8
"""Steps of all feet on the way to each goal."""
ROUTES = {"straight": (0.0, 0.0), "winding": (0.4, 30.0)}
"""How far to the left (m) every other goal lies, and by how many degrees it is turned."""
PARTS = ("build", "solve", "solve / iteration", "save", "load", "check")
RATIO_GOAL = 12.0
"""A horizon ten times as long may take this many times as long to solve."""

T = TypeVar("T")


def scenario(route: str, intervals: int) -> rg.Scenario:
    """A goal 1 m further on for every 10 s."""
    aside, turn = ROUTES[route]
    horizon = intervals * INTERVAL
    count = max(1, round(horizon / LEG_TIME))
    goals = [{"x": k + 1.0, "y": aside * (1 - k % 2), "yaw_deg": turn * (1 - k % 2)} for k in range(count)]
    later = [{"at": k * horizon / count} | goals[k] for k in range(1, count)]
    return rg.Scenario.from_dict(
        {
            "robot": "centauro",
            "goal": goals[0] | {"then": later},
            "horizon": horizon,
            "interval": INTERVAL,
            "gait": {"kind": "crawl", "steps": LEG_STEPS * count},
        }
    )


def timed(function: Callable[[], T]) -> tuple[T, float]:
    """A function's result and its time, s."""
    begin = time.perf_counter()
    result = function()
    return result, time.perf_counter() - begin


def once(route: str, intervals: int, folder: Path) -> tuple[rg.Plan, bool, dict[str, float]]:
    """The plan, whether it is certified, and the time of each part."""
    asked = scenario(route, intervals)
    plan = rg.plan(asked)
    saved, save = timed(lambda: plan.save(folder / "plan.npz"))
    loaded, load_time = timed(lambda: rg.Plan.load(saved))
    certificate, check = timed(loaded.certificate)
    s = plan.statistics
    times = (s.build_time, s.solve_time, s.solve_time / s.iterations, save, load_time, check)
    return plan, certificate.passed, dict(zip(PARTS, times, strict=True))


def measure(route: str, counts: list[int], runs: int) -> str:
    """The table of a route."""
    rows, first = [], {}
    with tempfile.TemporaryDirectory() as folder:
        once(route, counts[0], Path(folder))  # imports and kernels
        for count in counts:
            results = [once(route, count, Path(folder)) for _ in range(runs)]
            best = {part: min(times[part] for _, _, times in results) for part in PARTS}
            first = first or best
            plan, certified, _ = results[-1]
            times = [f"{best[part]:.3f} (× {best[part] / first[part]:.1f})" for part in PARTS]
            row = (count, f"{plan.horizon:.0f}", plan.statistics.iterations, *times)
            rows.append((*row, "yes" if certified else "no"))
    columns = ("N", "T, s", "iterations", *(f"{part}, s" for part in PARTS), "certified")
    ratio = best["solve"] / first["solve"]
    text = f"**{route}**\n\n{table(columns, rows)}"
    if counts[-1] == 10 * counts[0]:
        goal = f"we aim at {RATIO_GOAL:.0f} at most"
        text += f"\n\nTen times as long takes {ratio:.1f} times as long to solve ({goal})."
    return text


def main() -> None:
    """Measures, prints and keeps the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--intervals", type=int, nargs="+", default=[100, 200, 500, 1000], metavar="N")
    parser.add_argument("--runs", type=int, default=3, help="runs of each (default: 3)")
    parser.add_argument("--quick", action="store_true", help="two short ones, to see that it works")
    options = parser.parse_args()
    counts, runs = ([100, 200], 1) if options.quick else (options.intervals, options.runs)
    before = load()
    measured = "\n\n".join(measure(route, counts, runs) for route in ROUTES)
    text = f"## Long horizons\n\n{machine()}; load {before} before, {load()} after.\n\n{measured}"
    print(text)
    if not options.quick:
        keep("long_horizon", text)


if __name__ == "__main__":
    main()
