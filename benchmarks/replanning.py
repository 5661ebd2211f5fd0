"""Replans plans in mid-motion, from random states of runs of the controller with pushes.

    python benchmarks/replanning.py [--scenarios NAME,NAME] [--plants rigid,mujoco] [--states 5] [--out FILE]

Each run carries out a plan and is pushed with 50 N for 0.2 s at a random time in a random direction; at
random times the rest of the plan is planned anew from the measured state. Time is that of the processor,
which counts on a busy machine; that of the wall is beside it. Prints Markdown; exit status 1 if fewer than
95 % are certified, or one of them took more than 0.5 s.
"""

from __future__ import annotations

import argparse
import logging
import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import rollgait as rg
from reporting import machine, table
from rollgait.mpc.execution import execute, loop_for
from rollgait.mpc.script import TimedPush

SCENARIOS = ("wheeled", "legged-forward", "hybrid-forward", "kerb", "gap")
PLANTS = ("rigid", "mujoco")
PUSH, PUSH_DURATION = 50.0, 0.2
"""N, s."""
WITHIN = (0.05, 0.85)
"""Share of the plan in which states are taken."""
CERTIFIED_SHARE, SECONDS = 0.95, 0.5
"""What is asked for."""
STANDING = 0.5
"""s, by which a plan that had to wait is put off: as the controller has it."""


@dataclass(frozen=True)
class Moment:
    """A state of a run, and the time of the plan then, s; whether the plan waits there."""

    plan_time: float
    state: rg.MotionState
    waits: bool


@dataclass(frozen=True)
class Replanned:
    """What came of a moment: how far it was off (m), seconds of processor and wall, and what failed."""

    off: float
    processor: float
    wall: float
    failed: str


def main() -> int:
    """Prints or writes the page."""
    parser = argparse.ArgumentParser(description="Replans in mid-motion.")
    parser.add_argument("--scenarios", default=",".join(SCENARIOS))
    parser.add_argument("--plants", default=",".join(PLANTS))
    parser.add_argument("--states", type=int, default=5, help="random states of each run")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, help="write the page there")
    given = parser.parse_args()
    logging.getLogger("rollgait").setLevel(logging.ERROR)
    random, planner = np.random.default_rng(given.seed), rg.Planner()
    rows: list[tuple[object, ...]] = []
    every: list[Replanned] = []
    for name in given.scenarios.split(","):
        plan = planner.plan(name)
        planner.plan(plan.rest(0.0))  # what it derives and compiles is not of replanning
        for plant in given.plants.split(","):
            found = [replan(planner, plan, one) for one in moments(plan, plant, given.states, random)]
            every += found
            rows.append((name, plant, *row_of(found)))
            print(*rows[-1], [one.failed for one in found if one.failed], file=sys.stderr, flush=True)
    certified = [one for one in every if not one.failed]
    slow = sum(one.processor > SECONDS for one in certified)
    head = (
        "plan",
        "plant",
        "certified",
        "off its plan, mm, most",
        "processor, s: median, most",
        "wall, s: most",
    )
    summary = f"{len(certified)} of {len(every)} certified"
    page = [
        "# Replanning in mid-motion",
        f"{summary}, {slow} of them in more than {SECONDS:g} s of processor time.",
        machine(),
        table(head, rows),
        *[f"- failed: {one.failed}" for one in every if one.failed],
    ]
    text = "\n\n".join(page) + "\n"
    print(text) if given.out is None else given.out.write_text(text)
    return 0 if every and len(certified) >= CERTIFIED_SHARE * len(every) and not slow else 1


def moments(plan: rg.Plan, plant: str, count: int, random: np.random.Generator) -> list[Moment]:
    """Random moments of a run with a push."""
    loop = loop_for(plan, plant)
    times = sorted(random.uniform(*WITHIN, count) * plan.horizon)
    angle = random.uniform(-math.pi, math.pi)
    force = (PUSH * math.cos(angle), PUSH * math.sin(angle), 0.0)
    at = float(random.uniform(0.1, 0.6) * plan.horizon)
    found: list[Moment] = []

    def watch(_: float) -> bool:
        progress = loop.mpc.progress
        if progress is not None and progress.plan_time >= times[len(found)]:
            state = rg.MotionState.of(loop.plant.state, loop.control)
            found.append(Moment(progress.plan_time, state, progress.phase == "holding"))
        return len(found) == count

    execute([plan], loop, watch, [TimedPush(at=at, force=force, duration=PUSH_DURATION)])
    return found


def replan(planner: rg.Planner, plan: rg.Plan, moment: Moment) -> Replanned:
    """Plans the rest of a plan from a moment."""
    planned = plan.state_at(moment.plan_time)
    off = float(np.hypot(*(moment.state.com_position - planned.com_position)[:2]))
    processor, wall = time.process_time(), time.perf_counter()
    failed = ""
    try:
        rest = plan.rest(moment.plan_time, moment.state, STANDING if moment.waits else 0.0)
        new = planner.plan(rest, diagnose=False)
        failed = ", ".join(str(row) for row in new.certificate().failures)
    except rg.RollgaitError as error:
        failed = str(error)
    where = f"{plan.scenario.description or plan.robot.name} at {moment.plan_time:.2f} s: " if failed else ""
    seconds = time.process_time() - processor, time.perf_counter() - wall
    return Replanned(off, *seconds, where + failed)


def row_of(found: list[Replanned]) -> tuple[object, ...]:
    """Certified, farthest off, processor and wall time of the replans of a run."""
    if not found:
        return ("0 of 0", "", "", "")
    done = sum(not one.failed for one in found)
    processor = [one.processor for one in found]
    return (
        f"{done} of {len(found)}",
        f"{1e3 * max(one.off for one in found):.0f}",
        f"{np.median(processor):.2f}, {max(processor):.2f}",
        f"{max(one.wall for one in found):.2f}",
    )


if __name__ == "__main__":
    sys.exit(main())
