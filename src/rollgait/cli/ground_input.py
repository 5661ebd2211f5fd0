"""A ground as the command line names it: a scenario, a file of its keys, or a map."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rollgait.robot import Robot
    from rollgait.terrain import Ground, Terrain


def ground_from(name: str, settings: Sequence[str] = ()) -> tuple[Ground, Robot | None]:
    """The ground in a file or of a scenario of the library, and the robot that goes with it, if any."""
    from rollgait.config import load_yaml, parse_setting, set_key, validate
    from rollgait.robot import Robot, find_robot
    from rollgait.scenario import find_scenario
    from rollgait.terrain import Ground
    from rollgait.terrain.map_file import READERS

    path, body = Path(name), None
    data: dict[str, Any]
    if path.suffix.lower() in (".yaml", ".yml"):
        data = load_yaml(path)
        if not data.keys() <= Ground.model_fields.keys():  # else it has the keys of a ground alone
            robot, data = data.get("robot"), data.get("ground", {})
            body = find_robot(robot) if isinstance(robot, str) else validate(Robot, robot or {}, "robot")
    elif path.is_dir() or (path.suffix and path.suffix.lower() in READERS):
        data = {"map": {"file": path.name}}
    else:
        scenario = find_scenario(name)
        data, body = scenario.ground.model_dump(mode="json"), scenario.body
    for text in settings:
        set_key(data, *parse_setting(text))
    return validate(Ground, data, "ground").read(path.parent), body


def terrain_of(ground: Ground) -> Terrain | None:
    """The terrain that a ground means; None where it is the plane that is there without being asked for."""
    return None if ground.kind == "flat" and ground.height == 0.0 else ground.terrain()
