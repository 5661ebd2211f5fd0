"""The controller in real time: how long a step takes, what one iteration costs, what becomes of the robot.

    python benchmarks/mpc.py [--parts time,cost,physics,motions,memory] [--seeds 10] [--out FILE]

Prints Markdown; docs/mpc-benchmark.md keeps a result.
"""

from __future__ import annotations

import argparse
import gc
import logging
import resource
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

import rollgait as rg
from reporting import load, machine, table
from rollgait.mpc.log import MpcLog
from rollgait.mpc.loop import ClosedLoop, no_collections
from rollgait.mpc.script import RandomScript, Script, script_of
from rollgait.mpc.settings import MpcSettings
from rollgait.mpc.setup import make_loop
from rollgait.robot import LEG_NAMES

TIMED = ((1.0, 0.1, True), (1.0, 0.05, True), (1.5, 0.1, True), (1.5, 0.05, True), (1.0, 0.1, False))
"""Horizon in s, interval in s, compiled or not."""
TIMED_DURATION = 30.0
"""s of driving, crawling and trotting with pushes."""
COST_SEEDS = (0, 1, 2)
COST_DURATION, COST_NOISE, COST_PUSH = 40.0, 0.01, 100.0
"""s; m/s in each period; N."""
CONVERGED_ITERATIONS = 50
PATIENT = 10.0
"""Deadline in s where only the motion counts, not the time it takes."""
GAITS = ("drive", "crawl", "trot", "walk", "stand")
FALL_DURATION, FALL_PUSH = 60.0, 100.0
MOTIONS = ("wheeled", "hybrid-forward", "legged-forward", "hybrid-goback")
LATELY = 0.05
"""s before and after a step within which what happens is said of it."""
SAMPLE_EVERY = 10_000
"""Steps between two looks at the memory."""
MEMORY_DURATION = 600.0
"""s: ten minutes of control."""


def main() -> int:
    """Prints or writes the page; 1 if a robot falls or stands for good."""
    parser = argparse.ArgumentParser(description="The controller in closed loop.")
    parser.add_argument("--parts", default=",".join(PARTS), help="what to measure, comma-separated")
    parser.add_argument("--seeds", type=int, default=10, help="random runs in MuJoCo")
    parser.add_argument("--out", type=Path, help="write the page there")
    given = parser.parse_args()
    logging.getLogger("rollgait").setLevel(logging.ERROR)
    failures: list[str] = []
    page = ["# The controller in closed loop", f"`python benchmarks/mpc.py` ({machine()}; load {load()})."]
    for name in given.parts.split(","):
        print(f"{name} …", file=sys.stderr, flush=True)
        page += PARTS[name](given.seeds, failures)
    text = "\n\n".join(page) + "\n"
    if given.out is None:
        print(text)
    else:
        given.out.write_text(text, encoding="utf-8")
    for failure in failures:
        print(failure, file=sys.stderr)
    return 1 if failures else 0


def step_times(seeds: int, failures: list[str]) -> list[str]:
    """Wall time of steps, by horizon and interval, on the rigid body."""
    rows = [
        (
            "horizon",
            "interval",
            "kernels",
            "solver, median",
            "p99",
            "whole step, median",
            "p99",
            "worst",
            "where",
            "late",
        )
    ]
    for horizon, interval, kernels in TIMED:
        settings = MpcSettings(horizon=horizon, interval=interval)
        loop = make_loop("centauro", "rigid", settings, kernels=kernels)
        script = RandomScript(duration=TIMED_DURATION, push=COST_PUSH).script()
        slowest = Slowest(loop, script)
        report = loop.run(script, slowest).report()
        rows.append(
            (
                f"{horizon:g} s",
                f"{interval:g} s",
                "compiled" if kernels else "no compiler",
                f"{report.solver_median_ms:.2f} ms",
                f"{report.solver_p99_ms:.2f} ms",
                f"{report.median_ms:.2f} ms",
                f"{report.p99_ms:.2f} ms",
                f"{report.worst_ms:.1f} ms",
                slowest.moment,
                f"{report.late} of {report.steps}",
            )
        )
    return ["## Time of a step", TIMES, table(rows[0], rows[1:])]


class Slowest:
    """Watches a run for its slowest step and says what happened then.

    Attributes:
        moment: time, gait, feet that landed or left, pushes, iterations.
    """

    def __init__(self, loop: ClosedLoop, script: Script) -> None:
        self._loop, self._pushes = loop, script.pushes
        self._seconds, self.moment = 0.0, ""

    def __call__(self, time: float) -> None:
        """After each step."""
        prediction = self._loop.prediction
        assert prediction is not None
        status = prediction.status
        if status.seconds > self._seconds:
            self._seconds = status.seconds
            iterations = f"{status.iterations} iteration{'s' if status.iterations != 1 else ''}"
            parts = [f"t = {time:.2f} s", self._loop.mpc.clock.gait.name, *self._lately(time), iterations]
            self.moment = ", ".join(parts)

    def _lately(self, time: float) -> list[str]:
        found = []
        for swing in self._loop.mpc.clock.swings(time - LATELY, time + LATELY):
            leg = LEG_NAMES[swing.leg]
            found += [f"{leg} leaves"] * (abs(swing.lift_off - time) <= LATELY)
            found += [f"{leg} lands"] * (abs(swing.touch_down - time) <= LATELY)
        pushed = any(push.at <= time <= push.at + push.duration + LATELY for push in self._pushes)
        return found + ["pushed"] * pushed


def real_time_cost(seeds: int, failures: list[str]) -> list[str]:
    """Closed-loop cost of one iteration a step against full convergence."""
    rows = [("seed", "1 iteration", f"up to {CONVERGED_ITERATIONS}", "difference")]
    for seed in COST_SEEDS:
        script = RandomScript(seed=seed, duration=COST_DURATION, push=COST_PUSH).script()
        costs = []
        for iterations in (1, CONVERGED_ITERATIONS):
            settings = MpcSettings(iterations=iterations, deadline=PATIENT)
            costs.append(_noisy(settings, seed).run(script).report().cost)
        rows.append(
            (str(seed), f"{costs[0]:.3f}", f"{costs[1]:.3f}", f"{100.0 * (costs[0] / costs[1] - 1.0):+.2f} %")
        )
    return ["## One iteration instead of convergence", COSTS, table(rows[0], rows[1:])]


def _noisy(settings: MpcSettings, seed: int) -> ClosedLoop:
    from rollgait.mpc.mpc import Mpc
    from rollgait.mpc.plants.rigid import RigidPlant

    robot = rg.find_robot("centauro")
    return ClosedLoop(Mpc(robot, settings), RigidPlant(robot, noise=COST_NOISE, seed=seed))


def random_runs(seeds: int, failures: list[str]) -> list[str]:
    """Random commands, gaits and pushes in MuJoCo."""
    rows = [("seed", "falls", "forward rms", "lateral rms", "turn rms", "tilt", "coasting", "late", "events")]
    for seed in range(seeds):
        script = RandomScript(seed=seed, duration=FALL_DURATION, push=FALL_PUSH, gaits=GAITS).script()
        report = make_loop("centauro", "mujoco").run(script).report()
        if not report.passed:
            failures.append(f"seed {seed}: fallen at {report.fallen_at}, standing {report.standing}")
        rows.append(
            (
                str(seed),
                "none" if report.fallen_at is None else f"at {report.fallen_at:.1f} s",
                f"{report.forward_rms:.3f} m/s",
                f"{report.lateral_rms:.3f} m/s",
                f"{report.turn_rms:.3f} rad/s",
                f"{report.tilt_deg:.1f}°",
                str(report.coasting),
                str(report.late),
                "; ".join(report.events) or "–",
            )
        )
        print(f"  seed {seed}: {rows[-1]}", file=sys.stderr, flush=True)
    return ["## Random commands in MuJoCo", RUNS, table(rows[0], rows[1:])]


def four_motions(seeds: int, failures: list[str]) -> list[str]:
    """The paper's motions as commands, in MuJoCo."""
    rows = [("motion", "duration", "place", "yaw", "tilt")]
    for name in MOTIONS:
        script = script_of(rg.find_scenario(name))
        log = make_loop("centauro", "mujoco", gait=script.gait).run(script)
        place, yaw = _miss(log, script.commands[-1].command)
        rows.append(
            (
                name,
                f"{script.duration:.1f} s",
                f"{1e3 * place:.1f} mm",
                f"{yaw:+.2f}°",
                f"{log.report().tilt_deg:.1f}°",
            )
        )
        if not log.report().passed or place > 0.03 or abs(yaw) > 2.0:
            failures.append(f"{name}: {place:.3f} m, {yaw:.2f} deg from its goal")
    return ["## The four motions as commands", GOALS, table(rows[0], rows[1:])]


def _miss(log: MpcLog, command: object) -> tuple[float, float]:
    goal = np.array([command.x, command.y])  # type: ignore[attr-defined]  # scripts of motions hold poses
    yaw = float(np.degrees(log.euler[-1, 0])) - command.yaw_deg  # type: ignore[attr-defined]
    return float(np.linalg.norm(log.com_position[-1, :2] - goal)), yaw


def memory(seeds: int, failures: list[str]) -> list[str]:
    """Memory of the process over ten minutes of control."""
    loop = make_loop("centauro", "rigid")
    script = RandomScript(duration=MEMORY_DURATION, push=COST_PUSH).script()
    pushes = list(script.pushes)
    rows = [("after", "resident memory", "objects")]
    with no_collections():
        while loop.time < MEMORY_DURATION:
            if pushes and pushes[0].at <= loop.time:
                push = pushes.pop(0)
                loop.plant.push(np.array(push.force), push.duration)
            loop.step(script.command_at(loop.time))
            gc.collect(0)  # SciPy's integrator, which is the plant here, makes cycles; the controller none
            if round(loop.time / loop.mpc.settings.period) % SAMPLE_EVERY == 0:
                rows.append((f"{loop.time:.0f} s", f"{_resident():.1f} MB", str(len(gc.get_objects()))))
    return ["## Memory over ten minutes", table(rows[0], rows[1:])]


def _resident() -> float:
    """MB."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * resource.getpagesize() / 1e6


TIMES = (
    "The solver: one real-time iteration, and up to three more where that leaves a constraint violated by "
    "more than 0.02. The whole step: also judging the state, the gait, the reference, filling in the "
    "numbers, and the control. CENTAURO on the rigid-body plant; driving, crawling and trotting under random "
    "commands and 100 N pushes. Where: the slowest step; feet that land or leave and pushes within "
    f"{LATELY:g} s of it. Late: longer than the period of 10 ms."
)
COSTS = (
    f"Mean cost per second of closed loop on the rigid-body plant (DOP853), {COST_DURATION:g} s of random "
    f"commands with changes of gait, {COST_NOISE:g} m/s of velocity noise in each period, {COST_PUSH:g} N "
    "pushes."
)
RUNS = (
    f"{FALL_DURATION:g} s each at 100 Hz: velocities up to 0.5 m/s in any direction and 0.5 rad/s, changed "
    f"every 4 s; gaits ({', '.join(GAITS)}) changed every 12 s; {FALL_PUSH:g} N for 0.2 s in random "
    "directions every 5 s. The rms is against the reference velocity, in which accelerations are limited; "
    "the sway of steps is part of it."
)
GOALS = "Distance of the CoM from the goal, and of the yaw, at the end in MuJoCo."

PARTS: dict[str, Callable[[int, list[str]], list[str]]] = {
    "time": step_times,
    "cost": real_time_cost,
    "physics": random_runs,
    "motions": four_motions,
    "memory": memory,
}

if __name__ == "__main__":
    sys.exit(main())
