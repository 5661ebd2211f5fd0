"""A scenario before it is planned: the robot stands at the start, on its ground, its goals in sight."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from rollgait.config import parse_yaml
from rollgait.errors import InputError
from rollgait.footing.on_terrain import standing_start
from rollgait.plan.samples import Samples, level_contact
from rollgait.scenario.scenario import Scenario
from rollgait.view.clip import Clip, ShownGoal, frame_times
from rollgait.view.motion import goal_poses

KIND = "scenario"


def clip_of_scenario(scenario: Scenario, name: str) -> Clip:
    """A scenario of which nothing is planned yet. Raises `InputError` where the robot cannot stand."""
    times = frame_times(scenario.horizon)
    base, feet = standing_start(scenario)
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
    poses = goal_poses(scenario, np.array(begins))
    return Clip(
        name=name,
        kind=KIND,
        robot=robot,
        samples=samples,
        terrain=scenario.terrain,
        goals=tuple(ShownGoal(begin, pose) for begin, pose in zip(begins, poses, strict=True)),
        marks=(),
        verdict="nothing is planned yet: tab Plan",
        passed=True,
        scenario=scenario,
        wrenches=scenario.wrenches,
    )


def scenario_from_page(content: bytes, name: str) -> Scenario:
    """The scenario in a file that a page sent: it names no other file. Raises `InputError`."""
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError:
        raise InputError("file", name, "is not text") from None
    data = parse_yaml(text, name)
    robot = data.get("robot")
    if isinstance(robot, str) and Path(robot).suffix:
        raise InputError("robot", robot, "names a file; a scenario sent by a page names a robot or holds it")
    return Scenario.from_dict(data)
