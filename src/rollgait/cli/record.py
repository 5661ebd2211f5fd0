"""`rollgait record`: a motion as a file that one can send."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollgait.cli.replacing import note_replacing
from rollgait.cli.view import MotionFile
from rollgait.view.recordings import check_recording, write_recording


def record(
    file: MotionFile,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Where to write: .html, .mp4 or .gif. Default: <file>.html."),
    ] = None,
    compare: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Another one, to be shown as a ghost.")
    ] = None,
) -> None:
    """Record a motion as a page that opens offline, or as a video.

    Exit status: 0 done, 2 wrong input.
    """
    target = out or Path(f"{file.name.removesuffix('.npz')}.html")
    check_recording(target, "out")
    from rollgait.view.opening import open_clip

    clip = open_clip(file)
    ghost = None if compare is None else open_clip(compare)
    note_replacing(target)
    write_recording(clip, target, ghost)
    print(target)
