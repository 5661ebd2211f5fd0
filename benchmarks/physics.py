"""Do the plans work? The whole body executes them in MuJoCo. Prints Markdown; docs/physics.md keeps a result.

    python benchmarks/physics.py [--count 20] [--seed 0] [--quick] [--out docs/physics.md]

First the four motions of the library, in both profiles, open loop and with feedback of the base pose; then
random goals under disturbances: half are driven to, half with steps.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import rollgait as rg
from random_goals import Case, cases
from reporting import load, machine, table
from rollgait.errors import RollgaitError
from rollgait.simulation import Disturbances, Payload, Push, SimulationReport

MOTIONS = ("wheeled", "hybrid-forward", "legged-forward", "hybrid-goback")
PROFILES = ("executable", "paper")
CONTROLS = {"open loop": False, "feedback": True}
PAYLOAD = Payload(mass=5.0, place=(0.1, 0.15, 0.2))
ROUGH = Disturbances(payload=PAYLOAD, friction=0.6, latency=3e-3, radius_error=0.01)
"""What the plan does not know of, all at once."""
PUSH_FORCE, PUSH_DURATION = 50.0, 0.2
"""N and s."""
QUICK_COUNT = 2
MILLI = 1e3


def main() -> int:
    """Prints or writes the page; 1 if a robot falls that should not."""
    parser = argparse.ArgumentParser(description="Plans, executed in MuJoCo.")
    parser.add_argument("--count", type=int, default=20, help="number of random goals")
    parser.add_argument("--seed", type=int, default=0, help="of the random goals and pushes")
    parser.add_argument("--quick", action="store_true", help="two motions and two goals only")
    parser.add_argument("--out", type=Path, help="write the page there")
    given = parser.parse_args()
    motions = MOTIONS[:2] if given.quick else MOTIONS
    count = QUICK_COUNT if given.quick else given.count
    before = load()
    falls: list[str] = []
    parts = [
        "# Physics",
        f"Result of `python benchmarks/physics.py` ({machine()}; load {before}).",
        INTRODUCTION,
        "## The four motions",
        *four_motions(motions, falls),
        "## Random goals",
        f"{count} goals (seed {given.seed}), |x| ≤ 1.5 m, |y| ≤ 0.8 m, |yaw| ≤ 90°, half of them driven to, "
        "half with steps; executable profile. Worst values of all runs.",
        random_goals(count, given.seed, falls),
        CONDITIONS,
    ]
    page = "\n\n".join(parts) + "\n"
    if given.out is not None:
        given.out.write_text(page, encoding="utf-8")
    else:
        print(page)
    for fall in falls:
        print(f"fallen: {fall}", file=sys.stderr)
    return 1 if falls else 0


INTRODUCTION = """\
The whole body executes plans of the single rigid body: hierarchical inverse kinematics, then joint PD and
feed-forward torques within the effort limits, in MuJoCo (1 ms, friction 0.8). The final error is that of the
base link in the ground plane, and its whole rotation, half a second after the motion. Slip is the speed of
loaded contact points over the ground. With feedback, the true base pose corrects the wheels and, after the
last step, the legs. Flat ground, rigid joints, a base pose without noise: a real robot will be worse."""

CONDITIONS = (
    f"Disturbed: {PAYLOAD.mass:g} kg at {PAYLOAD.place} m on the base link, friction {ROUGH.friction:g}, "
    f"{MILLI * ROUGH.latency:g} ms latency and wheels {100 * ROUGH.radius_error:g} % larger than known, all "
    f"at once. Push: {PUSH_FORCE:g} N for {PUSH_DURATION:g} s in a random direction at a random time."
)


def four_motions(motions: tuple[str, ...], falls: list[str]) -> Iterator[str]:
    """A table for each profile."""
    for profile in PROFILES:
        rows = []
        for name in motions:
            plan = rg.plan(name, profile=profile)
            joints = rg.track(plan, force=True)
            for control, feedback in CONTROLS.items():
                report = rg.simulate(joints, feedback=feedback).report()
                if report.fallen and profile == "executable":
                    falls.append(f"{name}, {control}")
                rows.append((name, control, *figures(report)))
        yield f"Profile `{profile}`:"
        yield table(("motion", "control", *COLUMNS), rows)


COLUMNS = (
    "fallen",
    "final, mm",
    "final, deg",
    "tilt, deg",
    "CoM rms, mm",
    "slip p95, mm/s",
    "forces rms, N",
    "torque, %",
    "× real time",
)


def figures(report: SimulationReport) -> tuple[str, ...]:
    """One row of the table."""
    return (
        f"at {report.fallen_at:.1f} s" if report.fallen_at is not None else "no",
        f"{MILLI * report.final_distance:.1f}",
        f"{np.degrees(report.final_angle):.2f}",
        f"{np.degrees(report.tilt):.1f}",
        f"{MILLI * report.com_rms:.1f}",
        f"{MILLI * report.slip_p95:.1f}",
        f"{np.sqrt(np.mean(np.square(report.force_rms))):.0f}",
        f"{100.0 * report.joints[0].share:.0f} ({report.joints[0].joint})",
        f"{report.real_time_factor:.1f}",
    )


@dataclass
class Tally:
    """What came of one condition over all goals."""

    runs: int = 0
    fallen: int = 0
    distance: float = 0.0
    angle: float = 0.0
    tilt: float = 0.0
    slip: float = 0.0

    def add(self, report: SimulationReport) -> None:
        """Counts a run; a fallen robot has no final pose."""
        self.runs += 1
        self.fallen += report.fallen
        if not report.fallen:
            self.distance = max(self.distance, report.final_distance)
            self.angle = max(self.angle, report.final_angle)
            self.tilt = max(self.tilt, report.tilt)
            self.slip = max(self.slip, report.slip_p95)


def random_goals(count: int, seed: int, falls: list[str]) -> str:
    """The table of the worst values, by condition and control; plans that fail are named below it."""
    tallies: dict[tuple[str, str], Tally] = {}
    not_planned = []
    generator = np.random.default_rng(seed)
    for case in cases(count, seed):
        direction, start = float(generator.uniform(-180.0, 180.0)), float(generator.uniform(0.2, 0.8))
        try:
            plan = rg.plan(case.asked())
            joints = rg.track(plan)
        except RollgaitError as error:
            not_planned.append(f"- {named(case)}: {error}")
            continue
        push = Push(
            force=PUSH_FORCE, direction_deg=direction, start=start * plan.horizon, duration=PUSH_DURATION
        )
        conditions = {"nominal": Disturbances(), "disturbed": ROUGH, "push": Disturbances(pushes=(push,))}
        for condition, given in conditions.items():
            for control, feedback in CONTROLS.items():
                report = rg.simulate(joints, given, feedback=feedback).report()
                tallies.setdefault((condition, control), Tally()).add(report)
                if report.fallen:
                    falls.append(f"{named(case)}, {condition}, {control}")
    columns = (
        "condition",
        "control",
        "runs",
        "fallen",
        "final, mm",
        "final, deg",
        "tilt, deg",
        "slip p95, mm/s",
    )
    rows = [
        (
            *key,
            t.runs,
            t.fallen,
            f"{MILLI * t.distance:.1f}",
            f"{np.degrees(t.angle):.2f}",
            f"{np.degrees(t.tilt):.1f}",
            f"{MILLI * t.slip:.1f}",
        )
        for key, t in tallies.items()
    ]
    return "\n".join([table(columns, rows), *(["\nNot planned:\n", *not_planned] if not_planned else [])])


def named(case: Case) -> str:
    """The case in words."""
    x, y, yaw = case.goal
    return f"{case.scenario} to ({x:g} m, {y:g} m, {yaw:g}°)"


if __name__ == "__main__":
    sys.exit(main())
