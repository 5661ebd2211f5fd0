"""Do robots of all kinds follow commands for a minute? Imported bare, on the rigid plant and in MuJoCo.

    python benchmarks/commands.py [--robots NAME,…] [--plants rigid,mujoco] [--gaits fitting,crawl] [--keep]

Each robot is imported from its URDF alone and follows a course that is scaled to it: ahead by 0.3 lengths of
its body (of the distance between its hips) per second, turning while it goes, on the spot, sideways, back,
and to a stop. Deadlines are long, so that a busy machine does not decide; time is that of the plant. Prints
Markdown; `--keep` puts it into docs/mpc-benchmark.md.
"""

from __future__ import annotations

import argparse
import importlib
import logging
import math
import sys
import tempfile
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

import rollgait as rg
from reporting import keep, load, machine, table
from rollgait.cli.mpc_input import first_gait
from rollgait.errors import RollgaitError
from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.footwork import ANYWHERE, Footwork
from rollgait.mpc.gaits import find_gait
from rollgait.mpc.log import MpcLog
from rollgait.mpc.script import Script, TimedCommand
from rollgait.mpc.settings import MpcSettings
from rollgait.mpc.setup import make_loop
from rollgait.robot.whole_body import DATA_PREFIX, data_file

HERE = Path(__file__).resolve().parent
AHEAD, ASIDE = 0.3, 0.1
"""Body lengths per second."""
TURN = 0.2
"""rad/s."""
COURSE = (
    (2.0, "ahead", (AHEAD, 0.0, 0.0)),
    (12.0, "ahead, to the left", (AHEAD, 0.0, TURN)),
    (22.0, "ahead, to the right", (AHEAD, 0.0, -TURN)),
    (32.0, "on the spot", (0.0, 0.0, TURN)),
    (40.0, "sideways", (0.0, ASIDE, 0.0)),
    (48.0, "back", (-AHEAD, 0.0, 0.0)),
    (56.0, "stop", (0.0, 0.0, 0.0)),
)
"""From when on, s; what; forward and lateral in body lengths per second, turn rate in rad/s."""
DURATION = 60.0
SPEEDING_UP = 3.0
"""So long after a new command the velocity may still be another, s."""
FOLLOWS = 0.1
"""A mean velocity may be off by this share of the one that is asked for."""
PATIENT = MpcSettings(deadline=10.0)
FITTING = "fitting"
"""In place of a gait: that with which `rollgait mpc` begins."""
PUBLIC = {
    "a1": "a1_description/urdf/a1.urdf",
    "anymal-b": "anymal_b_simple_description/robots/anymal.urdf",
    "anymal-c": "anymal_c_simple_description/urdf/anymal.urdf",
    "b1": "b1_description/urdf/b1.urdf",
    "go1": "go1_description/urdf/go1.urdf",
    "go2": "go2_description/urdf/go2.urdf",
    "hyq": "hyq_description/robots/hyq_no_sensors.urdf",
    "laikago": "laikago_description/urdf/laikago.urdf",
    "solo12": "solo_description/robots/solo12.urdf",
}
"""Quadrupeds of the package example-robot-data."""
OWN = ("rover", "strider", "centauro")
"""Of the library."""

COLUMNS = (
    "robot",
    "feet",
    "plant",
    "gait",
    "falls",
    "ahead, to the left, right, on the spot, sideways, back",
    "rms ahead, mm/s",
    "aside, mm/s",
    "turn, deg/s",
    "tilt, deg",
    "rest, mm/s",
    "outside the box, mm",
    "coasting",
    "stands",
)
WORDS = (
    f"{DURATION:g} s each at 100 Hz, deadlines of {PATIENT.deadline:g} s. Ahead and back are {AHEAD:g} of "
    f"the distance between the hips in a second, sideways {ASIDE:g}, turns {TURN:g} rad/s. Of each part of "
    f"the course the mean velocity, without its first {SPEEDING_UP:g} s, as a share of what is asked for (of "
    "several, the one that is farthest from it). What no gait of a robot can is left out; `cannot` where "
    "nothing is left. The rms is against the reference velocity; the sway of steps is part of it. Rest: the "
    "mean speed in the last second, steps on the spot included."
)


def main() -> int:
    """Prints the page, or keeps it; 1 if a robot falls, stands for good or does not follow."""
    everyone = (*lookalikes(), *PUBLIC, *OWN)
    parser = argparse.ArgumentParser(description="Commands, for a minute.")
    parser.add_argument("--robots", default=",".join(everyone), help="which, comma-separated")
    parser.add_argument("--plants", default="rigid,mujoco", help="which, comma-separated")
    parser.add_argument("--gaits", default=FITTING, help="which, comma-separated")
    parser.add_argument("--keep", action="store_true", help="put the table into docs/mpc-benchmark.md")
    parser.add_argument("--logs", type=Path, help="folder of the logs; what is there is not run again")
    given = parser.parse_args()
    logging.getLogger("rollgait").setLevel(logging.ERROR)
    rows, failures = [], []
    with tempfile.TemporaryDirectory() as folder:
        for name in given.robots.split(","):
            try:
                robot = imported(name, Path(folder))
            except RollgaitError as error:
                failures.append(f"{name}: {error}")
                print(failures[-1], file=sys.stderr, flush=True)
                continue
            for plant in given.plants.split(","):
                for asked in given.gaits.split(","):
                    begin = time.perf_counter()
                    gait = first_gait(course(robot), robot) if asked == FITTING else asked
                    log = driven(robot, plant, gait, given.logs and given.logs / f"{name}-{plant}-{gait}.npz")
                    rows.append(cells(name, gait, robot, log))
                    failures += [f"{name}, {plant}, {gait}: {why}" for why in faults(robot, log)]
                    seconds = time.perf_counter() - begin
                    print(f"{rows[-1]} {seconds:.0f} s {log.report().events}", file=sys.stderr, flush=True)
    page = [
        f"## Commands, for a minute\n\n`python benchmarks/commands.py` ({machine()}; load {load()}).",
        WORDS,
    ]
    text = "\n\n".join([*page, table(COLUMNS, rows)])
    if given.keep:
        keep("commands", text, HERE.parent / "docs" / "mpc-benchmark.md")
    else:
        print(text)
    for failure in failures:
        print(failure, file=sys.stderr)
    return 1 if failures else 0


def lookalikes() -> dict[str, Any]:
    """Quadrupeds of primitives with the features of robots that people own, by name: those of the tests."""
    sys.path.insert(0, str(HERE.parent))
    try:
        found: dict[str, Any] = importlib.import_module("tests.robot.lookalikes").LOOKALIKES
    finally:
        sys.path.remove(str(HERE.parent))
    return found


def imported(name: str, folder: Path) -> rg.Robot:
    """A robot by its name in this benchmark, found in its URDF if it is not of the library."""
    if name in OWN:
        return rg.find_robot(name)
    if name in lookalikes():
        urdf = folder / f"{name}.urdf"
        urdf.write_text(lookalikes()[name].urdf(), encoding="utf-8")
    else:
        urdf = data_file("urdf", DATA_PREFIX + PUBLIC[name])
    files = rg.import_robot(urdf).save(folder / f"{name}.yaml")
    return rg.find_robot(str(files.robot))


def length(robot: rg.Robot) -> float:
    """Of the body: between front and rear hips, m."""
    return float(np.ptp(robot.stance[:, 0]))


def course(robot: rg.Robot) -> Script:
    """The course, scaled to a robot."""
    long = length(robot)
    commands = [TimedCommand(command=VelocityCommand())]
    for at, _, (forward, lateral, turn) in COURSE:
        velocity = VelocityCommand(forward=long * forward, lateral=long * lateral, turn_rate=turn)
        commands.append(TimedCommand(at=at, command=velocity))
    return Script(duration=DURATION, commands=tuple(commands))


def driven(robot: rg.Robot, plant: str, gait: str, file: Path | None) -> MpcLog:
    """A run of the course, or its log if there is one."""
    if file is not None and file.is_file():
        return MpcLog.load(file)
    log = make_loop(robot, plant, PATIENT, gait=gait).run(course(robot))
    if file is not None:
        log.save(file)
    return log


def velocities(log: MpcLog, begin: float, end: float) -> np.ndarray:
    """Mean velocity ahead and aside, m/s, and yaw rate, rad/s, in a time, (3,); NaN if it was not reached."""
    part = (log.time >= begin) & (log.time < end)
    if not part.any() or log.time[-1] < end - 2.0 * log.period:
        return np.full(3, np.nan)
    c, s = np.cos(log.euler[part, 0]), np.sin(log.euler[part, 0])
    v = log.com_velocity[part]
    return np.array(
        [
            np.mean(c * v[:, 0] + s * v[:, 1]),
            np.mean(c * v[:, 1] - s * v[:, 0]),
            np.mean(log.euler_rate[part, 0]),
        ]
    )


def shares(robot: rg.Robot, log: MpcLog) -> Iterable[tuple[str, float | None]]:
    """What part of what is asked for is done in each part of the course; None if its feet cannot.

    Of several velocities it is the one that is farthest from what is asked for.
    """
    feet = Footwork(robot)
    able = np.array(feet.able(find_gait(feet.fitting(ANYWHERE))))
    ends = [at for at, _, _ in COURSE[1:]]
    for (at, what, wanted), end in zip(COURSE, ends, strict=False):
        asked = np.array(wanted) * [length(robot), length(robot), 1.0]
        counts = (asked != 0.0) & able
        found = velocities(log, at + SPEEDING_UP, end)[counts] / asked[counts]
        yield what, float(found[np.argmax(np.abs(found - 1.0))]) if counts.any() else None


def faults(robot: rg.Robot, log: MpcLog) -> list[str]:
    """What is wrong with a run."""
    report = log.report()
    if not report.passed:
        return [f"{report.verdict} {report.events}"]
    return [
        f"{what}: {100.0 * share:.0f} % of what is asked for {report.events}"
        for what, share in shares(robot, log)
        if share is not None and not abs(share - 1.0) <= FOLLOWS
    ]


def cells(name: str, gait: str, robot: rg.Robot, log: MpcLog) -> tuple[str, ...]:
    """A row of the table."""
    report = log.report()
    last = log.time > DURATION - 1.0
    rest = 1e3 * float(np.mean(np.linalg.norm(log.com_velocity[last], axis=1))) if last.any() else math.nan
    return (
        name,
        robot.leg_list[0].foot,
        log.plant,
        gait,
        "none" if report.fallen_at is None else f"{report.fallen_at:.1f} s",
        ", ".join("cannot" if share is None else f"{100.0 * share:.0f} %" for _, share in shares(robot, log)),
        f"{1e3 * report.forward_rms:.0f}",
        f"{1e3 * report.lateral_rms:.0f}",
        f"{math.degrees(report.turn_rms):.1f}",
        f"{report.tilt_deg:.1f}",
        f"{rest:.1f}",
        f"{1e3 * report.outside:.0f}",
        str(report.coasting),
        str(report.standing),
    )


if __name__ == "__main__":
    sys.exit(main())
