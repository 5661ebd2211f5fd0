"""Where compiled kernels are kept, and whether the place can be trusted: what lies there is run.

A digest beside a library shows damage, not malice: whoever can write one can write the other. So a folder or
file counts only if nobody but its user could have written it.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

from rollgait.errors import FileError

CACHE_VARIABLE = "ROLLGAIT_CACHE"
"""Environment variable that names the folder of the cache, or `off`."""
OWNER_ONLY = 0o700
"""Permissions of what is made here."""
WRITABLE_BY_OTHERS = stat.S_IWGRP | stat.S_IWOTH


def cache_folder() -> Path | None:
    """Where kernels are kept; None if the cache is switched off, or there is no home to keep them in."""
    asked = os.environ.get(CACHE_VARIABLE)
    if asked == "off":
        return None
    if asked:
        return Path(asked)
    base = os.environ.get("XDG_CACHE_HOME")
    try:
        return (Path(base) if base else Path.home() / ".cache") / "rollgait"
    except RuntimeError:  # a user whom the system does not know, as in a container
        return None


def private_folder(folder: Path, *, create: bool = False) -> Path | None:
    """The folder, its links resolved, if only its user can have written into it; None if there is none.

    Args:
        folder: as `cache_folder` says.
        create: makes it if it is missing, for its user alone.

    Raises:
        FileError: another user owns it, others can write into it or replace it, or it cannot be read or made.
    """
    try:
        place = folder.resolve()
        if create:
            for missing in reversed([p for p in (place, *place.parents) if not p.exists()]):
                missing.mkdir(mode=OWNER_ONLY, exist_ok=True)
        elif not place.exists():
            return None
        reason = _why_not_private(place)
    except (OSError, RuntimeError) as error:  # RuntimeError: links that lead in a circle
        reason = getattr(error, "strerror", None) or "its links lead in a circle"
        raise FileError(CACHE_VARIABLE, str(folder), f"cannot be used: {reason}") from None
    if reason:
        raise FileError(CACHE_VARIABLE, str(folder), f"cannot be used: {reason}")
    return place


def is_private_file(path: Path) -> bool:
    """Whether this is a file, no link, that only its user can have written."""
    found = path.lstat()
    return stat.S_ISREG(found.st_mode) and _is_own(found) and not found.st_mode & WRITABLE_BY_OTHERS


def _why_not_private(place: Path) -> str | None:
    found = place.stat()
    if not stat.S_ISDIR(found.st_mode):
        return "it is not a folder"
    if os.name != "posix":  # no owners and permissions of this kind
        return None
    if not _is_own(found):
        return "another user owns it"
    if found.st_mode & WRITABLE_BY_OTHERS:
        return "other users can write into it; remove it, and it is made anew with permissions 700"
    trusted = {os.geteuid(), 0, Path("/").stat().st_uid}  # root has another id in some sandboxes
    for parent in place.parents:
        above = parent.stat()
        # in a folder like /tmp, with the sticky bit, only its owner can replace what lies there
        if above.st_mode & WRITABLE_BY_OTHERS and not above.st_mode & stat.S_ISVTX:
            return f"other users can replace it: they can write into {parent}"
        if above.st_uid not in trusted:
            return f"another user owns {parent} and can replace it"
    return None


def _is_own(found: os.stat_result) -> bool:
    return os.name != "posix" or found.st_uid == os.geteuid()
