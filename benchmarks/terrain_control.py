"""The controller on terrain, in MuJoCo: does CENTAURO get over it, and what does a step cost?

    python benchmarks/terrain_control.py [--seeds 10] [--worlds ramp,sill,bumps,kerb] [--quick] [--out FILE]

Each run begins at a random place and yaw, on ground of a random friction. Prints Markdown; exit status 1 if a
robot falls, stands for good, or does not get beyond what lies in its way.
"""

from __future__ import annotations

import argparse
import logging
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from reporting import load, machine, table
from rollgait import Terrain
from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.log import MODES, MpcLog
from rollgait.mpc.loop import no_collections
from rollgait.mpc.script import Script, TimedCommand
from rollgait.mpc.settings import MpcSettings
from rollgait.mpc.setup import make_loop
from rollgait.plant.disturbances import Disturbances
from rollgait.scenario import Start

PATIENT = 10.0
"""Deadline in s: what is judged is the motion, also on a machine that is busy."""
PLACE, YAW_DEG = 0.1, 6.0
"""Largest random place and yaw of a start, m and degrees."""
FRICTION = (0.6, 0.8)
"""Range of the true μ; the controller uses 0.5."""
TILT = float(np.tan(np.radians(15.0)))
CELL = 0.04
NEAR = 0.02
"""m; the log has the state before the last step."""
TIMED_STEPS = 400


@dataclass(frozen=True)
class World:
    """What lies in the way.

    Attributes:
        terrain: the ground.
        gait, speed: what is commanded, m/s.
        duration: longest, s.
        end: x that the CoM must reach, m: the run ends there.
    """

    terrain: Terrain
    gait: str
    speed: float
    duration: float
    end: float


def ramp() -> Terrain:
    """Up 15°, a plateau, down 15°."""
    top = 1.5 * TILT
    return Terrain.from_parts(
        [
            {"kind": "ramp", "x": 1.0, "length": 1.5, "slope_deg": 15.0},
            {"kind": "step", "x": 2.5, "length": 1.2, "height": top},
            {"kind": "ramp", "x": 3.7, "length": 1.5, "slope_deg": -15.0, "z": top},
        ]
    )


def bumps() -> Terrain:
    """Measured ground with bumps of 3 cm, half a metre apart."""
    x, y = np.meshgrid(np.arange(-2.0, 8.0, CELL), np.arange(-3.0, 3.0, CELL), indexing="ij")
    along, across = 1.0 - np.cos(4.0 * np.pi * (x - 0.7)), 1.0 - np.cos(2.0 * np.pi * y / 0.7)
    return Terrain.from_map(0.0075 * along * across * ((x > 0.7) & (x < 4.7)), CELL, (-2.0, -3.0))


def step(height: float, length: float) -> Terrain:
    """A sill, or a kerb up and down again."""
    return Terrain.from_parts([{"kind": "step", "x": 1.0, "height": height, "length": length}])


WORLDS = {
    "ramp up and down, 15°": World(ramp(), "drive", 0.4, 18.0, 5.7),
    "sill, 2 cm": World(step(0.02, 0.1), "drive", 0.4, 7.0, 1.8),
    "bumps, 3 cm": World(bumps(), "drive", 0.4, 15.0, 5.2),
    "kerb up and down, 10 cm": World(step(0.1, 1.5), "crawl", 0.1, 45.0, 3.1),
}


def main() -> int:
    """Prints or writes the page."""
    parser = argparse.ArgumentParser(description="The controller on terrain.")
    parser.add_argument("--seeds", type=int, default=10, help="runs of each world")
    parser.add_argument("--worlds", default=",".join(name.split()[0].strip(",") for name in WORLDS))
    parser.add_argument("--quick", action="store_true", help="the sill alone, once")
    parser.add_argument("--out", type=Path, help="write the page there")
    given = parser.parse_args()
    logging.getLogger("rollgait").setLevel(logging.ERROR)
    asked, seeds = (["sill"], 1) if given.quick else (given.worlds.split(","), given.seeds)
    worlds = {name: world for name, world in WORLDS.items() if name.split()[0].strip(",") in asked}
    failures: list[str] = []
    page = [
        "## The controller on terrain",
        f"`python benchmarks/terrain_control.py` ({machine()}; load {load()}).",
        _table(runs(worlds, seeds, failures)),
        _table(times(worlds)),
    ]
    text = "\n\n".join(page) + "\n"
    if given.out is None:
        print(text)
    else:
        given.out.write_text(text, encoding="utf-8")
    for failure in failures:
        print(failure, file=sys.stderr)
    return 1 if failures else 0


def runs(worlds: dict[str, World], seeds: int, failures: list[str]) -> list[tuple[object, ...]]:
    """Runs in MuJoCo, a row for each world."""
    rows: list[tuple[object, ...]] = [
        ("world", "gait", "m/s", "runs", "falls", "got over it", "largest tilt, °", "solves not used")
    ]
    for name, world in worlds.items():
        logs = []
        for seed in range(seeds):
            log = run(world, seed)
            logs.append(log)
            over, fallen = got_over(world, log), log.fallen_at is not None
            print(f"{name}, seed {seed}: {'over' if over else 'NOT over'}", file=sys.stderr, flush=True)
            if fallen or not over:
                failures.append(f"{name}, seed {seed}: {'fell' if fallen else 'is not over it'}")
        reports = [log.report() for log in logs]
        rows.append(
            (
                name,
                world.gait,
                world.speed,
                len(logs),
                sum(log.fallen_at is not None for log in logs),
                sum(got_over(world, log) for log in logs),
                f"{max(report.tilt_deg for report in reports):.1f}",
                sum(int((log.mode == MODES.index("coasting")).sum()) for log in logs),
            )
        )
    return rows


def run(world: World, seed: int) -> MpcLog:
    """One run in MuJoCo."""
    random = np.random.default_rng(seed)
    x, y, yaw = random.uniform(-1.0, 1.0, 3) * (PLACE, PLACE, YAW_DEG)
    loop = make_loop(
        "centauro",
        "mujoco",
        MpcSettings(deadline=PATIENT),
        gait=world.gait,
        disturbances=Disturbances(friction=random.uniform(*FRICTION)),
        start=Start(x=x, y=y, yaw_deg=yaw),
        terrain=world.terrain,
    )
    command = VelocityCommand(forward=world.speed, gait=world.gait)
    script = Script(duration=world.duration, gait=world.gait, commands=(TimedCommand(command=command),))
    return loop.run(script, lambda _: bool(loop.plant.state.com_position[0] > world.end))


def got_over(world: World, log: MpcLog) -> bool:
    """Whether the robot is beyond what lay in its way, and still under control."""
    return bool(log.com_position[-1, 0] > world.end - NEAR and log.mode[-1] != MODES.index("standing"))


def times(worlds: dict[str, World]) -> list[tuple[object, ...]]:
    """CPU time of steps on the rigid body, on level ground and on terrain, by turns of a hundred steps."""
    rows: list[tuple[object, ...]] = [
        ("gait, world", "level ground, CPU ms", "on terrain, CPU ms", "of it looking up the ground", "factor")
    ]
    for name, world in worlds.items():
        loops = [
            make_loop("centauro", "rigid", MpcSettings(deadline=PATIENT), gait=world.gait, terrain=terrain)
            for terrain in (None, world.terrain)
        ]
        seconds: list[list[float]] = [[], []]
        looking: list[float] = []
        fill = loops[1].mpc._fill
        put_ground = fill.put_ground

        def timed(*args: object, **options: object) -> None:
            begin = time.process_time()
            put_ground(*args, **options)  # noqa: B023
            looking.append(time.process_time() - begin)  # noqa: B023

        fill.put_ground = timed  # type: ignore[method-assign]
        command = VelocityCommand(forward=world.speed, gait=world.gait)
        with no_collections():
            for _ in range(TIMED_STEPS // 100):
                for loop, own in zip(loops, seconds, strict=True):
                    for _ in range(100):
                        before = loop.control.end if loop.control is not None else loop.plant.state
                        begin = time.process_time()
                        control, _ = loop.mpc.step(before, command)
                        own.append(time.process_time() - begin)
                        loop.plant.step(control)
                        loop.control = control
        level, terrain = (1e3 * float(np.median(own)) for own in seconds)
        rows.append(
            (
                f"{world.gait}, {name}",
                f"{level:.2f}",
                f"{terrain:.2f}",
                f"{1e3 * float(np.median(looking)):.2f}",
                f"{terrain / level:.2f}",
            )
        )
    return rows


def _table(rows: list[tuple[object, ...]]) -> str:
    return table(rows[0], rows[1:])


if __name__ == "__main__":
    sys.exit(main())
