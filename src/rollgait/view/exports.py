"""The motion that is shown as a file of another format, for a browser to keep."""

from __future__ import annotations

import shutil
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from rollgait.errors import InputError
from rollgait.export import FORMATS, write
from rollgait.view.clip import Clip

RECORDINGS: Final[dict[str, str]] = {"page (html)": "html", "GIF": "gif"}
"""Formats of pictures, with their suffixes."""
NEED_JOINTS: Final = frozenset({"mujoco"})
"""Formats that hold joints only."""


def exported(clip: Clip, format: str, stem: str) -> tuple[str, bytes]:
    """The name and the content of a file with a motion; a folder comes as a zip.

    Args:
        clip: the motion.
        format: a key of `FORMATS` or of `RECORDINGS`.
        stem: of the name.

    Raises:
        InputError: the motion cannot be had in this format.
        MissingExtraError: the format needs an extra that is not installed.
    """
    with TemporaryDirectory(prefix="rollgait-export-") as folder:
        path = _written(clip, format, Path(folder) / stem)
        if path.is_dir():
            path = Path(shutil.make_archive(str(path), "zip", path.parent, path.name))
        return path.name, path.read_bytes()


def _written(clip: Clip, format: str, path: Path) -> Path:
    if format in RECORDINGS:
        from rollgait.view.recording import record_page
        from rollgait.view.video import record_gif

        target = path.with_name(f"{path.name}.{RECORDINGS[format]}")
        return record_page(clip, target) if format == "page (html)" else record_gif(clip, target)
    motion = clip.plan if format == "csv" else clip.trajectory or clip.plan
    if motion is None:
        raise InputError("format", format, f"holds plans and joints; {clip.name} is a log", list(RECORDINGS))
    suffix = FORMATS.get(format, format)
    return write(motion, path.with_name(f"{path.name}.{suffix}" if suffix else f"{path.name}.bag"), format)
