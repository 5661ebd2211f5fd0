"""Heights in NumPy's own format."""

from __future__ import annotations

from typing import Any, BinaryIO

import numpy as np

from rollgait.terrain.map_file import RawMap, Source, check_cells


def read(source: Source) -> RawMap:
    """Value [i, j] stands at i along x and j along y; NaN is not known. Raises `FileError`."""
    try:
        with source.path.open("rb") as stream:
            shape, _, dtype = _header(stream)
    except OSError as error:
        raise source.fault(f"cannot be read: {error.strerror}") from None
    except Exception:  # a damaged header leads anywhere: SyntaxError, TokenError, UnicodeDecodeError …
        raise source.fault("is not an array that NumPy saved") from None
    if len(shape) != 2:
        raise source.fault(f"must be a grid of heights, (nx, ny), not an array of shape {shape}")
    if not (np.issubdtype(dtype, np.floating) or np.issubdtype(dtype, np.integer)):
        raise source.fault(f"must hold numbers, not {dtype}")
    check_cells(source, shape)
    try:
        values = np.load(source.path, allow_pickle=False)
    except (OSError, ValueError, EOFError, MemoryError):
        raise source.fault("is damaged: it ends before its last height") from None
    return RawMap(np.asarray(values, dtype=float))


def _header(stream: BinaryIO) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    version = np.lib.format.read_magic(stream)
    read_header = (
        np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    )
    return read_header(stream)
