"""How often is a gait found on random ground, how fast, and why not? Prints Markdown.

    python benchmarks/random_worlds.py [--count 200] [--first 0] [--execute 20] [--quick]

A world has one to three features on the way: steps and blocks of 0.05 to 0.20 m, gaps of 0.15 to 0.40 m,
ramps of up to 15°; edges oblique by up to 25°, blocks and holes also under one side alone; the goal turns by
up to 60°. World n is made from seed n alone. A refusal names its cause; it is true if the world without this
cause, as far as the refusal says, has a certified plan. Seconds are wall time, kernels compiled. The first
plans are executed in MuJoCo, with feedback.
"""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

import rollgait as rg
from reporting import keep, load, machine, table
from reporting.execution import executed
from rollgait.errors import RollgaitError

FIRST = 0.75
"""x at which the first feature begins at the earliest, m: the front feet stand before it."""
BEHIND = 1.15
"""So far behind the last feature is the goal at least, m: the hind feet stand behind it."""
SECONDS = 600.0
"""After which a search is cut: candidates bound it."""
KINDS = ("step", "block", "gap", "ramp", "one-sided")
WEIGHTS = (0.25, 0.2, 0.2, 0.15, 0.2)
FEWEST = 4
"""Worlds with which percentiles begin to mean something."""


@dataclass(frozen=True)
class World:
    """A scenario, and what its ground is made of."""

    seed: int
    features: str
    scenario: rg.Scenario


def world(seed: int) -> World:
    """The world of a seed."""
    rng = np.random.default_rng([20260, seed])
    parts: list[dict[str, object]] = []
    names: list[str] = []
    x, z = FIRST + rng.uniform(0.0, 0.4), 0.0
    for _ in range(rng.integers(1, 4)):
        kind = str(rng.choice(KINDS, p=WEIGHTS))
        yaw = float(rng.uniform(-25.0, 25.0)) if rng.random() < 0.4 else 0.0
        aside = 0.45 * np.tan(np.radians(abs(yaw)))  # an oblique edge is nearer on one side
        x += aside
        height = float(rng.uniform(0.05, 0.20))
        if kind == "step":
            rise = height if z < 0.1 or rng.random() < 0.5 else -min(height, z - 0.01)
            z += rise
            parts.append({"kind": "step", "x": x, "height": z, "yaw_deg": yaw})
            names.append(f"step {rise:+.2f} m")
        elif kind == "block":
            length = float(rng.uniform(0.3, 0.8))
            parts.append(
                {
                    "kind": "block",
                    "x": x + 0.5 * length,
                    "length": length,
                    "width": 6.0,
                    "height": height,
                    "z": z,
                    "yaw_deg": yaw,
                }
            )
            names.append(f"block {height:.2f} × {length:.2f} m")
            x += length
        elif kind == "gap":
            length = float(rng.uniform(0.15, 0.40))
            parts.append({"kind": "gap", "x": x, "length": length, "z": z, "yaw_deg": yaw})
            names.append(f"gap {length:.2f} m")
            x += length
        elif kind == "ramp":
            yaw = 0.0
            slope, length = float(rng.uniform(5.0, 15.0)), float(rng.uniform(0.6, 1.2))
            rise = length * np.tan(np.radians(slope))
            if z - rise >= 0.0 and rng.random() < 0.5:
                rise = -rise
            parts.append({"kind": "ramp", "x": x, "length": length, "rise": rise, "z": z})
            x, z = x + length, z + rise
            parts.append({"kind": "step", "x": x, "height": z})
            names.append(f"ramp {np.sign(rise) * slope:+.0f}°")
        else:
            length, side = float(rng.uniform(0.3, 0.8)), float(rng.choice([-1.0, 1.0]))
            deep = bool(rng.random() < 0.4)
            parts.append(
                {
                    "kind": "block",
                    "x": x + 0.5 * length,
                    "y": 0.5 * side,
                    "length": min(length, 0.4) if deep else length,
                    "width": 0.6,
                    "height": -0.3 if deep else height,
                    "z": z,
                    "yaw_deg": yaw,
                }
            )
            names.append(f"{'hole' if deep else 'block'} on the {'left' if side > 0 else 'right'}")
            x += length
        names[-1] += f" at {yaw:+.0f}°" if yaw else ""
        x += aside + rng.uniform(0.5, 1.0)
    goal = {
        "x": x - 0.5 + BEHIND,
        "y": float(rng.uniform(-0.3, 0.3)),
        "yaw_deg": float(rng.uniform(-60.0, 60.0)),
    }
    if rng.random() < 0.5:
        goal["y"] = goal["yaw_deg"] = 0.0
    gait = {"kind": "discover", "search": {"seconds": SECONDS}}
    data = {"robot": "centauro", "goal": goal, "gait": gait, "ground": {"parts": parts, "friction": 0.5}}
    return World(seed, ", ".join(names), rg.Scenario.from_dict(data))


@dataclass(frozen=True)
class Result:
    """What came of a world."""

    seed: int
    features: str
    certified: bool
    steps: int
    tried: int
    horizon: float
    seconds: float
    cpu: float
    words: str
    true: bool | None = None
    """Of a refusal: whether its cause, removed by the stated amount, gives a certified plan; None if it names
    none, or is none."""
    executed: str = ""
    """Where the robot ends in MuJoCo, off the plan; that it falls."""

    def row(self) -> tuple[str, ...]:
        """Its cells."""
        return (
            str(self.seed),
            self.features,
            "yes" if self.certified else "no",
            str(self.steps),
            str(self.tried),
            f"{self.horizon:.1f}",
            f"{self.seconds:.2f}",
            f"{self.cpu:.2f}",
            self.words,
            {True: "yes", False: "no", None: ""}[self.true],
            self.executed,
        )


AMOUNT = re.compile(
    r"between (?P<axis>[xy]) = (?P<low>[-\d.]+) and (?P<high>[-\d.]+) m for \w+: .*?"
    r"(?:(?P<metres>[\d.]+) m more than a (?P<what>leg|step)|the tread is (?P<tread>\d+) cm)"
)
"""The place, the cause and the amount of a refusal."""


def without_cause(scenario: rg.Scenario, words: str) -> rg.Scenario | None:
    """The world without the cause that a refusal names, by the stated amount; None if it names none here.

    Raises:
        RollgaitError: there is no such world.
    """
    found = AMOUNT.search(words)
    if found is None or found["axis"] != "x":
        return None
    data = scenario.to_dict()
    parts = data["ground"]["parts"]
    near = [k for k, part in enumerate(parts) if _begins(part) >= float(found["low"]) - 0.01]
    if not near:
        return None
    part, later = parts[near[0]], parts[near[0] + 1 :]
    if found["tread"]:
        longer = 0.01 * float(found["tread"])
        if part["kind"] == "block":
            part["length"] += longer
            part["x"] += 0.5 * longer
        for other in later:
            other["x"] += longer
        data["goal"]["x"] += longer
    elif found["what"] == "step":
        part["length"] -= float(found["metres"])
    else:
        part["height"] -= np.sign(part["height"]) * float(found["metres"])
    return rg.Scenario.from_dict(data)


def _begins(part: dict[str, float | str]) -> float:
    """x of the near edge of a part, m."""
    half = 0.5 * float(part["length"]) if part["kind"] == "block" else 0.0
    return float(part["x"]) - half


def is_true(planner: rg.Planner, scenario: rg.Scenario, words: str) -> bool | None:
    """Whether a refusal is true; None if it names no cause that these worlds have."""
    try:
        better = without_cause(scenario, words)
        return None if better is None else planner.plan(better).certificate().passed
    except (RollgaitError, KeyError):  # a part that has no such measure is not the cause
        return False


COLUMNS = (
    "seed",
    "ground",
    "certified",
    "steps",
    "tried",
    "T, s",
    "wall s",
    "CPU s",
    "found, or why not",
    "true",
    "in MuJoCo",
)


def results(seeds: range, execute: int = 0) -> Iterator[Result]:
    """One after the other; the first plans are executed; what has come so far is said."""
    planner = rg.Planner()
    planner.plan(world(seeds[0]).scenario.with_values({"gait": "discover"}))  # compiles what must be compiled
    for seed in seeds:
        try:
            asked = world(seed)
        except RollgaitError as error:
            print(f"{seed}: no world: {error}", file=sys.stderr)
            continue
        begin, cpu = time.perf_counter(), time.process_time()
        plan, words, true = None, "", None
        try:
            plan = planner.plan(asked.scenario)
            found = plan.statistics.discovery
            words = found[-1].name
        except RollgaitError as error:
            found = () if (failed := getattr(error, "plan", None)) is None else failed.statistics.discovery
            words = str(error)
        seconds, cpu = time.perf_counter() - begin, time.process_time() - cpu
        if plan is None:
            true = is_true(planner, asked.scenario, words)
        steps = found[-1].steps if found else 0
        horizon = plan.horizon if plan else 0.0
        tried = next((k for k, one in enumerate(found, 1) if one.outcome.startswith("certified")), len(found))
        moved = str(executed(plan)) if plan is not None and seed < seeds[0] + execute else ""
        result = Result(
            seed, asked.features, plan is not None, steps, tried, horizon, seconds, cpu, words, true, moved
        )
        print(" | ".join(result.row()), file=sys.stderr, flush=True)
        yield result


def section(seeds: range, execute: int = 0) -> str:
    """Figures and table; the first plans are executed."""
    before = load()
    done = list(results(seeds, execute))
    good = [r for r in done if r.certified]
    first = sum(r.tried == 1 for r in good)
    named, true = sum(r.true is not None for r in done), sum(r.true is True for r in done)
    needs = sum(r.steps > 0 for r in done)
    text = (
        f"## Random worlds: the gait found\n\n{machine()}; load {before} before, {load()} after.\n"
        f"{len(good)} of {len(done)} certified ({100.0 * len(good) / len(done):.0f} %), {first} of them by "
        f"the first candidate; {needs} with steps.\n"
        f"Of {len(done) - len(good)} that are not, {named} name a cause, and {true} of these are true: "
        "without it there is a certified plan.\n"
    )
    for name, values in (("wall time", [r.seconds for r in done]), ("CPU time", [r.cpu for r in done])):
        text += f"{name}: median {np.median(values):.1f} s, 90 % {np.percentile(values, 90):.1f} s.\n"
    return text + "\n" + table(COLUMNS, (r.row() for r in done))


def main() -> None:
    """Plans the worlds and prints what came of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=200, help="how many worlds")
    parser.add_argument("--first", type=int, default=0, help="seed of the first one")
    parser.add_argument("--execute", type=int, default=0, help="so many of the first in MuJoCo")
    parser.add_argument("--quick", action="store_true", help="one world, to see that it works")
    options = parser.parse_args()
    count = 1 if options.quick else options.count
    text = section(range(options.first, options.first + count), options.execute)
    print(text)
    if not options.quick and options.first == 0:
        keep("random-worlds", text)


if __name__ == "__main__":
    main()
