"""Writing files so that an interruption leaves none half-written."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rollgait.errors import FileError


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A temporary path beside `path` that takes its place when the block ends well, and is removed otherwise.

    Creates the folder. The temporary path keeps the suffix, as many writers choose their format by it.
    Raises `FileError` if the place cannot be written to, or no longer.
    """
    target = Path(path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{target.stem}-", suffix=target.suffix, dir=target.parent)
    except OSError as error:
        raise FileError("file", str(target), f"cannot be written: {error.strerror}") from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o666 & ~_umask())  # mkstemp makes files that only their owner can read
        temporary.replace(target)
    except OSError as error:
        raise FileError("file", str(target), f"cannot be written: {error.strerror or error}") from None
    finally:
        temporary.unlink(missing_ok=True)


def check_writable(path: str | Path) -> None:
    """Raises `FileError` if no file could be written at `path`: known before the long work, not after."""
    target = Path(path)
    if target.is_dir():
        raise FileError("file", str(target), "cannot be written: it is a folder")
    folder = next(parent for parent in target.absolute().parents if parent.exists())
    if not folder.is_dir():
        raise FileError("file", str(target), f"cannot be written: {folder} is not a folder")
    if not os.access(folder, os.W_OK):
        raise FileError("file", str(target), f"cannot be written: no permission in {folder}")


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
