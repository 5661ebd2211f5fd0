"""The folder of a data set: one writer, many readers, nothing half-written.

    dataset.json   the spec with all that it means
    maps/          heights of maps, by their digests
    rows/          one small Parquet file for each row that is in no part yet
    parts/         Parquet files of `PART_ROWS` rows

A row is durable as soon as it is planned. A part takes the place of its rows: it is written under a temporary
name, renamed, and only then are they removed. What dies in between leaves a row in both; the part counts.
"""

from __future__ import annotations

import io
import json
import os
import re
import stat
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from rollgait.archive import ArchiveFormat
from rollgait.dataset.columns import FORMAT_VERSION, TRAJECTORY, WHOLE, Record, arrow, layout, schema
from rollgait.dataset.sampler import Sampler
from rollgait.errors import FileError, InputError
from rollgait.files import MB, read_bytes, replacing
from rollgait.terrain.height_map import HeightMap
from rollgait.terrain.terrain import MapHeader

PART_ROWS: Final = 256
"""Rows of a part: some 5 MB, a few minutes of work of one core."""
GROUP_ROWS: Final = 64
"""Rows that are read at once where one is asked for."""
COMPRESSION: Final[dict[str, Any]] = {"compression": "zstd", "compression_level": 9}
ABOUT: Final = "dataset.json"
ABOUT_MAX: Final = 64 * MB
"""Largest description that is read: robots and bases by the thousand."""
LOCK: Final = ".lock"


class _MapFile(BaseModel):
    """What the header of a file of heights holds."""

    map: MapHeader


_MAP = ArchiveFormat(
    "rollgait-map",
    1,
    "map",
    "is not a map that rollgait saved",
    _MapFile,
    lambda _: {"heights": ("f", ("nx", "ny"))},
)


class Store:
    """The files of a data set.

    Args:
        folder: where they are.
        sampler: what the data set is.
    """

    def __init__(self, folder: Path, sampler: Sampler) -> None:
        self.folder, self.sampler = folder, sampler
        self.schema = schema(sampler)
        self._waiting: list[int] = []
        self._next = 0

    # -- opening --

    @classmethod
    def create(cls, folder: Path, sampler: Sampler) -> Store:
        """The store of a data set, made if it is not there; one that is there may have fewer rows.

        Raises:
            InputError: the folder holds another data set.
            FileError: the folder cannot be written to, or holds what is none.
        """
        store = cls(folder, sampler)
        if (folder / ABOUT).exists():
            found = cls.open(folder).sampler
            _require_same(folder, sampler, found)
            if sampler.spec.count <= found.spec.count:
                return cls(folder, found)
        elif folder.exists() and any(folder.iterdir()):
            raise FileError("out", str(folder), "holds other files and no data set: choose another folder")
        for digest, heights in sampler.maps.items():
            _MAP.write(
                folder / "maps" / f"{digest}.npz", {"map": heights.place()}, {"heights": heights.values}
            )
        about = {"format": "rollgait-dataset", "version": FORMAT_VERSION, **sampler.to_dict()}
        with replacing(folder / ABOUT) as temporary:
            temporary.write_text(json.dumps(about, indent=1), encoding="utf-8")
        return store

    @classmethod
    def open(cls, folder: str | Path) -> Store:
        """The store in a folder.

        Raises:
            FileError: there is none, or one of another version, or it is damaged.
            MissingExtraError: the extra `dataset` is not installed.
        """
        arrow()
        path = Path(folder) / ABOUT
        if not path.exists():
            raise FileError("dataset", str(folder), f"is no data set: it holds no {ABOUT}")
        try:
            about = json.loads(read_bytes(path, ABOUT_MAX))
            if about["format"] != "rollgait-dataset":
                raise ValueError
        except (ValueError, KeyError, TypeError, RecursionError):
            raise FileError("dataset", str(path), "is damaged, or not of a data set") from None
        if about.get("version") != FORMAT_VERSION:
            rule = f"has format version {about.get('version')!r}; this rollgait knows {FORMAT_VERSION}"
            raise FileError("dataset", str(path), rule)
        try:
            return cls(Path(folder), Sampler.from_dict(about, _read_maps(Path(folder) / "maps")))
        except (InputError, KeyError, AttributeError) as error:
            raise FileError("dataset", str(path), f"is damaged: {error}") from None

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Only one process at a time is in here; the system opens it again where that one is killed.

        Raises `FileError` where another process is.
        """
        try:
            with (self.folder / LOCK).open("a+b") as stream:
                if not _locked(stream.fileno()):
                    raise FileError("out", str(self.folder), "is being written by another process")
                self._tidy()
                yield
        except OSError as error:
            raise FileError(
                "out", str(self.folder), f"cannot be written: {error.strerror or error}"
            ) from None

    # -- writing --

    def encoded(self, record: Record) -> bytes:
        """A row as the bytes of its file: what a worker sends."""
        stream = io.BytesIO()
        table = arrow().Table.from_pylist([record], schema=self.schema)
        arrow().parquet.write_table(table, stream, use_dictionary=False, compression="zstd")
        return stream.getvalue()

    def add(self, row: int, content: bytes) -> None:
        """Keeps a row; where there are enough, they become a part."""
        with replacing(self._file(row)) as temporary:
            temporary.write_bytes(content)
        self._waiting.append(row)
        if len(self._waiting) >= PART_ROWS:
            self.merge()

    def merge(self) -> None:
        """Makes a part of all rows that are in none."""
        rows = sorted(self._waiting)
        if not rows:
            return
        table = arrow().concat_tables([self._read(self._file(row)) for row in rows])
        with replacing(self.folder / "parts" / f"part-{self._next:06d}.parquet") as temporary:
            arrow().parquet.write_table(
                table,
                temporary,
                row_group_size=GROUP_ROWS,
                use_dictionary=_repeating(self.schema),
                use_byte_stream_split=[
                    f"{TRAJECTORY}{name}.list.element"
                    for name, (kind, _) in layout().items()
                    if kind == "f" and name not in _CONSTANT
                ],
                **COMPRESSION,
            )
            _onto_disk(temporary)  # the rows, which go next, may be there already when the power fails
        self._next += 1
        for row in rows:
            self._file(row).unlink(missing_ok=True)
        self._waiting = []

    def _tidy(self) -> None:
        """After what was killed: temporary files go, and rows that are in a part already."""
        for path in (*self.folder.glob("rows/.*"), *self.folder.glob("parts/.*")):
            path.unlink(missing_ok=True)
        in_parts = self.planned(parts_only=True)
        self._waiting = []
        for row, path in _numbered(self.folder / "rows"):
            if row >= len(in_parts) or in_parts[row] or not _is_whole(path):
                path.unlink(missing_ok=True)
            else:
                self._waiting.append(row)
        self._next = 1 + max((number for number, _ in _numbered(self.folder / "parts")), default=-1)

    def _file(self, row: int) -> Path:
        return self.folder / "rows" / f"row-{row:08d}.parquet"

    # -- reading --

    def planned(self, parts_only: bool = False) -> NDArray[np.bool_]:
        """Which rows are there, (count,)."""
        found = np.zeros(self.sampler.spec.count, dtype=bool)
        alone = [] if parts_only else _numbered(self.folder / "rows")  # first: rows move into parts
        found[[row for row, _ in alone if row < len(found)]] = True
        for _, path in _numbered(self.folder / "parts"):
            rows = np.asarray(self._read(path, ["row"])["row"])
            found[rows[rows < len(found)]] = True
        return found

    def tables(self, columns: Sequence[str] | None = None) -> Iterator[Any]:
        """The table, file by file; each row once, also those that become part of another file meanwhile.

        Rows beyond the count that was asked for when the folder was opened are left out: it was raised since.
        """
        wanted = None if columns is None else ["row", *(name for name in columns if name != "row")]
        done = np.zeros(self.sampler.spec.count, dtype=bool)
        read: set[Path] = set()
        has_moved = True
        while has_moved:
            has_moved = False
            alone = _numbered(self.folder / "rows")  # first: rows move into parts, never back
            for _, path in (*_numbered(self.folder / "parts"), *alone):
                if path in read:
                    continue
                try:
                    table = self._read(path, wanted)
                except FileNotFoundError:
                    has_moved = True
                    continue
                read.add(path)
                rows = np.asarray(table["row"])
                fresh = rows < len(done)
                fresh[fresh] = ~done[rows[fresh]]
                done[rows[fresh]] = True
                if fresh.any():
                    yield table if fresh.all() else table.filter(fresh)

    def held(self) -> Iterator[int]:
        """The row of every line in every file."""
        for folder in ("parts", "rows"):
            for _, path in _numbered(self.folder / folder):
                with suppress(FileNotFoundError):  # it has become part of another meanwhile
                    yield from self._read(path, ["row"])["row"].to_pylist()

    def find(self, row: int) -> Record | None:
        """A row; None if it is not there."""
        with suppress(FileNotFoundError):  # alone first: rows move into parts, never back
            return self._found(self._file(row), row)
        for _, path in _numbered(self.folder / "parts"):
            if (found := self._found(path, row)) is not None:
                return found
        return None

    def _found(self, path: Path, row: int) -> Record | None:
        """A row of one file; None if the file does not hold it."""
        pa = arrow()
        with self._opened(path) as file:
            for group in range(file.num_row_groups):
                rows = np.asarray(file.read_row_group(group, ["row"])["row"])
                place = np.flatnonzero(rows == row)
                if place.size:
                    table = file.read_row_group(group).take(pa.array(place[:1]))
                    found: Record = table.to_pylist()[0]
                    return found
        return None

    def size(self) -> int:
        """Size of all of its files, bytes."""
        total = 0
        for path in self.folder.rglob("*"):
            with suppress(FileNotFoundError):  # it has become part of another meanwhile
                found = path.stat()
                total += found.st_size if stat.S_ISREG(found.st_mode) else 0
        return total

    def _read(self, path: Path, columns: Sequence[str] | None = None) -> Any:
        with self._opened(path) as file:
            table = file.read(columns)
            wanted = self.schema if columns is None else None
            return table.cast(wanted) if wanted is not None else table

    @contextmanager
    def _opened(self, path: Path) -> Iterator[Any]:
        pa = arrow()
        try:
            with pa.parquet.ParquetFile(path) as file:
                yield file
        except FileNotFoundError:
            raise
        except (pa.ArrowException, OSError) as error:
            text = " ".join(str(error).split())[:100]
            raise FileError("dataset", str(path), f"is damaged: {text}") from None


_CONSTANT: Final = (WHOLE, "ground", "wrench")
"""Arrays that mostly repeat themselves: a dictionary packs them better than anything else."""


def _repeating(table: Any) -> list[str]:
    """Columns that are packed by a dictionary of their values, as Parquet names them."""
    pa = arrow()
    words = [field.name for field in table if pa.types.is_dictionary(field.type)]
    row = [
        f"certificate.list.element.{name}" for name in ("name", "limit", "unit", "sense", "verdict", "leg")
    ]
    return [*words, *row, *(f"{TRAJECTORY}{name}.list.element" for name in _CONSTANT)]


def _numbered(folder: Path) -> list[tuple[int, Path]]:
    """The files of a folder by the number in their names, in this order; not those half-written."""
    found = [
        (re.fullmatch(r"(?:row|part)-(\d+)\.parquet", path.name), path) for path in folder.glob("*.parquet")
    ]
    return sorted((int(match[1]), path) for match, path in found if match)


def _onto_disk(path: Path) -> None:
    """Waits until the disk holds what was written to a file."""
    with path.open("rb+") as stream:
        os.fsync(stream.fileno())


def _is_whole(path: Path) -> bool:
    """Whether a file can be read: after a power failure a name may be there before its content."""
    try:
        with arrow().parquet.ParquetFile(path) as file:
            return bool(file.metadata.num_rows == 1)
    except (arrow().ArrowException, OSError):
        return False


def _read_maps(folder: Path) -> dict[str, HeightMap]:
    found = {}
    for path in sorted(folder.glob("[!.]*.npz")):
        header, arrays = _MAP.read(path)
        heights = HeightMap(arrays["heights"], **header.map.model_dump())
        found[heights.digest] = heights
    return found


def _require_same(folder: Path, asked: Sampler, found: Sampler) -> None:
    """Raises `InputError` unless two data sets differ in nothing but their description and count."""
    same = {"count": asked.spec.count, "description": asked.spec.description}
    one, other = asked.to_dict(), {**found.to_dict()}
    other["spec"] = {**other["spec"], **same}
    if json.dumps(one, sort_keys=True) != json.dumps(other, sort_keys=True):
        rule = "holds a data set of another spec; only its count may be raised: choose another folder"
        raise InputError("out", str(folder), rule)


if sys.platform == "win32":
    import msvcrt

    def _locked(number: int) -> bool:
        os.lseek(number, 0, os.SEEK_SET)
        try:
            msvcrt.locking(number, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

else:
    import fcntl

    def _locked(number: int) -> bool:
        try:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True
