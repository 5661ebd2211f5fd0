"""Do robots whose feet cannot roll everywhere find their steps on flat ground? Random goals, gaits found.

    python benchmarks/flat_goals.py [--count 60] [--seed 0] [--robots roller light hyq] [--quick]

Goals within |x| ≤ 2 and |y| ≤ 1 body lengths (axle to axle) and |yaw| ≤ 90°, for the fixed wheels of `roller`
(tests) and `light` (examples/own_robot.py) and the point feet of `hyq` (package example-robot-data). Each is
planned with `gait: discover` until a certificate passes. Prints Markdown and keeps it in docs/benchmarks.md.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import rollgait as rg
from reporting import keep, load, machine, table
from reporting.execution import Execution, executed
from rollgait.robot.importing import import_robot

HERE = Path(__file__).resolve().parent
BOUNDS = np.array([2.0, 1.0, 90.0])
"""Largest |x| and |y| (body lengths) and |yaw| (degrees) of a goal."""
PERCENTILES = (50, 90, 100)
SEARCH = {"seconds": 300.0}
"""The number of candidates bounds the search, not how busy the machine is."""


def _light() -> rg.Robot:
    sys.path.insert(0, str(HERE.parent / "examples"))
    from own_robot import quadruped

    return quadruped("fixed")


def _imported(name: str) -> rg.Robot:
    return import_robot(HERE.parent / "tests" / "fixtures" / f"{name}.yaml").robot


ROBOTS: dict[str, Callable[[], rg.Robot]] = {
    "roller": lambda: _imported("roller"),
    "light": _light,
    "hyq": lambda: _imported("hyq"),
}


@dataclass(frozen=True)
class Case:
    """A robot and its goal: x (m), y (m), yaw (degrees)."""

    number: int
    robot: str
    goal: tuple[float, float, float]


@dataclass(frozen=True)
class Outcome:
    """What came of a case. `reason` says why no gait was certified; "" if one was."""

    case: Case
    reason: str
    tried: int
    steps: int
    horizon: float
    iterations: int
    seconds: float
    cpu: float
    execution: Execution | None = None


def cases(robot: str, body: rg.Robot, count: int, seed: int) -> Iterator[Case]:
    """The same ones for the same seed; the first ones are the same for every count."""
    generator = np.random.default_rng(seed)
    length = float(body.stance[:2, 0].mean() - body.stance[2:, 0].mean())
    for number in range(count):
        x, y, yaw = (float(v) for v in (generator.uniform(-BOUNDS, BOUNDS) * [length, length, 1.0]).round(3))
        yield Case(number, robot, (x, y, yaw))


def attempt(case: Case, body: rg.Robot, planner: rg.Planner, execute: bool = False) -> Outcome:
    """Plans to the goal, the gait to be found; then the whole robot carries it out, if asked."""
    x, y, yaw = case.goal
    goal = {"x": x, "y": y, "yaw_deg": yaw}
    asked = rg.Scenario.from_dict(
        {"robot": body, "goal": goal, "gait": {"kind": "discover", "search": SEARCH}}
    )
    begin, cpu = time.perf_counter(), time.process_time()
    plan: rg.Plan | None
    try:
        plan, reason = planner.plan(asked), ""
    except rg.NotSolvedError as error:
        plan, reason = error.plan, str(error)
    spent = time.perf_counter() - begin, time.process_time() - cpu
    tried = () if plan is None else plan.statistics.discovery
    if not tried:
        return Outcome(case, reason, 0, 0, 0.0, 0, *spent)
    iterations = sum(result.iterations for result in tried)
    moved = executed(plan) if execute and plan is not None and not reason else None
    return Outcome(case, reason, len(tried), tried[-1].steps, tried[-1].horizon, iterations, *spent, moved)


def report(results: Sequence[Outcome]) -> str:
    """The tables."""
    parts, rows, names = [], [], list(dict.fromkeys(r.case.robot for r in results))
    for name in names:
        mine = [r for r in results if r.case.robot == name]
        good = [r for r in mine if not r.reason]
        first = sum(r.tried == 1 for r in good)
        late = sum(r.seconds > 4.0 for r in mine), sum(r.cpu > 4.0 for r in mine)
        rows.append((name, len(mine), len(good), f"{100.0 * len(good) / len(mine):.1f} %", first, *late))
    head = ("robot", "goals", "certified", "", "by the first gait", "longer than 4 s", "more than 4 s of CPU")
    parts.append(table(head, rows))
    lines = []
    for name in names:
        mine = [r for r in results if r.case.robot == name]
        for what, values in (
            ("steps", [r.steps for r in mine]),
            ("horizon, s", [r.horizon for r in mine]),
            ("iterations", [r.iterations for r in mine]),
            ("wall time, s", [r.seconds for r in mine]),
            ("CPU time, s", [r.cpu for r in mine]),
        ):
            lines.append((f"{name}: {what}", *(f"{np.percentile(values, p):.3g}" for p in PERCENTILES)))
    parts.append(table(("percentile", *PERCENTILES), lines))
    failed = [(f"{r.case.robot} {r.case.number}", *r.case.goal, r.reason) for r in results if r.reason]
    if failed:
        parts.append(table(("not certified", "x, m", "y, m", "yaw, deg", "reason"), failed))
    return "\n\n".join(parts)


def main() -> None:
    """Plans to all goals and prints the report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=60, help="goals of each robot (default: 60)")
    parser.add_argument("--seed", type=int, default=0, help="of the goals (default: 0)")
    parser.add_argument("--robots", nargs="+", choices=list(ROBOTS), default=list(ROBOTS), help="which")
    parser.add_argument("--quick", action="store_true", help="one goal each, to see that it works")
    options = parser.parse_args()
    before, results, planner = load(), list[Outcome](), rg.Planner()
    for name in options.robots:
        body = ROBOTS[name]()
        todo = list(cases(name, body, 1 if options.quick else options.count, options.seed))
        attempt(todo[0], body, planner)  # what is compiled once is no part of the times
        for case in todo:
            results.append(attempt(case, body, planner))
            r = results[-1]
            said = f"{name} {case.number} {case.goal}: {r.tried} tried, {r.steps} steps, {r.iterations} it"
            print(
                f"{said}, {r.seconds:.2f} s, CPU {r.cpu:.2f} s  {r.reason[:300]}", file=sys.stderr, flush=True
            )
    text = (
        f"## Goals on flat ground for feet that cannot roll there\n\n{machine()}; load {before} before, "
        f"{load()} after. {options.count} goals of each robot, seed {options.seed}.\n\n{report(results)}"
    )
    print(text)
    if not options.quick:
        keep("flat_goals", text)


if __name__ == "__main__":
    main()
