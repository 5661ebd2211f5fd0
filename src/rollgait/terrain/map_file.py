"""Finding and reading the file of a map: only in the scenario's folder, only of a sane size.

A new format is a reader in `readers/` and its suffixes in `READERS`. A reader gets a path that is safe to
open, turns what the file holds into heights in the axes of the world, and knows nothing else.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import MISSING, FileError, InputError
from rollgait.terrain.height_map import MAX_CELLS, HeightMap

FIELD: Final = "ground.map.file"

MAX_BYTES: Final = 256 * 1024 * 1024
"""Largest file, or folder of a bag: a recording of a few minutes, or the largest map in double precision."""


@dataclass(frozen=True)
class RawMap:
    """What a file holds, before scale and offset.

    Attributes:
        values: (nx, ny), value [i, j] at origin + Rz(yaw) (i, j) · resolution; NaN where not known.
        resolution: as the file says it, m; None if it does not.
        origin: as the file says it, (2,), m; None if it does not.
        yaw: of the grid, rad.
        metres: whether the values are heights in m by themselves.
    """

    values: NDArray[np.float64]
    resolution: float | None = None
    origin: NDArray[np.float64] | None = None
    yaw: float = 0.0
    metres: bool = True


@dataclass(frozen=True)
class Source:
    """What a reader is asked for.

    Attributes:
        path: safe to open.
        name: as the scenario says it, for messages.
        layer: of a GridMap.
        topic: of a bag; None if it has only one of a GridMap.
    """

    path: Path
    name: str
    layer: str = "elevation"
    topic: str | None = None

    def fault(self, rule: str) -> FileError:
        """The error that says what is wrong with the file."""
        return FileError(FIELD, self.name, rule)


Reader = Callable[[Source], RawMap]

READERS: Final = {
    ".npy": "npy",
    ".png": "png",
    ".tif": "geotiff",
    ".tiff": "geotiff",
    ".mcap": "grid_map",
    ".db3": "grid_map",
    "": "grid_map",
}
"""Module in `readers/` by the suffix of the file; a folder is a rosbag2."""

FORMATS: Final = (
    ".npy",
    ".png (16 bit)",
    ".tif (GeoTIFF)",
    ".mcap, .db3 or the folder of a rosbag2 (GridMap)",
)


def read_map(
    folder: Path,
    name: str,
    *,
    resolution: float | None = None,
    origin: tuple[float, float] | None = None,
    scale: float | None = None,
    offset: float = 0.0,
    layer: str = "elevation",
    topic: str | None = None,
) -> HeightMap:
    """The map in a file.

    Args:
        folder: of the scenario; the file must lie in it.
        name: of the file, relative to `folder`.
        resolution: m; must be given where the file does not say it, and only there.
        origin: place of value [0, 0] (of a picture: its lower left pixel), m; what the file says, or (0, 0).
        scale: by which the values are multiplied; must be given for a PNG.
        offset: which is added then, m.
        layer: of a GridMap.
        topic: of a bag.

    Raises:
        InputError: a key is missing, or not for this file.
        FileError: the file lies elsewhere, cannot be read, is too large, or holds no map of ground.
        MissingExtraError: the format needs an optional dependency.
    """
    source = Source(find_file(folder, name), name, layer, topic)
    suffix = source.path.suffix.lower() if not source.path.is_dir() else ""
    if suffix not in READERS or (suffix == "" and not source.path.is_dir()):
        raise FileError(FIELD, name, "must be a map of a kind that is known", FORMATS)
    reader: Reader = importlib.import_module(f"rollgait.terrain.readers.{READERS[suffix]}").read
    raw = reader(source)
    if raw.resolution is None and resolution is None:
        raise InputError(
            "ground.map.resolution", MISSING, f"must be given for {name}, m: the file does not say it"
        )
    if raw.resolution is not None and resolution is not None:
        rule = f"must be left out: {name} says itself that it is {raw.resolution:g} m"
        raise InputError("ground.map.resolution", resolution, rule)
    if not raw.metres and scale is None:
        raise InputError("ground.map.scale", MISSING, f"must be given for {name}: metres per grey level")
    at = origin if origin is not None else raw.origin if raw.origin is not None else (0.0, 0.0)
    heights = raw.values * (1.0 if scale is None else scale) + offset
    result = HeightMap(heights, resolution or raw.resolution or 0.0, np.array(at, dtype=float), raw.yaw)
    result.require_metres()
    return result


def find_file(folder: Path, name: str) -> Path:
    """The path of a file or bag that must lie in a folder.

    Raises:
        FileError: it is an absolute path, leaves the folder by `..` or by a link, does not exist, is no plain
            file, or is too large.
    """
    parts = PurePosixPath(name).parts
    windows = PureWindowsPath(name)
    if not name.strip() or "\0" in name:
        raise FileError(FIELD, name, "must be the name of a file in the scenario's folder")
    if PurePosixPath(name).is_absolute() or windows.is_absolute() or windows.drive or windows.root:
        raise FileError(FIELD, name, "must be relative to the scenario's folder, not an absolute path")
    if ".." in parts or ".." in windows.parts:
        raise FileError(FIELD, name, "must not leave the scenario's folder by '..'")
    try:
        home = folder.resolve(strict=True)
        path = (home / name).resolve(strict=True)
        inside = [path, *path.rglob("*")] if path.is_dir() else [path]
        inside = [entry.resolve(strict=True) for entry in inside]
        size = sum(entry.stat().st_size for entry in inside if entry.is_file())
    except (OSError, RuntimeError) as error:
        raise FileError(FIELD, name, f"cannot be read: {_reason(error)}") from None
    if not all(entry.is_relative_to(home) for entry in inside):
        raise FileError(FIELD, name, "must not leave the scenario's folder by a link")
    if not all(entry.is_file() or entry.is_dir() for entry in inside):
        raise FileError(FIELD, name, "must be a plain file, or the folder of a rosbag2")
    if size > MAX_BYTES:
        most = MAX_BYTES // 1024**2
        raise FileError(FIELD, name, f"must be at most {most} MB, not {size / 1024**2:.0f} MB")
    return path


def check_cells(source: Source, shape: tuple[int, ...]) -> None:
    """Raises `FileError` if a grid is too large, before it is read."""
    if np.prod(np.array(shape, dtype=float)) > MAX_CELLS:
        sides = " × ".join(str(n) for n in shape)
        raise source.fault(f"must have at most {MAX_CELLS} cells, not {sides}")


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error).splitlines()[0]
