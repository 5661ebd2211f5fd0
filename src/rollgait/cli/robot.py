"""`rollgait robot import`: a robot for the planner from a URDF."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from rollgait.cli.arguments import AsJson
from rollgait.cli.output import print_json, print_table
from rollgait.cli.usage import Commands
from rollgait.errors import FileError, InputError
from rollgait.files import check_writable, replacing

if TYPE_CHECKING:
    from rollgait.robot.robot import Robot

YAML: Final = (".yaml", ".yml")
"""How the file of a robot may end."""
SLOW: Final = 0.3
"""Of the command that is proposed: lengths of the robot, from hip to hip, in a second."""
SLOW_TURN: Final = 0.2
"""Its turn rate, rad/s."""

app = typer.Typer(cls=Commands, rich_markup_mode=None, help="Show robots; make them from models.")


@app.callback()
def robot() -> None:
    """Show robots; make them from models."""


@app.command("import")
def import_(
    model: Annotated[
        str,
        typer.Argument(
            metavar="MODEL",
            help="A .urdf, MJCF or xacro file (also example-robot-data:PATH in that package), the .yaml that "
            "describes one, or the name of a robot: in the library, or in the package robot_descriptions "
            "if it is installed.",
        ),
    ],
    legs: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Names the legs' frames and joints. Default: MODEL with .yaml; none: they are found.",
        ),
    ] = None,
    srdf: Annotated[Path | None, typer.Option(metavar="FILE", help="SRDF with the --posture.")] = None,
    posture: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Group state of the SRDF from which the stance is derived."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Where to write the robot (.yaml).")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Derive a robot for the planner from a URDF.

    Says what was found, and what had to be chosen. Mass, inertia, nominal stance, foot kinds, limits,
    reach and workspace come from the URDF and inverse kinematics. Legs are found by chains, symmetry and
    axes where no file names them.
    """
    from rollgait.robot.importing import import_robot
    from rollgait.robot.model_files import model_file
    from rollgait.robot.robot_files import ROBOT, robot_files
    from rollgait.robot.whole_body import whole_body_names

    if out is not None and out.suffix not in YAML:
        raise FileError(
            "out", str(out), f"must end in {' or '.join(YAML)}, by which all commands know a robot"
        )
    earlier = None
    place = Path(model) if model in whole_body_names() else model_file(model)
    if legs is None and _is_bare(place):
        from rollgait.robot.urdf_discovery import robot_name

        out = out or Path(f"{robot_name(place)}{ROBOT}.yaml")
        earlier = robot_files(out).legs  # perhaps corrected since
        legs = earlier if earlier.is_file() else None
    if out is not None:
        check_writable(out)
    try:
        found = import_robot(place, legs=legs, srdf=srdf, posture=posture)
    except InputError as error:
        if earlier is None or earlier.is_file() or not error.field.startswith("legs."):
            raise
        _write_outline(place, earlier)
        rule = f"{error.rule}; {earlier} names the legs that were found: give it there, and import again"
        raise InputError(error.field, error.value, rule) from None
    written = None if out is None else found.save(out)
    if as_json:
        data = found.robot.model_dump(mode="json", exclude_none=True)
        facts = [
            {"name": f.name, "value": f.value, "source": f.source, "known": f.known} for f in found.findings
        ]
        print_json({"file": None if out is None else str(out), "robot": data, "findings": facts})
        return
    for title, known in (("found", True), ("not in the URDF: chosen or default", False)):
        print(title)
        print_table([(f.name, f.value, f.source) for f in found.findings if f.known == known])
        print()
    if written is None:
        print("--out robot.yaml writes it")
        return
    print(f"written: {written.robot}, {written.first}")
    if earlier is not None:
        print(f"legs:    {earlier}: correct there what is wrong, and import again")
    print(f"next:    rollgait run {written.first}")
    print(f"or:      rollgait mpc {written.robot} --plant mujoco --command {_slow_command(found.robot)}")


def _slow_command(robot: Robot) -> str:
    """A command for the controller that the robot's feet can follow: ahead, and turning if they turn."""
    from rollgait.mpc.footwork import ANYWHERE, Footwork
    from rollgait.mpc.gaits import find_gait

    feet = Footwork(robot)
    gait = find_gait(feet.fitting(ANYWHERE))
    _, _, turns = feet.able(gait)
    length = float(max(robot.stance[:, 0]) - min(robot.stance[:, 0]))
    wanted = (SLOW * length, 0.0, SLOW_TURN * turns)
    forward, _, turn = feet.within(gait, wanted)
    return f"forward={forward:.2g}" + (f",turn_rate={turn:.2g}" if turns else "")


def _write_outline(model: Path, file: Path) -> None:
    from rollgait.robot.urdf_discovery import outline

    with replacing(file) as temporary:
        temporary.write_text(outline(model), encoding="utf-8")


def _is_bare(model: Path) -> bool:
    """Whether nothing stands beside a URDF that names its legs."""
    return model.suffix not in YAML and model.is_file() and not model.with_suffix(".yaml").is_file()
