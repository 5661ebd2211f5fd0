"""The motions that come with the package: one YAML file each."""

from __future__ import annotations

from functools import lru_cache
from importlib import resources
from pathlib import Path

from rollgait.config import parse_yaml
from rollgait.errors import UnknownNameError
from rollgait.scenario.scenario import Scenario


def scenario_names() -> list[str]:
    """Names of the scenarios in the library, sorted."""
    return sorted(
        f.name.removesuffix(".yaml")
        for f in resources.files(__package__).iterdir()
        if f.name.endswith(".yaml")
    )


def find_scenario(name: str) -> Scenario:
    """The scenario of this name in the library, or in the YAML file at this path.

    Raises:
        UnknownNameError: there is neither; lists the library.
        InputError: the file breaks a rule.
    """
    if name.endswith((".yaml", ".yml")):
        return Scenario.from_yaml(name)
    return _of_the_library(name)


@lru_cache
def _of_the_library(name: str) -> Scenario:
    """What comes with the package does not change, nor does what was read of it."""
    if name not in scenario_names():
        rule = "is neither a scenario of the library nor a .yaml file"
        raise UnknownNameError("scenario", name, scenario_names(), rule)
    folder = resources.files(__package__)
    text = folder.joinpath(f"{name}.yaml").read_text(encoding="utf-8")
    scenario = Scenario.from_dict(parse_yaml(text, f"{name}.yaml"), Path(str(folder)))
    # a user's own maps are not looked for in the package
    return scenario.model_copy(update={"ground": scenario.ground.self_contained()})
