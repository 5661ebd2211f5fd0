"""Does solved mean certified? Plans random valid scenarios over all keys.

    python benchmarks/random_scenarios.py [--count 500] [--seed 0] [--workers 2] [--quick]

Goals to ±180°, later goals, horizons of 2 to 30 s, intervals of 0.05 to 0.2 s, every kind of gait, both
profiles, both robots, friction 0.2 to 1, weights, bounds, start headings. Prints Markdown and keeps it in
docs/benchmarks.md: how many were certified, refused or left uncertified, how long they took, and the cases
that were not certified by number.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any

import numpy as np

import rollgait as rg
from reporting import keep, load, machine, table

ROBOTS = ("centauro", "centauro-2020")
GAITS = ("drive", "crawl", "schedule")
LEGS = ("FL", "FR", "HL", "HR")
LONGEST = 15.0
"""s that no scenario may take."""


@dataclass(frozen=True)
class Outcome:
    """What came of a scenario: `verdict` is certified, uncertified, refused or crashed; `reason` says why."""

    number: int
    verdict: str
    reason: str = ""
    time: float = 0.0
    meshes: int = 0
    starts: int = 0


def scenarios(seed: int) -> Iterator[rg.Scenario]:
    """Valid scenarios without end, the same ones for the same seed; what the rules refuse is drawn again."""
    number = 0
    while True:
        generator = np.random.default_rng([seed, number])
        number += 1
        try:
            yield rg.Scenario.from_dict(_draw(generator))
        except rg.InputError:
            continue


def _draw(g: np.random.Generator) -> dict[str, Any]:
    horizon = float(np.round(np.exp(g.uniform(np.log(2.0), np.log(30.0))), 1))
    far = min(2.5, 0.25 * horizon)

    def place(yaw: float) -> dict[str, float]:
        values = g.uniform(-1.0, 1.0, 3) * (far, 0.5 * far, yaw)
        return dict(zip(("x", "y", "yaw_deg"), (float(v) for v in values.round(3)), strict=True))

    def maybe(share: float) -> bool:
        return bool(g.uniform() < share)

    largest_yaw = min(180.0, 20.0 * horizon)
    goal: dict[str, Any] = place(largest_yaw)
    if maybe(0.25):
        goal["then"] = [place(largest_yaw) | {"at": round(horizon * float(g.uniform(0.4, 0.7)), 2)}]
    data: dict[str, Any] = {
        "robot": str(g.choice(ROBOTS)),
        "goal": goal,
        "horizon": horizon,
        "interval": float(np.round(g.uniform(0.05, 0.2), 3)),
        "profile": "paper" if maybe(0.2) else "executable",
        "gait": _gait(g, horizon),
        "ground": {
            "friction": round(float(g.uniform(0.2, 1.0)), 2),
            "height": round(float(g.uniform(-1, 1)), 2),
        },
    }
    if maybe(0.3):
        data["start"] = place(180.0) | {
            "heading_deg": {
                leg: float(v) for leg, v in zip(LEGS, g.uniform(-60, 60, 4).round(1), strict=True)
            }
        }
        for axis in ("x", "y"):
            goal[axis] = round(goal[axis] + data["start"][axis], 3)
            for later in goal.get("then", []):
                later[axis] = round(later[axis] + data["start"][axis], 3)
    if maybe(0.2):
        names = g.choice(["acc", "goal", "feet", "speed", "yaw"], 2, replace=False)
        data["weights"] = {str(name): float(np.round(10.0 ** g.uniform(-1, 2), 3)) for name in names}
    if maybe(0.2):
        bounds = {
            "speed_max": round(float(g.uniform(0.4, 1.2)), 2),
            "steering_rate_max": round(float(g.uniform(0.8, 3.0)), 2),
            "force_max": round(float(g.uniform(700, 1500)), 0),
            "full_rotation": maybe(0.5),
            "inscribed": maybe(0.5),
            "box": [float(v) for v in g.uniform((0.1, 0.1, 0.12), (0.25, 0.2, 0.2)).round(3)],
        }
        name = str(g.choice(list(bounds)))
        data["bounds"] = {name: bounds[name]}
    return data


def _gait(g: np.random.Generator, horizon: float) -> dict[str, Any]:
    kind = str(g.choice(GAITS))
    gait: dict[str, Any] = {"kind": kind, "clearance": round(float(g.uniform(0.03, 0.12)), 3)}
    if g.uniform() < 0.15:
        gait["wheels"] = "locked"
    if kind == "crawl":
        gait["steps"] = max(1, min(16, int(horizon * g.uniform(0.3, 1.0))))
        gait["order"] = [str(leg) for leg in g.permutation(LEGS)]
        gait["swing_fraction"] = round(float(g.uniform(0.6, 0.95)), 2)
        gait["pause_start"] = gait["pause_end"] = 1.0 if horizon > 4.0 else 0.4
    elif kind == "schedule":
        time = float(g.uniform(0.3, 1.0))
        while True:
            length = float(g.uniform(0.5, 1.2))
            if time + length > horizon - 0.5:
                break
            gait.setdefault(str(g.choice(LEGS)), []).append([round(time, 2), round(time + length, 2)])
            time += length + float(g.uniform(0.2, 1.5))
    return gait


def attempt(number: int, asked: dict[str, Any]) -> Outcome:
    """Plans and judges; an error is an outcome too."""
    begin = time.perf_counter()
    try:
        plan = rg.plan(rg.Scenario.from_dict(asked), diagnose=False)
    except rg.NotSolvedError as error:
        return Outcome(number, "refused", str(error), time.perf_counter() - begin)
    except Exception as error:
        return Outcome(number, "crashed", f"{type(error).__name__}: {error}", time.perf_counter() - begin)
    failures = plan.certificate().failures
    return Outcome(
        number,
        "uncertified" if failures else "certified",
        "; ".join(" ".join(str(row).split()[1:]) for row in failures),
        time.perf_counter() - begin,
        0 if plan.schedule.mesh.is_equal else 1,
        len(plan.statistics.starts),
    )


def outcomes(count: int, seed: int, workers: int) -> list[Outcome]:
    """All outcomes in order; a case that brings its process down says so."""
    found: dict[int, Outcome] = {}
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        source = zip(range(count), scenarios(seed), strict=False)
        futures = {pool.submit(attempt, number, asked.to_dict()): number for number, asked in source}
        for future in as_completed(futures):
            number = futures[future]
            try:
                found[number] = future.result()
            except BrokenProcessPool:
                found[number] = Outcome(number, "crashed", "the process crashed")
            print(f"\r{len(found)} of {count}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return [found[number] for number in sorted(found)]


def report(results: list[Outcome], seed: int, workers: int) -> str:
    """Markdown of all that was found."""
    verdicts = Counter(result.verdict for result in results)
    times = np.array([result.time for result in results])
    rows = [
        ("certified", verdicts["certified"]),
        ("of these on a mesh that was cut finer", sum(r.meshes for r in results if r.verdict == "certified")),
        ("uncertified", verdicts["uncertified"]),
        ("refused: no solution found", verdicts["refused"]),
        ("crashed", verdicts["crashed"]),
        (
            "time, median / 90 % / 99 % / longest",
            " / ".join(f"{t:.2f} s" for t in np.percentile(times, (50, 90, 99, 100))),
        ),
        (f"over {LONGEST:g} s", int((times > LONGEST).sum())),
    ]
    text = f"{len(results)} random scenarios, seed {seed}, {workers} workers, {machine()}; load {load()}\n\n"
    text += table(("", ""), rows)
    bad = [r for r in results if r.verdict != "certified"]
    lines = [f"- {r.number}: {r.verdict}, {r.reason[:300]}" for r in bad]
    return text + ("\n\nNot certified, by number:\n\n" + "\n".join(lines) if bad else "")


def main() -> None:
    """Runs the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=500, help="number of scenarios (default: 500)")
    parser.add_argument("--seed", type=int, default=0, help="of the scenarios (default: 0)")
    parser.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--quick", action="store_true", help="two scenarios in one process")
    options = parser.parse_args()
    count, workers = (2, 1) if options.quick else (options.count, options.workers)
    text = "## Random scenarios\n\n" + report(outcomes(count, options.seed, workers), options.seed, workers)
    print(text)
    if not options.quick:
        keep("random_scenarios", text)


if __name__ == "__main__":
    main()
