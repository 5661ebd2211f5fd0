"""What free timing saves: cost, time and certificate of motions whose lift-offs and touch-downs are found.

    python benchmarks/timing.py [--runs 3] [--starts 16] [--quick]

Without the effort of swings and without the margins of CoM and capture point, as the targets are meant; then
with both. Times are of the processor, all of a plan, the smallest of the runs. The cost at half the interval
is compared with jumps of forces at contact changes as they cost at 0.1 s: in a plan they cost the more, the
finer the mesh. Prints Markdown and keeps it in docs/benchmarks.md.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np

import rollgait as rg
from reporting import keep, load, machine, table
from rollgait.scenario import find_scenario
from rollgait.timing.phases import Phases

TARGETS = {"hybrid-forward": 60.0, "legged-forward": 39.0, "hybrid-goback": 114.0, "rolling-trot": 28.5}
"""Largest cost of motions at the same horizon, swings of 0.4 s to 1.5 s."""
SHORTEST = {"hybrid-forward": 4.4, "legged-forward": 4.8}
"""Largest of the shortest horizons, s."""
STARTED = ("hybrid-forward", "legged-forward", "rolling-trot")
"""Motions that are also found from bad times."""
SLOWER = 3.0
"""As many times as long as with given times may it take."""
SAME = 1e-3
"""Relative; costs that are as near are of one optimum."""
FINER = 0.03
"""Relative; so near must the cost on a mesh of half the interval be."""
MARGINS = ("com_margin", "capture_margin")
PRICE = 100.0
"""Of a second, where the shortest horizon is sought."""
WORST, BEST = 0.2, 2.0
"""By how much random times are stretched."""


def asked(name: str, plain: bool, **values: Any) -> rg.Scenario:
    """A motion of the library, without margins and effort if it is to be plain."""
    own: dict[str, Any] = {"bounds.without": list(MARGINS)} if plain else {}
    return find_scenario(name).with_values(own | values)


def free(scenario: rg.Scenario, plain: bool, **values: Any) -> rg.Scenario:
    """The same with free timing."""
    return scenario.with_values({"gait.timing": {"effort": 0.0 if plain else 1.0}, **values})


def timed(scenario: rg.Scenario, runs: int) -> tuple[rg.Plan, float]:
    """The plan and the shortest processor time, s; what is derived once is not counted."""
    plan, best = rg.plan(scenario), np.inf
    for _ in range(runs):
        begin = time.process_time()
        plan = rg.plan(scenario)
        best = min(best, time.process_time() - begin)
    return plan, best


def without_jumps(plan: rg.Plan) -> float:
    """The cost while times were sought, where jumps of forces cost the same on any mesh."""
    return [start.cost for start in plan.statistics.starts if start.name.startswith("timing:")][-1]


def yes(it: bool) -> str:
    """A word."""
    return "yes" if it else "**no**"


def aim(most: float, met: bool, unit: str = "") -> str:
    """What was aimed at, in words, and whether it was missed."""
    return f" (aim: at most {most:g}{unit}{'' if met else ', **missed**'})"


def costs(runs: int, plain: bool, names: list[str]) -> str:
    """The table of costs with given and with free times."""
    rows = []
    for name in names:
        scenario = asked(name, plain)
        given, given_time = timed(scenario, runs)
        found, found_time = timed(free(scenario, plain), runs)
        fine = rg.plan(free(scenario.with_values({"interval": 0.05}), plain))
        cost, ratio = found.statistics.cost, found_time / given_time
        difference = without_jumps(fine) / without_jumps(found) - 1.0
        rows.append(
            (
                name,
                f"{given.statistics.cost:.2f}",
                f"{cost:.2f}" + (aim(TARGETS[name], cost <= TARGETS[name]) if plain else ""),
                f"{given.statistics.iterations} / {given_time:.2f}",
                f"{found.statistics.iterations} / {found_time:.2f}",
                f"{ratio:.1f}{aim(SLOWER, ratio <= SLOWER)}",
                f"{fine.statistics.cost:.2f}, {100.0 * difference:+.1f} %"
                f"{aim(100.0 * FINER, difference <= FINER, ' %')}",
                yes(found.certificate().passed and fine.certificate().passed),
            )
        )
        print(rows[-1], file=sys.stderr, flush=True)
    columns = (
        "motion",
        "J given",
        "J found",
        "it / s given",
        "it / s found",
        "time ratio",
        "at h = 0.05 s",
    )
    return table((*columns, "certified"), rows)


def shortest(plain: bool, names: list[str]) -> str:
    """The table of shortest horizons."""
    rows = []
    for name in names:
        scenario = asked(name, plain)
        priced = free(scenario, plain, horizon={"max": 20.0, "price": PRICE})
        plan = rg.plan(priced)
        within = aim(SHORTEST[name], plan.horizon <= SHORTEST[name], " s") if plain else ""
        rows.append((name, f"{plan.horizon:.2f} s{within}", yes(plan.certificate().passed)))
        print(rows[-1], file=sys.stderr, flush=True)
    return table(("motion", "T", "certified"), rows)


def bad_times(scenario: rg.Scenario, count: int) -> Iterator[rg.Scenario]:
    """The same contacts in the same order at bad times."""
    phases = Phases.of(scenario, scenario.schedule)
    swings, rest = phases.swings, scenario.horizon - 0.4 * phases.swings.sum()
    even = np.where(swings, 0.4, rest / (~swings).sum())
    short = np.where(swings, 0.4, 0.1)
    at_begin, at_end = short.copy(), short.copy()
    at_begin[0] += scenario.horizon - short.sum()
    at_end[-1] += scenario.horizon - short.sum()
    starts = [even, at_begin, at_end]
    for seed in range(count - len(starts)):
        stretched = phases.lengths * np.random.default_rng(seed).uniform(WORST, BEST, phases.count)
        starts.append(stretched * scenario.horizon / stretched.sum())
    for lengths in starts[:count]:
        bad = phases.lasting(lengths)
        nodes = bad.on_mesh(np.full(bad.count, 4)).node_times
        gait = bad.gait(scenario, nodes).model_dump(mode="json")
        yield scenario.with_values({"gait": gait, "horizon": float(nodes[-1])})


def same_optimum(count: int, names: list[str]) -> str:
    """The table of optima from bad times."""
    rows = []
    for name in names:
        scenario = asked(name, plain=True)
        wanted = rg.plan(free(scenario, plain=True)).statistics.cost
        found = []
        for bad in bad_times(scenario, count):
            try:
                found.append(rg.plan(free(bad, plain=True), diagnose=False).statistics.cost)
            except rg.NotSolvedError:
                found.append(np.inf)
        apart = np.abs(np.array(found) / wanted - 1.0)
        rows.append((name, f"{(apart <= SAME).sum()} of {apart.size}", f"{100.0 * apart.max():.3f} %"))
        print(rows[-1], file=sys.stderr, flush=True)
    return table(("motion", f"within {100.0 * SAME:g} %", "farthest"), rows)


def main() -> None:
    """Measures, prints and keeps the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=3, help="runs of each (default: 3)")
    parser.add_argument("--starts", type=int, default=16, help="bad times of each motion (default: 16)")
    parser.add_argument("--quick", action="store_true", help="one motion, to see that it works")
    options = parser.parse_args()
    quick = options.quick
    runs, count = (1, 3) if quick else (options.runs, options.starts)
    names = ["rolling-trot"] if quick else list(TARGETS)
    before = load()
    parts = [
        f"At the same horizon, without effort and margins:\n\n{costs(runs, True, names)}",
        f"From bad times:\n\n{same_optimum(count, names[:1] if quick else list(STARTED))}",
    ]
    if not quick:
        parts += [
            f"Shortest horizons, a second at {PRICE:g}:\n\n{shortest(True, list(SHORTEST))}",
            f"With effort 1 and the margins of the profile:\n\n{costs(runs, False, names)}",
            f"Shortest horizons with these:\n\n{shortest(False, list(SHORTEST))}",
        ]
    text = f"## Timing\n\n{machine()}; load {before} before, {load()} after.\n\n" + "\n\n".join(parts)
    print(text)
    if not quick:
        keep("timing", text)


if __name__ == "__main__":
    main()
