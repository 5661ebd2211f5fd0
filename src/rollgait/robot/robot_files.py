"""The files that an imported robot is kept in."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

ROBOT: Final = "-robot"
"""Ends the stem of a robot's file where no name is given: a .yaml named as the URDF describes its legs."""


@dataclass(frozen=True)
class RobotFiles:
    """The files of an imported robot.

    Attributes:
        robot: the robot for the planner.
        legs: the description of the legs, if the import has found them.
        first: a first scenario.
    """

    robot: Path
    legs: Path
    first: Path


def robot_files(robot: str | Path) -> RobotFiles:
    """The files that belong to a robot's file."""
    file = Path(robot)
    base = file.stem.removesuffix(ROBOT)
    return RobotFiles(file, file.with_name(f"{base}-legs.yaml"), file.with_name(f"{base}-first.yaml"))
