"""How wide must the margin of the capture point be? Pushes at random moments, executed in MuJoCo.

    python benchmarks/pushes.py [--force 50 200] [--runs 15] [--seed 0] [--quick]

The motions with swings are planned with one `bounds.capture_margin` after another, and executed by the whole
body with feedback, each time pushed once: at a random moment of its motion and in a random direction, the
same ones for every margin. Prints Markdown and keeps it in docs/benchmarks.md: falls, and worst errors of the
runs that did not fall.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

import rollgait as rg
from reporting import keep, load, machine, table
from rollgait.errors import RollgaitError
from rollgait.simulation import Disturbances, Push, SimulationReport

MOTIONS = ("legged-forward", "hybrid-forward")
MARGINS = (None, -0.03, 0.0, 0.01, 0.02)
"""m; None: neither the capture point's margin nor the CoM's."""
DURATION = 0.2
"""Of a push, s."""
MILLI = 1e3


@dataclass
class Worst:
    """What came of one margin and force."""

    runs: int = 0
    fallen: int = 0
    distance: float = 0.0
    angle: float = 0.0
    tilt_error: float = 0.0
    strayed: float = 0.0

    def add(self, report: SimulationReport) -> None:
        """Counts a run; a fallen robot has no final pose."""
        self.runs += 1
        self.fallen += report.fallen
        if not report.fallen:
            self.distance = max(self.distance, report.final_distance)
            self.angle = max(self.angle, report.final_angle)
            self.tilt_error = max(self.tilt_error, report.tilt_error)
            self.strayed = max(self.strayed, report.com_worst)

    def cells(self) -> tuple[str, ...]:
        """As cells of the table."""
        return (
            str(self.runs),
            str(self.fallen),
            f"{MILLI * self.distance:.1f}",
            f"{np.degrees(self.angle):.2f}",
            f"{np.degrees(self.tilt_error):.1f}",
            f"{MILLI * self.strayed:.0f}",
        )


COLUMNS = (
    "motion",
    "capture margin, m",
    "cost",
    "iterations",
    "push, N",
    "runs",
    "fallen",
    "final, mm",
    "final, deg",
    "tilt off, deg",
    "CoM off, mm",
)


def asked(motion: str, margin: float | None) -> rg.Scenario:
    """The motion with this margin."""
    scenario = rg.find_scenario(motion)
    if margin is None:
        return scenario.with_values({"bounds.without": ["com_margin", "capture_margin"]})
    return scenario.with_values({"bounds.capture_margin": margin})


def pushes(horizon: float, force: float, runs: int, seed: int) -> Iterator[Push]:
    """One push for each run: the moment and the direction depend on the seed alone."""
    generator = np.random.default_rng(seed)
    for _ in range(runs):
        start = float(generator.uniform(0.1, 0.9)) * horizon
        direction = float(generator.uniform(-180.0, 180.0))
        yield Push(force=force, direction_deg=direction, start=start, duration=DURATION)


def rows(
    motions: Sequence[str], margins: Sequence[float | None], forces: Sequence[float], runs: int, seed: int
) -> Iterator[tuple[str, ...]]:
    """The table, row by row."""
    for motion in motions:
        for margin in margins:
            name = "none" if margin is None else f"{margin:g}"
            try:
                plan = rg.plan(asked(motion, margin), diagnose=False)
                joints = rg.track(plan)
            except RollgaitError as error:
                yield (motion, name, str(error), *[""] * (len(COLUMNS) - 3))
                continue
            planned = (f"{plan.statistics.cost:.2f}", str(plan.statistics.iterations))
            for force in forces:
                worst = Worst()
                for push in pushes(plan.horizon, force, runs, seed):
                    worst.add(rg.simulate(joints, Disturbances(pushes=(push,)), feedback=True).report())
                yield (motion, name, *planned, f"{force:g}", *worst.cells())


def main() -> None:
    """Pushes all motions and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--force", type=float, nargs="+", default=[50.0, 200.0], help="of the pushes, N")
    parser.add_argument("--runs", type=int, default=15, help="pushes of each plan (default: 15)")
    parser.add_argument("--seed", type=int, default=0, help="of moments and directions (default: 0)")
    parser.add_argument("--quick", action="store_true", help="one push of one plan, to see that it works")
    options = parser.parse_args()
    before = load()
    if options.quick:
        found = list(rows(MOTIONS[1:], MARGINS[-1:], options.force[:1], 1, options.seed))
    else:
        found = list(rows(MOTIONS, MARGINS, options.force, options.runs, options.seed))
    text = (
        f"## Pushes\n\n{machine()}; load {before} before, {load()} after.\n"
        f"Each push lasts {DURATION:g} s; random moments and directions, seed {options.seed}. Errors are the "
        f"worst of the runs without a fall.\n\n{table(COLUMNS, found)}"
    )
    print(text)
    if not options.quick:
        keep("pushes", text)


if __name__ == "__main__":
    main()
