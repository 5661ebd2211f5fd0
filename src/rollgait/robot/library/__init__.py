"""The robots that come with the package: one YAML file each."""

from __future__ import annotations

from functools import lru_cache
from importlib import resources
from pathlib import Path

from rollgait.config import load_yaml, parse_yaml, validate
from rollgait.errors import UnknownNameError
from rollgait.robot.robot import Robot


def robot_names() -> list[str]:
    """Names of the robots in the library, sorted."""
    return sorted(
        f.name.removesuffix(".yaml")
        for f in resources.files(__package__).iterdir()
        if f.name.endswith(".yaml")
    )


def find_robot(name: str) -> Robot:
    """The robot of this name in the library, or in the YAML file at this path.

    Raises:
        UnknownNameError: there is neither; lists the library.
        InputError: the file breaks a rule.
    """
    if name.endswith((".yaml", ".yml")):
        return validate(Robot, load_yaml(Path(name)), "robot")
    return _of_the_library(name)


@lru_cache
def _of_the_library(name: str) -> Robot:
    """What comes with the package does not change, nor does what was read of it."""
    if name not in robot_names():
        raise UnknownNameError(
            "robot", name, robot_names(), "is neither a robot of the library nor a .yaml file"
        )
    text = resources.files(__package__).joinpath(f"{name}.yaml").read_text(encoding="utf-8")
    return validate(Robot, parse_yaml(text, f"{name}.yaml"), "robot")
