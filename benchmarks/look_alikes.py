"""Does a robot that somebody owns come from its URDF to motions that it carries out? Prints Markdown.

    python benchmarks/look_alikes.py [--parts first goals] [--robots NAME|FILE.urdf …] [--goals 12]
                                     [--execute 12] [--seed 0] [--cold] [--json] [--quick]

Robots: the look-alikes of tests/robot/lookalikes.py, quadrupeds of the package example-robot-data, or any
URDF. Part `first`: the commands that a user types, each in a fresh process, in a folder that holds nothing
but the URDF: `rollgait robot import FILE.urdf`, then what that prints as next. `--cold`: no kernels are
compiled yet. What was imported is compared with what pinocchio alone finds. Part `goals`: random goals,
|x| ≤ 2 and |y| ≤ 1 body lengths and |yaw| ≤ 90°, gaits found; the first `--execute` of them are carried out
in MuJoCo with feedback.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import rollgait as rg
from flat_goals import Outcome, attempt, cases
from independent import Differences, compare
from reporting import keep, load, machine, table
from reporting.execution import ANGLE_MAX, DISTANCE_MAX
from rollgait.errors import RollgaitError

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.robot.lookalikes import LOOKALIKES

PARTS = ("first", "goals")
SECONDS_MAX = 60.0
"""From a bare URDF to its first scenario simulated, s of wall time."""
CERTIFIED_MIN = 0.95
"""Share of all goals that are certified."""
DATA = Path("cmeel.prefix/share/example-robot-data/robots")
"""Where the package has its robots, from a folder of packages."""
PUBLIC = {
    "solo12": "solo_description/robots/solo12.urdf",
    "hyq": "hyq_description/robots/hyq_no_sensors.urdf",
    "anymal-b": "anymal_b_simple_description/robots/anymal.urdf",
    "anymal-c": "anymal_c_simple_description/urdf/anymal.urdf",
    "a1": "a1_description/urdf/a1.urdf",
    "go1": "go1_description/urdf/go1.urdf",
    "go2": "go2_description/urdf/go2.urdf",
    "b1": "b1_description/urdf/b1.urdf",
    "laikago": "laikago_description/urdf/laikago.urdf",
}
"""Quadrupeds of example-robot-data."""


@dataclass(frozen=True)
class First:
    """What came of the commands for one robot.

    Attributes:
        robot: its name.
        feet: their kind.
        words: of the command that did not end with 0; "" if all did.
        seconds: of wall time for the import, and for all.
        certified, tracked, stands: of the first scenario.
        distance, angle: of the base from its plan at the end, open loop, mm and degrees.
        differences: from what pinocchio finds.
    """

    robot: str
    feet: str = ""
    words: str = ""
    seconds: tuple[float, float] = (0.0, 0.0)
    certified: bool = False
    tracked: bool = False
    stands: bool = False
    distance: float = 0.0
    angle: float = 0.0
    differences: Differences | None = None

    @property
    def passed(self) -> bool:
        """Whether it came all the way in time."""
        return self.certified and self.tracked and self.stands and self.seconds[1] <= SECONDS_MAX

    def row(self) -> tuple[object, ...]:
        """Its cells."""
        if self.words:
            return (self.robot, self.feet, self.words, *[""] * 9)
        yes = ["yes" if good else "no" for good in (self.certified, self.tracked, self.stands)]
        seen = self.differences
        assert seen is not None
        radius = "a mesh" if seen.radius is None else f"{1e3 * seen.radius:.2f}"
        return (
            self.robot,
            self.feet,
            *(f"{s:.1f}" for s in self.seconds),
            *yes,
            f"{self.distance:.1f}",
            f"{self.angle:.2f}",
            f"{100.0 * seen.mass:.3f}",
            radius,
            f"{1e3 * seen.track:.2f}",
            f"{1e3 * seen.reach:.2f}",
        )


FIRST_COLUMNS = (
    "robot",
    "feet",
    "import, s",
    "all, s",
    "certified",
    "tracked",
    "stands",
    "final, mm",
    "final, °",
    "mass off, %",
    "radius off, mm",
    "track off, mm",
    "reach off, mm",
)


def urdf_of(name: str, folder: Path) -> Path:
    """The URDF of a robot, in an empty folder if it is a look-alike.

    Raises:
        SystemExit: there is no such robot.
    """
    if name in LOOKALIKES:
        file = folder / f"{name}.urdf"
        file.write_text(LOOKALIKES[name].urdf(), encoding="utf-8")
        return file
    if name in PUBLIC:
        return next(file for entry in sys.path if (file := Path(entry) / DATA / PUBLIC[name]).is_file())
    if Path(name).is_file():
        return Path(name).resolve()
    sys.exit(f"--robots {name}: no such robot or file; there are {', '.join([*LOOKALIKES, *PUBLIC])}")


def first(name: str, cold: bool) -> First:
    """Types the commands, and looks at what they wrote."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        urdf = urdf_of(name, folder)
        asked = urdf.name if urdf.parent == folder else str(urdf)
        environment = dict(os.environ)
        if cold:
            environment["ROLLGAIT_CACHE"] = str(folder / "cache")
        begin = time.perf_counter()
        done = _typed(f"rollgait robot import {asked}", folder, environment)
        imported = time.perf_counter() - begin
        if done.returncode:
            return First(name, words=done.stderr.strip())
        command = next(line for line in done.stdout.splitlines() if line.startswith("next:"))
        done = _typed(command.removeprefix("next:"), folder, environment)
        seconds = imported, time.perf_counter() - begin
        (robot,), (legs,) = folder.glob("*-robot.yaml"), folder.glob("*-legs.yaml")
        feet = "/".join(dict.fromkeys(leg.foot for leg in rg.find_robot(str(robot)).leg_list))
        (out,) = (
            (file.parent for file in folder.glob("*-run/report.html")) if not done.returncode else (None,)
        )
        if out is None:
            return First(name, feet, done.stderr.strip() or done.stdout.strip()[-300:], seconds)
        report = rg.SimulationLog.load(out / "simulation.npz").report()
        return First(
            name,
            feet,
            seconds=seconds,
            certified=rg.Plan.load(out / "plan.npz").certificate().passed,
            tracked=rg.JointTrajectory.load(out / "joints.npz").report.passed,
            stands=not report.fallen,
            distance=1e3 * report.final_distance,
            angle=float(np.degrees(report.final_angle)),
            differences=compare(urdf, robot, legs),
        )


def _typed(command: str, folder: Path, environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    words = [sys.executable, "-m", *shlex.split(command)]
    return subprocess.run(
        words, cwd=folder, env=environment, capture_output=True, text=True, encoding="utf-8", check=False
    )


def goals(name: str, count: int, seed: int, execute: int, planner: rg.Planner) -> Iterator[Outcome]:
    """What comes of random goals of one robot, one after the other."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        found = rg.import_robot(urdf_of(name, folder))
        body = rg.find_robot(str(found.save(folder / f"{name_of(name)}-robot.yaml").robot))
        for case in cases(name_of(name), body, count, seed):
            yield attempt(case, body, planner, case.number < execute)


def name_of(robot: str) -> str:
    """What a robot or the file of one is called."""
    return Path(robot).stem


def goals_report(results: Sequence[Outcome]) -> str:
    """The tables."""
    rows, names = [], list(dict.fromkeys(r.case.robot for r in results))
    for name in names:
        mine = [r for r in results if r.case.robot == name]
        runs = [r.execution for r in mine if r.execution is not None]
        ended = [run for run in runs if run.fallen_at is None and not run.refused]
        worst = [f"{max(values):.2f}" for values in zip(*((r.distance, r.angle) for r in ended), strict=True)]
        rows.append(
            (
                name,
                len(mine),
                sum(not r.reason for r in mine),
                f"{np.median([r.seconds for r in mine]):.1f}",
                f"{max(r.seconds for r in mine):.1f}",
                len(runs),
                sum(run.fallen_at is not None for run in runs),
                sum(run.passed for run in runs),
                *(worst or ["", ""]),
            )
        )
    head = ("robot", "goals", "certified", "median, s", "longest, s", "executed", "fallen")
    parts = [table((*head, "within limits", "worst, mm", "worst, °"), rows)]
    failed = [
        (
            f"{r.case.robot} {r.case.number}",
            *r.case.goal,
            r.reason or str(r.execution),
        )
        for r in results
        if r.reason or (r.execution is not None and not r.execution.passed)
    ]
    if failed:
        parts.append(table(("not as it should be", "x, m", "y, m", "yaw, deg", "why"), failed))
    return "\n\n".join(parts)


def main() -> int:
    """Runs the parts asked for and prints what came of them; 1 if not all is as it should be."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=list(PARTS), help="which")
    parser.add_argument("--robots", nargs="+", help="which, by name, or URDF files; default: all")
    parser.add_argument("--goals", type=int, default=12, help="of each robot (default: 12)")
    parser.add_argument(
        "--execute", type=int, default=12, help="so many of the first in MuJoCo (default: 12)"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the goals (default: 0)")
    parser.add_argument("--cold", action="store_true", help="part first: with no compiled kernels")
    parser.add_argument("--json", action="store_true", help="print JSON, and keep nothing")
    parser.add_argument("--quick", action="store_true", help="one robot and goal, to see that it works")
    options = parser.parse_args()
    robots = options.robots or (["fixed-at-joint"] if options.quick else [*LOOKALIKES, *PUBLIC])
    before = load()
    firsts: list[First] = []
    if "first" in options.parts:
        for name in robots:
            firsts.append(replace(first(name, options.cold), robot=name_of(name)))
            _say(" | ".join(str(cell) for cell in firsts[-1].row()))
    results: list[Outcome] = []
    if "goals" in options.parts:
        planner, count = rg.Planner(), 1 if options.quick else options.goals
        for name in robots:
            try:
                for r in goals(name, count, options.seed, options.execute, planner):
                    results.append(r)
                    said = f"{r.case.robot} {r.case.number} {r.case.goal}: {r.tried} tried, {r.steps} steps"
                    moved = "" if r.execution is None else str(r.execution)
                    _say(f"{said}, {r.iterations} it, {r.seconds:.2f} s  {moved} {r.reason[:300]}")
            except RollgaitError as error:
                sys.exit(f"{name}: {error}")
    if options.json:
        print(json.dumps({"first": [asdict(r) for r in firsts], "goals": [asdict(r) for r in results]}))
    else:
        text = _page(firsts, results, options, before)
        print(text)
        if not options.quick and not options.robots and len(options.parts) == len(PARTS):
            keep("look_alikes", text)
    runs = [r.execution for r in results if r.execution is not None]
    certified = sum(not r.reason for r in results) >= CERTIFIED_MIN * len(results)
    return 0 if all(r.passed for r in firsts) and certified and all(r.passed for r in runs) else 1


def _page(firsts: Sequence[First], results: Sequence[Outcome], options: Any, before: str) -> str:
    parts = [f"## Robots from their URDF\n\n{machine()}; load {before} before, {load()} after."]
    if firsts:
        parts.append(
            "From a bare URDF to the first scenario simulated, open loop, by the commands that users type"
            f"{', no kernels compiled yet' if options.cold else ''}; what differs from what pinocchio finds."
        )
        parts.append(table(FIRST_COLUMNS, (r.row() for r in firsts)))
    if results:
        good, runs = sum(not r.reason for r in results), [r.execution for r in results if r.execution]
        parts.append(
            f"Random goals, seed {options.seed}, gaits found: {good} of {len(results)} certified "
            f"({100.0 * good / len(results):.1f} %). In MuJoCo with feedback: {sum(r.passed for r in runs)} "
            f"of {len(runs)} stay on their feet and end within {DISTANCE_MAX:g} mm and {ANGLE_MAX:g}° of "
            "their plans."
        )
        parts.append(goals_report(results))
    return "\n\n".join(parts)


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
