"""What is a load in the problem worth? 20 kg off the centre and a pull of 100 N, executed in MuJoCo.

    python benchmarks/loads.py [--quick]

Each motion of CENTAURO is planned twice, with the loads and without. Both plans are executed by the whole
body under the loads: tracked, with feedback of the base pose (`simulate`), and by the controller, which knows
the loads or does not (`execute`). Prints Markdown and keeps it in docs/benchmarks.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

import rollgait as rg
from reporting import keep, load, machine, table
from rollgait.mpc.execution import ExecutionReport, execute
from rollgait.mpc.plans.path import PlanPath
from rollgait.mpc.setup import make_loop
from rollgait.robot.whole_body import find_whole_body
from rollgait.simulation import SimulationReport
from rollgait.simulation.plant import MujocoPlant

LOADS = {
    "payload": {"mass": 20.0, "at": [0.1, 0.15, 0.3]},
    "wrench": {"force": [-100.0, 0.0, 0.0], "at": [-0.3, 0.0, 0.0]},
}
CRAWL = rg.Scenario(robot="centauro", goal=rg.Goal(x=0.8), horizon=8.0, gait=rg.Crawl())
MOTIONS = {
    "wheeled": rg.find_scenario("wheeled"),
    "hybrid-forward": rg.find_scenario("hybrid-forward"),
    "crawl": CRAWL,
    "legged-forward": rg.find_scenario("legged-forward"),
}
MILLI = 1e3

COLUMNS = (
    "motion",
    "executed by",
    "loads in the problem",
    "certified",
    "final, mm",
    "final, deg",
    "tilt off, deg",
    "CoM off, rms mm",
    "forces off, rms N",
    "late, s",
)


def cells(report: SimulationReport | ExecutionReport) -> tuple[str, ...]:
    """What both kinds of reports say; nothing is late where nobody may wait."""
    stays = not report.fallen if isinstance(report, SimulationReport) else report.passed
    if not stays:
        return ("falls or gives up", *[""] * 5)
    return (
        f"{MILLI * report.final_distance:.2f}",
        f"{np.degrees(report.final_angle):.2f}",
        f"{np.degrees(report.tilt_error):.2f}",
        f"{MILLI * report.com_rms:.1f}",
        f"{np.sqrt(np.mean(np.square(report.force_rms))):.0f}",
        f"{report.shift:.1f}" if isinstance(report, ExecutionReport) else "",
    )


def tracked(plan: rg.Plan, world: rg.Plan) -> tuple[str, ...]:
    """A plan executed by the tracked joints, under the loads of another one."""
    joints = replace(rg.track(plan), robot=world.robot, wrenches=world.scenario.wrenches)
    return cells(rg.simulate(joints, feedback=True).report())


def controlled(plan: rg.Plan, world: rg.Plan) -> tuple[str, ...]:
    """A plan executed by a controller that knows of the loads what the plan knows, under those of another."""
    start = PlanPath(plan).state(0.0)
    start = replace(start, com_position=start.com_position + world.robot.com_offset - plan.robot.com_offset)
    body = find_whole_body(world.robot)
    plant = MujocoPlant(body, world.robot, start, wrenches=world.scenario.wrenches)
    found = execute([plan], make_loop(plan.robot, plant, loads=rg.Loads(wrench=plan.scenario.wrenches)))
    return cells(found.report)


def rows(motions: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """The table, row by row."""
    for motion in motions:
        loaded = rg.plan(MOTIONS[motion].with_values({"loads": LOADS}))
        for name, plan in (("yes", loaded), ("no", rg.plan(MOTIONS[motion]))):
            certified = "yes" if plan.certificate().passed else "no"
            yield (motion, "simulate", name, certified, *tracked(plan, loaded))
            yield (motion, "execute", name, certified, *controlled(plan, loaded))


def main() -> None:
    """Executes all motions and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one motion")
    arguments = parser.parse_args()
    motions = ["hybrid-forward"] if arguments.quick else list(MOTIONS)
    before, found = load(), list(rows(motions))
    text = (
        f"## Loads\n\n{machine()}; load {before} before, {load()} after.\n"
        "20 kg at (0.1, 0.15, 0.3) m from the CoM and a pull of 100 N backwards, part of the world in all "
        "rows. `simulate` has feedback of the base pose; the controller of `execute` knows what its plan "
        "knows. The CoM counts where the plan has it: one that does not know of the payload has it 51 mm "
        "elsewhere in the base. `late`: by how much longer than planned the controller took.\n\n"
        f"{table(COLUMNS, found)}"
    )
    print(text)
    if not arguments.quick:
        keep("loads", text)


if __name__ == "__main__":
    main()
