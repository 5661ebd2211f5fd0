"""`rollgait export`: a plan in a format that others read."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollgait.cli.arguments import rate_from
from rollgait.cli.motion_file import load_motion
from rollgait.cli.replacing import note_replacing


def export(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="A plan or a joint trajectory (.npz), as written here.")
    ],
    file_format: Annotated[
        str, typer.Option("--format", metavar="FORMAT", help="csv, json, mcap, rosbag2 or mujoco.")
    ] = "csv",
    rate: Annotated[str, typer.Option(metavar="HZ", help="Samples per second.")] = "100",
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Where to write. Default: <file>.<suffix>.")
    ] = None,
) -> None:
    """Write a plan or joints for other programs.

    They are sampled at a fixed rate.
    """
    per_second = rate_from(rate)
    motion = load_motion(file)
    from rollgait.export import FORMATS, write

    suffix = FORMATS.get(file_format, file_format)
    target = out or Path(f"{file.name.removesuffix('.npz')}{f'.{suffix}' if suffix else '.bag'}")
    note_replacing(target)
    write(motion, target, file_format, per_second)
    print(target)
