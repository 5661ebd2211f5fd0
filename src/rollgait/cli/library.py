"""`rollgait scenarios`, `rollgait robots`, `rollgait show`: what comes with the package."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rollgait.cli.arguments import AsJson, Profile, ScenarioName, Settings, scenario_with
from rollgait.cli.output import number, print_json, print_table

if TYPE_CHECKING:
    from rollgait.robot import Robot
    from rollgait.scenario import Scenario

_HEADER = """\
# {name}: a complete scenario, the defaults of profile {profile} spelled out.
# Edit it and plan it: rollgait plan FILE.yaml
# A weight or bound that you delete takes the default of the profile: to get those of another profile, delete
# both groups and change `profile`.
"""


def scenarios(as_json: AsJson = False) -> None:
    """List the scenarios that come with the package."""
    from rollgait.scenario import find_scenario, scenario_names

    found = {name: find_scenario(name) for name in scenario_names()}
    if as_json:
        print_json([_scenario_facts(name, scenario) for name, scenario in found.items()])
        return
    rows = [("name", "horizon", "steps", "goal x, y, yaw", "description")]
    for name, s in found.items():
        is_free = s.gait.kind == "discover"
        steps = "found" if is_free else str(sum(1 for _ in s.schedule.swings()))
        time = "found" if is_free else f"{s.horizon:g} s"
        goal = f"{s.goal.x:g} m, {s.goal.y:g} m, {s.goal.yaw_deg:g} deg"
        rows.append((name, time, steps, goal, s.description))
    print_table(rows, right=[1, 2], indent=0)


def robots(as_json: AsJson = False) -> None:
    """List the robots that come with the package."""
    from rollgait.robot import find_robot, robot_names

    found = [find_robot(name) for name in robot_names()]
    if as_json:
        print_json([_robot_facts(robot) for robot in found])
        return
    rows = [("name", "mass", "height", "wheel radius", "feet", "description")]
    for r in found:
        radii = " / ".join(dict.fromkeys(number(leg.wheel_radius) for leg in r.leg_list))
        feet = " / ".join(dict.fromkeys(leg.foot for leg in r.leg_list))
        rows.append((r.name, f"{r.mass:.1f} kg", f"{r.height:.3f} m", f"{radii} m", feet, r.description))
    print_table(rows, right=[1, 2, 3], indent=0)


def show(scenario: ScenarioName, settings: Settings = None, profile: Profile = None) -> None:
    """Print a complete scenario as YAML.

    Every default is spelled out: the way to start one's own. For example: rollgait show hybrid-forward >
    my.yaml
    """
    complete = scenario_with(scenario, settings, profile).resolved()
    print(_HEADER.format(name=scenario, profile=complete.profile) + complete.to_yaml(), end="")


def _scenario_facts(name: str, scenario: Scenario) -> dict[str, object]:
    found = scenario.gait.kind == "discover"
    return {
        "name": name,
        "description": scenario.description,
        "robot": scenario.body.name,
        "horizon": scenario.horizon,
        "steps": None if found else sum(1 for _ in scenario.schedule.swings()),
        "goal": scenario.goal.model_dump(mode="json"),
    }


def _robot_facts(robot: Robot) -> dict[str, object]:
    from rollgait.robot import LEG_NAMES

    return {
        "name": robot.name,
        "description": robot.description,
        "mass": robot.mass,
        "height": robot.height,
        "legs": {
            name: {"foot": leg.foot, "wheel_radius": leg.wheel_radius}
            for name, leg in zip(LEG_NAMES, robot.leg_list, strict=True)
        },
    }
