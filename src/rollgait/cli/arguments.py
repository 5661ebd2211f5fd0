"""Arguments and options that several commands share."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rollgait.errors import InputError

if TYPE_CHECKING:
    from rollgait.scenario import Scenario


def scenarios_beginning_with(incomplete: str) -> list[str]:
    """For the completion of a shell."""
    from rollgait.scenario.library import scenario_names

    return [name for name in scenario_names() if name.startswith(incomplete)]


def robots_beginning_with(incomplete: str) -> list[str]:
    """For the completion of a shell."""
    from rollgait.robot.library import robot_names

    return [name for name in robot_names() if name.startswith(incomplete)]


ScenarioName = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="Name of a scenario ('rollgait scenarios') or a YAML file.",
        autocompletion=scenarios_beginning_with,
    ),
]
RobotName = Annotated[
    str,
    typer.Argument(
        metavar="ROBOT",
        help="Name of a robot ('rollgait robots') or a YAML file.",
        autocompletion=robots_beginning_with,
    ),
]
PlanFile = Annotated[Path, typer.Argument(metavar="PLAN", help="A plan that 'rollgait plan' wrote (.npz).")]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Set a key of the scenario, e.g. goal.x=1.5; repeatable."
    ),
]
Profile = Annotated[
    str | None,
    typer.Option(
        metavar="NAME", help="Default weights and bounds: paper or executable. Short for --set profile."
    ),
]
Starts = Annotated[
    int,
    typer.Option(metavar="N", min=1, help="Solve from N initial guesses and keep the cheapest result."),
]
Seed = Annotated[
    int, typer.Option(metavar="N", min=0, help="Seed of the random ones among the initial guesses.")
]
GroundName = Annotated[
    str | None,
    typer.Option(
        metavar="FILE|NAME",
        help="The ground: a scenario (name or .yaml), a .yaml with the keys of ground, or the file of a map.",
    ),
]
Kernels = Annotated[
    bool, typer.Option("--kernels/--no-kernels", help="Use functions compiled to machine code.")
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace also what is no plan of this robot.")]
Full = Annotated[bool, typer.Option("--full", help="Show all rows of the certificate.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")]


def scenario_with(name: str, settings: list[str] | None, profile: str | None) -> Scenario:
    """The scenario of that name, or in that file, with the settings of the command line."""
    from rollgait.config import parse_setting
    from rollgait.scenario import find_scenario

    values = dict(parse_setting(text) for text in settings or ())
    if profile is not None:
        values["profile"] = profile
    scenario = find_scenario(name)
    return scenario.with_values(values) if values else scenario


def rate_from(text: str) -> float:
    """A rate in Hz. Raises `InputError`."""
    rule = "must be a positive number of samples per second (Hz)"
    try:
        rate = float(text)
    except ValueError:
        raise InputError("rate", text, rule) from None
    if not 0.0 < rate < math.inf:
        raise InputError("rate", text, rule)
    return rate
