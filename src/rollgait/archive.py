"""Files of rollgait: arrays, and a header that says what they are, in one .npz. Reading runs none of it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from rollgait.config import validate
from rollgait.errors import FileError, InputError, shown
from rollgait.files import MB, npz_path, opened, replacing
from rollgait.npz import Layout, Npz

FILE_MAX: Final = 2**32 - 1
"""Largest file, bytes: beyond, archives have another structure, and no memory holds the arrays."""
ARRAYS_MAX: Final = 128 * MB
"""What the arrays of a small file may take, bytes: 20 minutes of the whole body at 100 Hz. Longer logs make
larger files, which may take more."""

_HEADER = "header"


@dataclass(frozen=True)
class ArchiveFormat:
    """One kind of file.

    Attributes:
        name: in the header, e.g. `rollgait-plan`.
        version: of the format; a file of another one is refused.
        field: what messages call such a file.
        not_one: what is said of a file that is none.
        header: what its header holds, beside name and version.
        layout: the arrays that it must hold, from its header; others are not read.
        other_version: what is said of one of another version, `{found}`.
    """

    name: str
    version: int
    field: str
    not_one: str
    header: type[BaseModel]
    layout: Callable[[Any], Layout]
    other_version: str = "has format version {found}; this rollgait knows version {known}"

    def write(self, path: str | Path, header: Mapping[str, Any], arrays: Mapping[str, Any]) -> Path:
        """Writes a file (.npz is added to a name without ending); returns its path. Raises `FileError`."""
        target = npz_path(path)
        text = json.dumps({"format": self.name, "version": self.version, **header})
        contents: dict[str, Any] = {_HEADER: np.array(text), **arrays}
        with replacing(target) as temporary, temporary.open("wb") as stream:
            np.savez_compressed(stream, **contents)
        return target

    def read(self, path: str | Path) -> tuple[Any, dict[str, NDArray[Any]]]:
        """The header, a `self.header`, and the arrays of a file, which are what `self.layout` says.

        Raises:
            FileError: it is none, is of another version, is damaged, or takes too much memory.
        """
        with _opened(path, self.field, self.not_one) as members:
            data = json.loads(members.text(_HEADER))
            if not isinstance(data, dict) or data.get("format") != self.name:
                raise FileError(self.field, str(path), self.not_one)
            found = data.get("version")
            if found != self.version:
                rule = self.other_version.format(found=shown(found), known=self.version)
                raise FileError(self.field, str(path), rule)
            with self.damage_told(path):
                header = validate(self.header, data)
                layout = self.layout(header)
            return header, members.arrays(layout, ARRAYS_MAX)

    @contextmanager
    def damage_told(self, path: str | Path) -> Iterator[None]:
        """A rule that is broken in the block, where the parts of a file are put together, is its damage."""
        try:
            yield
        except InputError as error:
            raise FileError(self.field, str(path), f"is damaged: {error}") from None


def kind_of(path: str | Path, not_one: str) -> str:
    """What the header of a file says that it holds: the name of an `ArchiveFormat`, whatever its version.

    Raises:
        FileError: the file cannot be read, or is none of ours (`not_one` says so).
    """
    with _opened(path, "file", not_one) as members:
        kind = str(json.loads(members.text(_HEADER))["format"])
    if not kind.startswith("rollgait-"):
        raise FileError("file", str(path), not_one)
    return kind


@contextmanager
def _opened(path: str | Path, field: str, not_one: str) -> Iterator[Npz]:
    """The contents of an .npz file; whatever goes wrong in the block is the file's fault."""
    with opened(path, FILE_MAX, field) as stream:
        try:
            yield Npz(stream, os.fstat(stream.fileno()).st_size)
        except FileError:
            raise
        except InputError as error:
            raise FileError(field, str(path), f"is damaged: {error}") from None
        except Exception:  # damaged bytes lead anywhere: zlib.error, struct.error, BadZipFile, MemoryError …
            raise FileError(field, str(path), not_one) from None
