"""A scenario before it is planned: the robot stands at the start, on its ground, its goals in sight."""

from __future__ import annotations

from typing import Any

import numpy as np

from rollgait.errors import RollgaitError
from rollgait.footing.on_terrain import standing_start
from rollgait.plan.samples import Array, Samples, level_contact
from rollgait.scenario.scenario import Scenario
from rollgait.view.clip import Clip, ShownGoal
from rollgait.view.motion import goal_poses
from rollgait.view.rotations import turn_z

KIND = "scenario"


def clip_of_scenario(scenario: Scenario, name: str) -> Clip:
    """A scenario of which nothing is planned yet.

    Where the robot cannot stand at its start it is shown level there, for the eye to see why.
    """
    times = np.array([0.0, scenario.horizon])
    base, feet = _start(scenario)
    robot, count = scenario.body, len(times)
    force = np.zeros((4, 3))
    force[:, 2] = robot.static_forces()

    def still(values: Any) -> np.ndarray[Any, Any]:
        """The same at all times."""
        return np.repeat(np.asarray(values)[None], count, axis=0)

    samples = Samples(
        time=times,
        com_position=still(base[:3]),
        euler=still(base[3:]),
        com_velocity=np.zeros((count, 3)),
        euler_rate=np.zeros((count, 3)),
        foot_position=still(feet),
        foot_velocity=np.zeros((count, 4, 3)),
        heading=still(base[3] + scenario.start_headings()),
        heading_rate=np.zeros((count, 4)),
        speed=np.zeros((count, 4)),
        force=still(force),
        contact=np.ones((count, 4), dtype=bool),
        **level_contact(still(feet)),
    )
    begins = [0.0, *(later.at for later in scenario.goal.then)]
    try:
        poses = goal_poses(scenario, np.array(begins))
    except RollgaitError:  # a goal in a riser, say: it is told where it is planned
        poses = scenario.goal_at(np.array(begins))
    return Clip(
        name=name,
        kind=KIND,
        robot=robot,
        samples=samples,
        terrain=scenario.terrain,
        goals=tuple(ShownGoal(begin, pose) for begin, pose in zip(begins, poses, strict=True)),
        marks=(),
        verdict="nothing is planned yet",
        passed=True,
        scenario=scenario,
        wrenches=scenario.loads.wrench,
    )


def places_of(scenario: Scenario) -> Array:
    """Where a scenario begins and where it is wanted, (n, 2), m."""
    start, goal = scenario.start, scenario.goal
    return np.array([(start.x, start.y), (goal.x, goal.y), *((later.x, later.y) for later in goal.then)])


def _start(scenario: Scenario) -> tuple[Array, Array]:
    """Base (6,) and feet (4, 3) at the start, m and rad."""
    try:
        base, feet = standing_start(scenario)
        if np.isfinite(base).all() and np.isfinite(feet).all():
            return base, feet
    except RollgaitError:
        pass
    start, robot = scenario.start, scenario.body
    yaw = np.radians(start.yaw_deg)
    place = np.array([start.x, start.y, scenario.height])
    return np.array([*place, yaw, 0.0, 0.0]), place + robot.stance @ turn_z(yaw).T
