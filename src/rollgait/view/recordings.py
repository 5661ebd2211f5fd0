"""Motions as files that one can send, by the end of the file's name."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rollgait.errors import MissingExtraError, UnknownNameError
from rollgait.files import check_writable

if TYPE_CHECKING:
    from rollgait.view.clip import Clip

RECORDINGS: Final = ("html", "mp4", "gif")


def check_recording(target: Path, field: str, data: tuple[str, ...] = ()) -> None:
    """Raises what writing `target` would raise, before the long work.

    Args:
        target: the file.
        field: option that names it.
        data: endings of files that hold data and can be written as well.
    """
    suffix, formats = target.suffix.removeprefix("."), (*data, *RECORDINGS)
    if suffix not in formats:
        raise UnknownNameError(field, target.name, formats, "must end in a format that is known")
    check_writable(target)
    if suffix in RECORDINGS:
        need_view("a recording")


def write_recording(clip: Clip, target: Path, ghost: Clip | None = None) -> Path:
    """Writes a clip as its name ends: a page that opens offline, or a film."""
    if target.suffix == ".html":
        from rollgait.view.recording import record_page

        return record_page(clip, target, ghost)
    from rollgait.view.video import record_gif, record_video

    return (record_gif if target.suffix == ".gif" else record_video)(clip, target, ghost)


def need_view(feature: str, *more: str) -> None:
    """Raises `MissingExtraError` where viser, or one of `more` modules of its extra, is not installed."""
    try:
        for module in ("viser", *more):
            import_module(module)
    except ImportError:
        raise MissingExtraError(feature, "view") from None
