"""What can the planner do on ground that is not flat, and does the robot survive it? Prints Markdown.

    python benchmarks/terrain.py [--parts given robots raster sensed physics] [--worlds up-0.25 …] [--quick]

`given`: the gait takes the necessary steps in their order, and only the motion is planned. `robots`: other
robots, the worlds scaled by their heights. `raster`: the same worlds as maps of 1 cm. `sensed`: the same as
maps with the faults of sensors, planned on these and executed on the true ground. `physics`: planned
with 0.8 of the friction, executed in MuJoCo open loop and with feedback. Seconds are CPU seconds. What is
printed is deterministic but for them. A part with all its worlds is kept in docs/benchmarks.md.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import rollgait as rg
from reporting import keep, load, machine, table
from rollgait.discover.serial import stepping_gait
from rollgait.errors import RollgaitError
from rollgait.robot.robot import Robot
from rollgait.robot.urdf import import_robot
from rollgait.robot.whole_body import load_whole_body
from rollgait.simulation import SimulationLog
from rollgait.solvers import Iteration
from rollgait.terrain import WheelSurface

Array = NDArray[np.float64]

LONG = 60.0
"""s: a horizon that is valid for every world; the gait brings its own."""
RATE = 200.0
"""Samples per second at which feet are compared with the ground, Hz."""
FRICTION = 0.5
CAUTION = 0.8
"""Share of the friction with which motions are planned that are executed."""
CELL, NOISE, MISSING, FILL = 0.04, 0.01, 0.05, 0.2
"""Of a sensed map: cell, m; standard deviation, m; share of unknown values; holes that are filled, m."""
HIDDEN = 0.0
"""So far around the rectangle of its feet the robot hides the ground, m."""
BEYOND = 1.6
"""So far beyond start and goal maps reach, m."""
MILLI = 1e3
FIXTURES = Path(__file__).resolve().parents[1] / "tests" / "fixtures"
PLATEAU = float(np.tan(np.radians(15.0)))


@dataclass(frozen=True)
class World:
    """Parts of the ground, and how far the robot goes, m; or the name of a scenario."""

    parts: Sequence[dict[str, object]] = ()
    goal: float = 0.0
    scenario: str = ""


def _up(height: float) -> World:
    return World([{"kind": "step", "x": 0.9, "height": height}], 2.2)


def _ramp(degrees: float) -> World:
    return World([{"kind": "ramp", "x": 0.8, "length": 4.0, "slope_deg": degrees}], 2.6)


def _gap(length: float) -> World:
    return World([{"kind": "gap", "x": 0.9, "length": length}], 2.4)


WORLDS = {
    "up-0.10": _up(0.10),
    "up-0.15": _up(0.15),
    "up-0.20": _up(0.20),
    "up-0.25": _up(0.25),
    "down-0.20": _up(-0.20),
    "gap-0.2": _gap(0.2),
    "gap-0.3": _gap(0.3),
    "gap-0.4": _gap(0.4),
    "block": World([{"kind": "block", "x": 1.0, "length": 0.3, "width": 3.0, "height": 0.15}], 2.6),
    "stairs": World([{"kind": "stairs", "x": 0.9, "steps": 3, "rise": 0.12, "tread": 0.4}], 3.0),
    "ramp-10": _ramp(10.0),
    "ramp-15": _ramp(15.0),
    "ramp-20": _ramp(20.0),
    "ramps": World(
        [
            {"kind": "ramp", "x": 0.8, "length": 1.0, "slope_deg": 15.0},
            {"kind": "step", "x": 1.8, "length": 1.2, "height": PLATEAU},
            {"kind": "ramp", "x": 3.0, "length": 1.0, "rise": -PLATEAU, "z": PLATEAU},
        ],
        4.8,
    ),
    "bumps": World(scenario="rough"),
    "one-sided": World(scenario="one-sided"),
}
ROBOTS = ("centauro-2020", "hyq", "roller")
SCALED = ("up-0.15", "down-0.20", "gap-0.3", "stairs", "ramp-15")
RASTERED = ("up-0.15", "ramp-15", "gap-0.3")
RASTER = 0.01
"""m."""
SENSED = ("up-0.15", "ramp-15", "gap-0.3", "bumps", "one-sided")
EXECUTED = ("up-0.25", "down-0.20", "gap-0.4", "stairs", "ramp-15", "bumps", "one-sided")
PARTS = ("given", "robots", "raster", "sensed", "physics")


class CpuPlanner(rg.Planner):
    """Says CPU seconds, of which other programs take none."""

    clock = time.process_time


@dataclass
class Count:
    """Iterations by what they were for; the solver numbers them anew in each run."""

    iterations: dict[str, int] = field(default_factory=dict)
    _last: int = 0

    def __call__(self, iteration: Iteration) -> None:
        """Counts one."""
        begun = iteration.number <= self._last
        more = iteration.number if begun else iteration.number - self._last
        self.iterations[iteration.task] = self.iterations.get(iteration.task, 0) + more
        self._last = iteration.number

    def words(self) -> str:
        """E.g. 24 + 21 mending."""
        rest = (f" + {n} {task}" for task, n in self.iterations.items() if task != "solving")
        return str(self.iterations.get("solving", 0)) + "".join(rest)


# -- what is asked --


def asked(name: str, friction: float = FRICTION, robot: str | Robot = "centauro") -> rg.Scenario:
    """A world with its gait."""
    world = WORLDS[name]
    if world.scenario:
        return rg.find_scenario(world.scenario).with_values({"ground.friction": friction})
    data = {"robot": robot, "goal": {"x": world.goal}, "horizon": LONG, "gait": {"kind": "drive"}}
    ground = {"parts": list(world.parts), "friction": friction}
    return stepping_gait(rg.Scenario.from_dict({**data, "ground": ground}))


def model(name: str) -> Robot:
    """A robot of the library, or of the tests."""
    if (FIXTURES / f"{name}.yaml").is_file():
        file = FIXTURES / f"{name}.yaml"
        return import_robot(load_whole_body(file), str(file)).robot
    return rg.find_robot(name)


def scaled(name: str, robot: Robot) -> rg.Scenario:
    """A world whose lengths are to this robot's height as the world's to CENTAURO's height.

    The first edge is as far, so scaled, from the front feet, and the goal as far behind the last one from the
    hind feet. Point feet, which cannot roll, crawl.
    """
    world, original = WORLDS[name], rg.find_robot("centauro")
    share = robot.height / original.height
    front, front_original = float(robot.stance[:, 0].max()), float(original.stance[:, 0].max())
    hind, hind_original = float(robot.stance[:, 0].min()), float(original.stance[:, 0].min())
    parts = []
    for part in world.parts:
        lengths = ("length", "width", "height", "rise", "tread", "z")
        own = {key: share * part[key] if key in lengths else part[key] for key in part}  # type: ignore[operator]
        parts.append(own | {"x": front + share * (part["x"] - front_original)})  # type: ignore[operator]
    goal = share * (world.goal - front_original + hind_original) + front - hind
    points = any(leg.foot == "point" for leg in robot.leg_list)
    gait: dict[str, object] = {"kind": "drive"}
    if points:
        steps = 4 * int(np.ceil(goal / (0.5 * robot.box[0])))
        gait = {"kind": "crawl", "steps": steps}
    horizon = 1.0 * float(gait["steps"]) + 2.0 if points else LONG  # type: ignore[arg-type]
    data = {"robot": robot.model_dump(mode="json"), "goal": {"x": goal}, "horizon": horizon, "gait": gait}
    scenario = rg.Scenario.from_dict({**data, "ground": {"parts": parts, "friction": FRICTION}})
    return scenario if points else stepping_gait(scenario)


def corners(scenario: rg.Scenario) -> tuple[Array, Array]:
    """Lower left and upper right corner of what a map of the scenario's ground holds, m."""
    low = np.array([min(scenario.start.x, scenario.goal.x), min(scenario.start.y, scenario.goal.y)])
    high = np.array([max(scenario.start.x, scenario.goal.x), max(scenario.start.y, scenario.goal.y)])
    return low - BEYOND, high + BEYOND


def sensed(scenario: rg.Scenario, seed: int) -> rg.Scenario:
    """The scenario on a map as a sensor gives it of its ground."""
    rng = np.random.default_rng(seed)
    low, high = corners(scenario)
    low = low + rng.uniform(-0.5, 0.5, 2) * CELL  # nodes do not lie on edges
    if scenario.terrain.map is not None:  # which may end earlier
        heights = scenario.terrain.map
        far = heights.origin + heights.resolution * (np.array(heights.values.shape) - 1)
        low, high = np.maximum(low, heights.origin), np.minimum(high, far)
    count = np.floor((high - low) / CELL).astype(int) + 1
    x, y = (corner + CELL * np.arange(n) for corner, n in zip(low, count, strict=True))
    given = scenario.terrain.height(x[:, None], y[None])
    given = given + NOISE * rng.standard_normal(given.shape)
    given[rng.random(given.shape) < MISSING] = np.nan
    half = np.abs(scenario.body.stance[:, :2]).max(axis=0) + HIDDEN
    under = (np.abs(x - scenario.start.x) < half[0])[:, None] & (np.abs(y - scenario.start.y) < half[1])
    given[under] = np.nan
    terrain = rg.Terrain.from_map(
        given, CELL, (float(low[0]), float(low[1])), friction=scenario.ground.friction, noise=NOISE, fill=FILL
    )
    return scenario.with_terrain(terrain)


# -- what came of it --


def deviation(plan: rg.Plan, scenario: rg.Scenario) -> float:
    """Largest distance of feet in stance from the surface of their wheels' lowest points, m."""
    samples = plan.sample_every(RATE)
    worst = 0.0
    for leg, data in enumerate(plan.robot.leg_list):
        places = samples.foot_position[samples.contact[:, leg], leg]
        surface = WheelSurface(scenario.terrain, data.foot_radius).height(*places[:, :2].T)
        worst = max(worst, float(np.abs(places[:, 2] - surface).max()))
    return worst


def failures(plan: rg.Plan) -> str:
    """Rows of the certificate that fail, with leg and time, or yes."""
    found = plan.certificate().failures
    return "; ".join(f"{r.name} {r.worst:.4g} {r.unit} {r.leg or ''} {r.time} s" for r in found) or "yes"


PLANNED = ("s", "iterations", "rounds", "solve s", "off the ground, mm", "certified")


def planned(scenario: rg.Scenario) -> tuple[rg.Plan | None, tuple[str, ...]]:
    """The plan of a scenario, and the cells of `PLANNED`."""
    count = Count()
    try:
        plan = CpuPlanner().plan(scenario, diagnose=False, progress=count)
    except RollgaitError as error:
        return None, (f"{scenario.horizon:g}", count.words(), "", "", "", f"no: {error}")
    statistics = plan.statistics
    return plan, (
        f"{scenario.horizon:g}",
        count.words() + (f", start {len(statistics.starts)}" if len(statistics.starts) > 1 else ""),
        str(statistics.ground_rounds),
        f"{statistics.solve_time:.2f}",
        f"{MILLI * deviation(plan, scenario):.2f}",
        failures(plan),
    )


def at_limit(log: SimulationLog) -> tuple[float, str]:
    """Longest time without a break for which a joint was at the limit of its torque, s, and which one."""
    step = float(np.median(np.diff(log.time)))
    held, longest = np.zeros(len(log.joint_names)), np.zeros(len(log.joint_names))
    for is_at_limit in log.torque_peak >= log.effort_max * (1.0 - 1e-9):
        held = np.where(is_at_limit, held + step, 0.0)
        longest = np.maximum(longest, held)
    worst = int(np.argmax(longest))
    return float(longest[worst]), log.joint_names[worst]


EXECUTION = (
    "open loop",
    "final, mm",
    "with feedback",
    "final, mm",
    "CoM off, mm",
    "at torque limit, ms",
    "unplanned contacts",
    "tracking",
)


def executed(plan: rg.Plan, terrain: rg.Terrain) -> tuple[str, ...]:
    """The cells of `EXECUTION`: on this ground, with its true friction."""
    try:
        joints = rg.track(plan)
    except RollgaitError as error:
        return (str(error), *[""] * (len(EXECUTION) - 1))
    world = rg.Disturbances(friction=FRICTION)
    logs = [rg.simulate(joints, world, feedback=feedback, terrain=terrain) for feedback in (False, True)]
    open_loop, closed = (log.report() for log in logs)
    held = max((at_limit(log) for log in logs), key=lambda item: item[0])
    touched = [f"{c.link} {c.time:.2f} s {c.force:.0f} N" for r in (open_loop, closed) for c in r.unplanned]
    rows = [
        f"{r.name} {r.worst:.3g} {r.unit} {r.where} {r.time:.2f} s"
        for r in joints.report.rows
        if not r.passed
    ]
    if joints.report.failed_steps:
        rows.append(f"{joints.report.failed_steps} steps failed")

    def fell(at: float | None) -> str:
        return "stands" if at is None else f"fell at {at:.2f} s"

    return (
        fell(open_loop.fallen_at),
        f"{MILLI * open_loop.final_distance:.1f}",
        fell(closed.fallen_at),
        f"{MILLI * closed.final_distance:.1f}",
        f"{MILLI * closed.com_worst:.0f}",
        f"{MILLI * held[0]:.0f}" + (f" {held[1]}" if held[0] > 0.0 else ""),
        "; ".join(touched) or "none",
        "; ".join(rows) or "passes",
    )


# -- the parts --

Rows = Iterator[tuple[str, ...]]


def given(worlds: Sequence[str]) -> Rows:
    """Motions of a given gait."""
    for name in worlds:
        yield name, *planned(asked(name))[1]


def robots(worlds: Sequence[str]) -> Rows:
    """Other robots."""
    for robot in ROBOTS:
        data = model(robot)
        for name in worlds:
            try:
                scenario = scaled(name, data)
            except RollgaitError as error:
                yield f"{robot}, {name}", *[""] * (len(PLANNED) - 1), f"no: {error}"
                continue
            yield f"{robot}, {name}", *planned(scenario)[1]


def raster(worlds: Sequence[str]) -> Rows:
    """The same world as planes and as a map: how far apart are the motions?

    Edges lie at full centimetres, so half way between the nodes of these maps.
    """
    for name in worlds:
        scenario = asked(name)
        exact, _ = planned(scenario)
        low, high = corners(scenario)
        measured = scenario.with_terrain(scenario.terrain.raster(RASTER, low + 0.5 * RASTER, high))
        plan, cells = planned(measured)
        if exact is None or plan is None:
            yield name, *cells, "", ""
            continue
        a, b = exact.sample_every(RATE), plan.sample_every(RATE)
        com = np.linalg.norm(a.com_position - b.com_position, axis=1).max()
        feet = np.linalg.norm(a.foot_position - b.foot_position, axis=2).max()
        yield name, *cells, f"{MILLI * com:.1f}", f"{MILLI * feet:.1f}"


def from_sensors(worlds: Sequence[str]) -> Rows:
    """Planned on what sensors give, executed on what is there."""
    for number, name in enumerate(SENSED):
        if name not in worlds:
            continue
        truth = asked(name, CAUTION * FRICTION)
        plan, cells = planned(sensed(truth, seed=number))
        yield name, *cells, *([""] * len(EXECUTION) if plan is None else executed(plan, truth.terrain))


def physics(worlds: Sequence[str]) -> Rows:
    """Executed in MuJoCo."""
    for name in worlds:
        scenario = asked(name, CAUTION * FRICTION)
        plan, cells = planned(scenario)
        rest = [""] * len(EXECUTION) if plan is None else executed(plan, scenario.terrain)
        yield name, cells[-1], *rest


def section(part: str, worlds: Sequence[str] | None) -> str:
    """Heading and table of a part; "" if it has none of the worlds."""
    shown = {
        "given": ("the gait given", given, tuple(WORLDS), ("world", *PLANNED)),
        "robots": (
            "other robots, worlds scaled by their heights",
            robots,
            SCALED,
            ("robot, world", *PLANNED),
        ),
        "raster": (
            "the same as maps of 1 cm",
            raster,
            RASTERED,
            ("world", *PLANNED, "CoM apart, mm", "feet apart, mm"),
        ),
        "sensed": (
            "maps as sensors give them, planned with 0.8 of the friction",
            from_sensors,
            SENSED,
            ("world", *PLANNED, *EXECUTION),
        ),
        "physics": (
            "in MuJoCo, planned with 0.8 of the friction",
            physics,
            EXECUTED,
            ("world", "certified", *EXECUTION),
        ),
    }
    title, rows, usual, columns = shown[part]
    these = usual if worlds is None else [name for name in usual if name in worlds]
    if not these:
        return ""
    before = load()
    found = table(columns, _told(rows(these)))
    words = "seconds are CPU seconds of all solving, mending included"
    loads = f"load {before} before, {load()} after"
    return f"## Terrain: {title}\n\n{machine()}; {loads}.\nμ {FRICTION:g}; {words}.\n\n{found}"


def _told(rows: Rows) -> Rows:
    """The rows, said as they come: the whole takes a while."""
    for row in rows:
        print(" | ".join(row), file=sys.stderr, flush=True)
        yield row


def main() -> None:
    """Plans and executes what is asked for and prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=list(PARTS), help="of the benchmark")
    parser.add_argument("--worlds", nargs="+", choices=list(WORLDS), help="only these (default: all)")
    parser.add_argument("--quick", action="store_true", help="one world, planned once, to see that it works")
    options = parser.parse_args()
    parts, worlds = (["given"], ["up-0.10"]) if options.quick else (options.parts, options.worlds)
    for part in parts:
        text = section(part, worlds)
        print(text)
        if worlds is None:
            keep(f"terrain-{part}", text)


if __name__ == "__main__":
    main()
