"""Reading files that may be anything, and writing files so that an interruption leaves none half-written."""

from __future__ import annotations

import errno
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from rollgait.errors import FileError

MB = 1_000_000
"""Bytes."""


@contextmanager
def opened(path: str | Path, most: int, field: str = "file") -> Iterator[BinaryIO]:
    """A regular file, or a link to one, open for reading bytes.

    A pipe would be waited for and a device read without end, so neither is opened.

    Args:
        path: of the file.
        most: largest size of the file, bytes.
        field: that names the file in messages.

    Raises:
        FileError: there is no such file, it is larger, it is no regular file, or it cannot be read; also if
            reading it in the block fails.
    """
    if "\0" in str(path):
        raise FileError(field, str(path), "cannot be read: a path holds no null characters")
    try:
        if not stat.S_ISREG(Path(path).stat().st_mode):  # a device may take being opened as a command
            raise _not_regular(path, field)
        # without waiting: by now another program may have put a pipe into its place
        number = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        with os.fdopen(number, "rb") as stream:
            found = os.fstat(number)
            if not stat.S_ISREG(found.st_mode):
                raise _not_regular(path, field)
            check_size(found.st_size, most, str(path), field)
            yield stream
    except OSError as error:
        raise FileError(field, str(path), f"cannot be read: {error.strerror or error}") from None


def read_bytes(path: str | Path, most: int, field: str = "file") -> bytes:
    """All bytes of a regular file, of at most `most`. Raises `FileError`, as `opened` does."""
    with opened(path, most, field) as stream:
        content = stream.read(most + 1)
    check_size(len(content), most, str(path), field)  # it may have grown, or have no size, as in /proc
    return content


def check_size(size: int, most: int, name: str, field: str = "file") -> None:
    """Raises `FileError` if what is called `name` has more than `most` bytes: before it is read or kept."""
    if size > most:
        raise FileError(field, name, f"is too large: {size / MB:.3g} MB; at most {most / MB:.3g} MB are read")


def _not_regular(path: str | Path, field: str) -> FileError:
    reason = os.strerror(errno.EISDIR) if Path(path).is_dir() else "it is a pipe or a device, not a file"
    return FileError(field, str(path), f"cannot be read: {reason}")


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


def npz_path(path: str | Path, field: str = "file") -> Path:
    """The path of a file of arrays: `.npz` is added where there is no ending; others raise `FileError`."""
    target = Path(path)
    if not target.name:
        raise FileError(field, str(target), "cannot be written: it is a folder")
    if target.suffix == ".npz":
        return target
    if target.suffix[1:2].isalpha():  # `v1.2` is a name without a suffix
        raise FileError(field, str(target), "must end in .npz")
    return target.with_name(f"{target.name}.npz")


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
