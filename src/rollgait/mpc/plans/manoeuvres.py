"""Motions to be planned from wherever the robot stands: manoeuvres that a person asks for while driving."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.angles import near, turned
from rollgait.errors import InputError
from rollgait.plant.state import RobotState
from rollgait.robot.library import find_robot
from rollgait.robot.robot import LEG_NAMES, Robot
from rollgait.scenario.scenario import Scenario

if TYPE_CHECKING:
    from rollgait.terrain.terrain import Terrain

Array = NDArray[np.float64]

OFF_MAX: Final = 0.04
"""Farthest of a foot from its nominal place, m: a stand makes good a little more where the plan begins."""
AHEAD: Final = (0.3, 4.0)
"""How far ahead somebody may want to be, m."""


@dataclass(frozen=True)
class Manoeuvre:
    """A motion by name. The start of its scenario says from where its goal counts; the ground is another."""

    name: str
    scenario: Scenario


def manoeuvres_of(robot: Robot) -> tuple[Manoeuvre, ...]:
    """Scenarios of the library for this robot, on level ground."""
    from rollgait.scenario.library import find_scenario, scenario_names

    known = ((name, find_scenario(name)) for name in scenario_names())
    return tuple(
        Manoeuvre(name, scenario)
        for name, scenario in known
        if scenario.robot == robot.name and scenario.ground.kind == "flat"
    )


def check_manoeuvre(manoeuvre: Manoeuvre, robot: Robot) -> None:
    """Raises `InputError` if a motion is of another robot, or begins in motion."""
    scenario = manoeuvre.scenario
    own = scenario.robot if isinstance(scenario.robot, Robot) else find_robot(scenario.robot)
    same = all(
        a.foot == b.foot and np.allclose(a.stance, b.stance, atol=1e-6)
        for a, b in zip(own.leg_list, robot.leg_list, strict=True)
    )
    if not same:
        raise InputError(f"manoeuvre {manoeuvre.name}", own.name, f"must be of the robot {robot.name}")
    if scenario.start.motion is not None:
        raise InputError(f"manoeuvre {manoeuvre.name}", "start.motion", "must begin at rest")


def ahead(robot: Robot, distance: float) -> Manoeuvre:
    """Over or around whatever is ahead, by wheels or steps, whichever are found; `distance` in m.

    Raises `InputError` for a distance beyond `AHEAD`.
    """
    low, high = AHEAD
    if not low <= distance <= high:
        raise InputError("ahead", distance, f"must lie in [{low:g}, {high:g}] m")
    values: dict[str, Any] = {"robot": robot, "goal": {"x": distance}, "gait": {"kind": "discover"}}
    return Manoeuvre(f"{distance:.3g} m ahead", Scenario.model_validate(values))


def placed(manoeuvre: Manoeuvre, robot: Robot, state: RobotState, terrain: Terrain | None) -> Scenario:
    """The scenario of a manoeuvre from where a robot stands.

    Args:
        manoeuvre: what is wanted.
        robot: that stands there.
        state: of it, at rest.
        terrain: the ground; level if None.

    Raises:
        InputError: the feet are too far from their nominal places, or the scenario cannot be there.
    """
    scenario = manoeuvre.scenario
    yaw = float(state.euler[0])
    stance = turned(robot.stance, yaw)[:, :2]
    x, y = (state.foot_position[:, :2] - stance).mean(axis=0).tolist()
    off = np.hypot(*(state.foot_position[:, :2] - stance - (x, y)).T)
    if off.max() > OFF_MAX:
        leg = int(off.argmax())
        rule = (
            f"must stand within {1e3 * OFF_MAX:.0f} mm of its nominal place under the body, "
            "which driving a little on level ground brings about"
        )
        raise InputError(f"foot {LEG_NAMES[leg]}", f"{1e3 * off[leg]:.0f} mm off", rule)
    steers = [leg.foot == "steerable" for leg in robot.leg_list]
    heading = np.where(steers, near(state.heading - yaw, 0.0), 0.0)
    start = scenario.start
    values: dict[str, Any] = {
        "robot": robot,
        "start": {
            "x": x,
            "y": y,
            "yaw_deg": math.degrees(yaw),
            "heading_deg": dict(zip(LEG_NAMES, np.degrees(heading).tolist(), strict=True)),
        },
        "ground": {"kind": "flat"} if terrain is None else terrain,
    }
    turn = yaw - math.radians(start.yaw_deg)

    def moved(goal: Any) -> dict[str, float]:
        here = turned(np.array([goal.x - start.x, goal.y - start.y]), turn)
        return {"x": x + here[0], "y": y + here[1], "yaw_deg": goal.yaw_deg + math.degrees(turn)}

    goal = scenario.goal
    values["goal"] = {**moved(goal), "then": [{"at": one.at, **moved(one)} for one in goal.then]}
    return scenario.with_values(values)
