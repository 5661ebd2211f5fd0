"""`rollgait ground show`: a ground with what a robot can do on it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from rollgait.cli.arguments import AsJson
from rollgait.cli.ground_input import ground_from
from rollgait.cli.output import number, print_json, print_table
from rollgait.cli.usage import Commands
from rollgait.errors import InputError
from rollgait.files import check_writable

if TYPE_CHECKING:
    from rollgait.robot import Robot
    from rollgait.terrain import Ground
    from rollgait.terrain.facts import GroundFacts

ROBOT: Final = "centauro"
"""Whose wheels are meant where neither the file nor the command says it."""

STYLE: Final = "screen"

app = typer.Typer(cls=Commands, rich_markup_mode=None, help="Look at grounds.")


@app.callback()
def ground() -> None:
    """Look at grounds."""


@app.command("show")
def show(
    file: Annotated[
        str,
        typer.Argument(
            metavar="FILE",
            help="A scenario (name or .yaml), a .yaml with the keys of ground, or the file of a map.",
        ),
    ],
    robot: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Whose wheels. Default: the robot of the scenario, or centauro."),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="KEY=VALUE", help="Set a key of the ground: map.resolution=0.04; repeatable."
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the map: .png, .pdf or .svg.")
    ] = None,
    style: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of the picture: screen (if not given) or paper.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Say where a robot can roll and stand on a ground; draw it.

    Also how large, high and steep it is. For example: rollgait ground show hills.npy --set
    map.resolution=0.04 --out hills.png
    """
    from rollgait.robot import find_robot
    from rollgait.terrain import regions_of
    from rollgait.terrain.facts import extent_of, facts_of

    if out is None and style is not None:
        raise InputError("--style", style, "is of the picture that --out draws, and there is no --out")
    if out is not None:
        from rollgait.view.figures import require_image_format
        from rollgait.view.style import find_style

        find_style(style or STYLE)
        require_image_format(out)
        check_writable(out)
    asked, named = ground_from(file, settings or [])
    body = named if robot is None and named is not None else find_robot(robot or ROBOT)
    radius = max(leg.wheel_radius or 0.0 for leg in body.leg_list)
    terrain = asked.terrain()
    low, high = extent_of(terrain)
    regions = regions_of(terrain, radius)
    facts = facts_of(regions, low, high)
    if out is not None:
        from rollgait.view.ground_map import save_ground

        save_ground(regions, (facts.low, facts.high), out, style or STYLE)
    if as_json:
        written = None if out is None else str(out)
        print_json({"file": file, "robot": body.name, "picture": written, **facts.to_dict()})
        return
    print_table(_rows(body, asked, facts))
    print(out if out is not None else "--out ground.png draws it")


def _rows(robot: Robot, asked: Ground, facts: GroundFacts) -> list[tuple[str, str]]:
    """What a person wants to know."""
    (x0, y0), (x1, y1) = facts.low, facts.high
    wheel = f"wheels of {number(facts.radius)} m" if facts.radius else "point feet"
    return [
        ("robot", f"{robot.name}, {wheel}"),
        ("kind", asked.kind),
        (
            "shown",
            f"x {x0:.4g} to {x1:.4g} m, y {y0:.4g} to {y1:.4g} m: {x1 - x0:.4g} × {y1 - y0:.4g} m",
        ),
        ("heights", f"{number(facts.height_min)} to {number(facts.height_max)} m"),
        ("slopes", f"median {number(facts.slope_median)}°, at most {number(facts.slope_max)}°; risers apart"),
        ("friction", f"{asked.friction:g}, where no part says another one"),
        ("known", f"{100.0 * facts.known:.3g} %"),
        ("can be stood on", f"{100.0 * facts.standable:.3g} % of what is known"),
        ("regions", f"{facts.regions} that cannot be rolled between"),
    ]
