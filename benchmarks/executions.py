"""The controller carries out plans of the library in MuJoCo: as planned, and disturbed.

    python benchmarks/executions.py [--scenarios NAME,NAME] [--seeds 10] [--out FILE]

Disturbed: 5 kg that the controller does not know of, wheels 1 % larger, friction 0.6 (plans use 0.5), signals
3 ms old, and a push of 50 N for 0.2 s at a random time in a random direction, for each seed. Prints Markdown;
exit status 1 if a robot falls or does not come to the end of its plan.
"""

from __future__ import annotations

import argparse
import logging
import sys
from pathlib import Path

import numpy as np

import rollgait as rg
from reporting import load, machine, table
from rollgait.mpc.execution import ExecutionReport, execute, loop_for
from rollgait.plant.disturbances import Disturbances, Payload, Push
from rollgait.scenario.library import find_scenario

STEEP = "four steep stairs"
SCENARIOS = (
    "legged-forward",
    "wheeled",
    "hybrid-forward",
    "hybrid-goback",
    "kerb",
    "stairs",
    STEEP,
    "gap",
    "ramp",
    "one-sided",
)
FOUND = {
    STEEP: {
        "ground.parts": [{"kind": "stairs", "x": 0.9, "steps": 4, "rise": 0.15, "tread": 0.32}],
        "goal.x": 3.2,
    }
}
"""Scenarios that are not in the library: what differs from its stairs whose gait is found."""
MARGIN = 0.5
"""No push comes nearer to the ends of a plan, s."""


def main() -> int:
    """Prints or writes the page."""
    parser = argparse.ArgumentParser(description="The controller carries out plans.")
    parser.add_argument("--scenarios", default=",".join(SCENARIOS))
    parser.add_argument("--seeds", type=int, default=10, help="disturbed runs of each")
    parser.add_argument("--out", type=Path, help="write the page there")
    given = parser.parse_args()
    logging.getLogger("rollgait").setLevel(logging.ERROR)
    rows: list[tuple[object, ...]] = []
    failures = 0
    for name in given.scenarios.split(","):
        plan = rg.plan(scenario_of(name))
        runs = {
            "as planned": [Disturbances()],
            "disturbed": [disturbed(plan, seed) for seed in range(given.seeds)],
        }
        for what, disturbances in runs.items():
            reports = [report(plan, one, f"{name}, {what}") for one in disturbances]
            if reports:
                failures += sum(not one.passed for one in reports)
                rows.append((name, what, *row_of(reports)))
    page = [
        "## Plans carried out by the controller",
        f"`python benchmarks/executions.py` ({machine()}; load {load()}).",
        table(
            (
                "plan",
                "run",
                "runs",
                "not to the end",
                "falls",
                "final place, mm",
                "yaw, °",
                "footholds, mm",
                "late, s",
                "at torque limit, s",
            ),
            rows,
        ),
    ]
    text = "\n\n".join(page) + "\n"
    if given.out is None:
        print(text)
    else:
        given.out.write_text(text, encoding="utf-8")
    return 1 if failures else 0


def scenario_of(name: str) -> rg.Scenario:
    """A scenario of the library, or one that is made of it."""
    if name not in FOUND:
        return find_scenario(name)
    return find_scenario("stairs-discover").with_values(FOUND[name])


def disturbed(plan: rg.Plan, seed: int) -> Disturbances:
    """What is not as planned."""
    random = np.random.default_rng(seed)
    push = Push(
        force=50.0,
        direction_deg=float(random.uniform(-180.0, 180.0)),
        start=float(random.uniform(MARGIN, plan.horizon - MARGIN)),
    )
    return Disturbances(
        pushes=(push,), payload=Payload(mass=5.0), friction=0.6, radius_error=0.01, latency=0.003
    )


def report(plan: rg.Plan, disturbances: Disturbances, what: str) -> ExecutionReport:
    """What came of one run."""
    found = execute([plan], loop_for(plan, "mujoco", disturbances=disturbances)).report
    print(f"{what}: {found.verdict}", file=sys.stderr, flush=True)
    return found


def row_of(reports: list[ExecutionReport]) -> tuple[object, ...]:
    """Numbers of runs, and the worst of each figure of those that came to the end."""
    ended = [one for one in reports if one.passed]
    figures = [
        (
            1e3 * one.final_distance,
            np.degrees(abs(one.final_yaw)),
            1e3 * one.foothold_worst,
            one.shift,
            one.at_limit,
        )
        for one in ended
    ]
    worst = np.max(figures, axis=0) if figures else np.full(5, np.nan)
    falls = sum(one.fallen_at is not None for one in reports)
    return (len(reports), len(reports) - len(ended), falls, *(f"{value:.2g}" for value in worst))


if __name__ == "__main__":
    sys.exit(main())
