"""`rollgait export`: a motion in a format that others read."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollgait.cli.arguments import rate_from
from rollgait.cli.motion_file import load_any_motion
from rollgait.cli.replacing import note_replacing
from rollgait.errors import InputError
from rollgait.files import check_writable


def export(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="A plan, a joint trajectory, or a log (.npz), as written here."),
    ],
    file_format: Annotated[
        str, typer.Option("--format", metavar="FORMAT", help="csv, json, mcap, rosbag2 or mujoco.")
    ] = "csv",
    rate: Annotated[str, typer.Option(metavar="HZ", help="Samples per second.")] = "100",
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Where to write. Default: <file>.<suffix>.")
    ] = None,
    meshes: Annotated[
        str | None,
        typer.Option(
            metavar="WHERE",
            help="Of bags: where the robot's meshes are to be found: beside (the default), package or file.",
        ),
    ] = None,
    controller: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=JOINTS",
            help="Of bags: a controller and its joints, e.g. legs=*_hip,*_knee; repeatable.",
        ),
    ] = None,
) -> None:
    """Write a plan, joints or a log for other programs.

    They are sampled at a fixed rate. Bags (mcap, rosbag2) hold the robot, too; a layout for Foxglove, a
    configuration of RViz and the robot's meshes are written beside them.
    """
    per_second = rate_from(rate)
    controllers = _controllers(controller) if controller else None
    motion = load_any_motion(file)
    from rollgait.export import FORMATS, write

    suffix = FORMATS.get(file_format, file_format)
    target = out or Path(f"{file.name.removesuffix('.npz')}{f'.{suffix}' if suffix else '_bag'}")
    if suffix:
        check_writable(target)
    note_replacing(target)
    write(motion, target, file_format, per_second, meshes, controllers)
    print(target)


def _controllers(options: list[str]) -> dict[str, list[str]]:
    """Controllers and their joints. Raises `InputError`."""
    found: dict[str, list[str]] = {}
    for option in options:
        name, sign, joints = option.partition("=")
        if not (name and sign and joints):
            raise InputError("controller", option, "must be a name and joints: legs=*_hip,*_knee")
        found.setdefault(name, []).extend(joints.split(","))
    return found
