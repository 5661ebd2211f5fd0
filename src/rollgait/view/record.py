"""Recordings: a motion as a page that opens offline, or as a film; from Python, and inside a notebook."""

from __future__ import annotations

import base64
import tempfile
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any, Final

from rollgait.view.recordings import check_recording, write_recording

FRAME_HEIGHT: Final = 480
"""Of a recording in a notebook, pixels."""


@dataclass(frozen=True)
class Recording:
    """A recording, which plays in a notebook where it is the last line of a cell.

    Attributes:
        name: of the motion.
        format: `html`, a page that opens offline, `gif` or `mp4`.
        data: the whole file.
        path: where it was written to; None if nowhere.
    """

    name: str
    format: str
    data: bytes
    path: Path | None = None

    def __repr__(self) -> str:
        place = "not written" if self.path is None else str(self.path)
        return f"<Recording: {self.name}, {self.format}, {len(self.data) / 1e6:.1f} MB, {place}>"

    def _repr_html_(self) -> str:
        if self.format == "html":  # in a frame of its own that may run its script but reach nothing else
            page = escape(self.data.decode("utf-8"), quote=True)
            return (
                f'<iframe title="{escape(self.name)}" sandbox="allow-scripts" srcdoc="{page}" '
                f'style="width:100%;height:{FRAME_HEIGHT}px;border:0"></iframe>'
            )
        kind = "image/gif" if self.format == "gif" else "video/mp4"
        source = f"data:{kind};base64,{base64.b64encode(self.data).decode('ascii')}"
        if self.format == "gif":
            return f'<img alt="{escape(self.name)}" src="{source}">'
        return f'<video controls loop src="{source}"></video>'


def record(motion: Any, path: str | Path | None = None, compare: Any = None) -> Recording:
    """Records a motion: what `rollgait record` does, and for a notebook.

    Args:
        motion: a plan, joints, a simulation, a run of the controller, or the file of one.
        path: where to write it: `.html`, `.mp4` (extra `video`) or `.gif`; a page in memory if not given.
        compare: another one to show as a ghost.

    Raises:
        InputError: a file is not what it should be, the path cannot be written to, or has another ending.
        MissingExtraError: the extra `view`, or for a film `video`, is not installed.
    """
    target = None if path is None else Path(path)
    check_recording(target or Path("motion.html"), "path")
    from rollgait.view.opening import clip_of

    clip, ghost = clip_of(motion), None if compare is None else clip_of(compare)
    if target is not None:
        write_recording(clip, target, ghost)
        return Recording(clip.name, target.suffix.removeprefix("."), target.read_bytes(), target)
    with tempfile.TemporaryDirectory() as folder:
        page = write_recording(clip, Path(folder) / "motion.html", ghost)
        return Recording(clip.name, "html", page.read_bytes())
