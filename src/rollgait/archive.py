"""Files of rollgait: arrays, and a header that says what they are, in one .npz. Reading runs none of it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rollgait.errors import FileError
from rollgait.files import replacing

_HEADER = "header"


@dataclass(frozen=True)
class ArchiveFormat:
    """One kind of file.

    Attributes:
        name: in the header, e.g. `rollgait-plan`.
        version: of the format; a file of another one is refused.
        field: what messages call such a file.
        not_one: what is said of a file that is none.
        other_version: what is said of one of another version, `{found}`.
    """

    name: str
    version: int
    field: str
    not_one: str
    other_version: str = "has format version {found}; this rollgait knows version {known}"

    def write(self, path: str | Path, header: Mapping[str, Any], arrays: Mapping[str, Any]) -> Path:
        """Writes a file (the suffix .npz is added if it is missing); returns its path. Raises `FileError`."""
        target = Path(path)
        if target.suffix != ".npz":
            target = target.with_name(target.name + ".npz")
        text = json.dumps({"format": self.name, "version": self.version, **header})
        contents: dict[str, Any] = {_HEADER: np.array(text), **arrays}
        with replacing(target) as temporary, temporary.open("wb") as stream:
            np.savez_compressed(stream, **contents)
        return target

    def read(self, path: str | Path) -> tuple[dict[str, Any], dict[str, Any]]:
        """The header and the arrays of a file. Raises `FileError` if it is none, or of another version."""
        with _opened(path, self.field, self.not_one) as data:
            arrays = {key: data[key] for key in data.files}
            header = json.loads(str(arrays.pop(_HEADER)))
        if not isinstance(header, dict) or header.get("format") != self.name:
            raise FileError(self.field, str(path), self.not_one)
        found = header.get("version")
        if found != self.version:
            rule = self.other_version.format(found=found, known=self.version)
            raise FileError(self.field, str(path), rule)
        return header, arrays

    @contextmanager
    def damage_told(self, path: str | Path) -> Iterator[None]:
        """What goes wrong in the block, where the parts of a file are put together, becomes a `FileError`."""
        try:
            yield
        except (KeyError, TypeError, ValueError) as error:
            reason = f"{error} is missing" if isinstance(error, KeyError) else str(error).splitlines()[0]
            raise FileError(self.field, str(path), f"is damaged: {reason}") from None


def kind_of(path: str | Path, not_one: str) -> str:
    """What the header of a file says that it holds: the name of an `ArchiveFormat`, whatever its version.

    Raises:
        FileError: the file cannot be read, or is none of ours (`not_one` says so).
    """
    with _opened(path, "file", not_one) as data:
        kind = str(json.loads(str(data[_HEADER]))["format"])
    if not kind.startswith("rollgait-"):
        raise FileError("file", str(path), not_one)
    return kind


@contextmanager
def _opened(path: str | Path, field: str, not_one: str) -> Iterator[Any]:
    """The contents of an .npz file; whatever goes wrong in the block is the file's fault."""
    try:
        with Path(path).open("rb") as stream, np.load(stream, allow_pickle=False) as data:
            yield data
    except OSError as error:
        reason = f"cannot be read: {error.strerror}" if error.strerror else not_one
        raise FileError(field, str(path), reason) from None
    except Exception:  # damaged bytes lead anywhere: zlib.error, struct.error, BadZipFile, MemoryError …
        raise FileError(field, str(path), not_one) from None
