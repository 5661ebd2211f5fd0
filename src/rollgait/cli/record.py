"""`rollgait record`: a motion as a file that one can send."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollgait.cli.view import MotionFile, need_viser
from rollgait.errors import UnknownNameError
from rollgait.files import check_writable

FORMATS = ("html", "mp4", "gif")


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
    """Record a motion: a page with a timeline that opens offline, or a video.

    Exit status: 0 done, 2 wrong input.
    """
    target = out or Path(f"{file.name.removesuffix('.npz')}.html")
    suffix = target.suffix.removeprefix(".")
    if suffix not in FORMATS:
        raise UnknownNameError("out", target.name, FORMATS, "must end in a format that is known")
    check_writable(target)
    need_viser("a recording")
    from rollgait.view.clip import open_clip

    clip = open_clip(file)
    ghost = None if compare is None else open_clip(compare)
    if suffix == "html":
        from rollgait.view.recording import record_page

        record_page(clip, target, ghost)
    else:
        from rollgait.view.video import record_gif, record_video

        (record_gif if suffix == "gif" else record_video)(clip, target, ghost)
    print(target)
