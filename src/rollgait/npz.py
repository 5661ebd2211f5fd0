"""Arrays in an .npz file that may be hostile: what each takes is known, and limited, before it is read.

`numpy.load` trusts sizes, compression and the list of members; here a member is looked at in three steps: the
sizes that the archive states, the header of the array, the numbers.
"""

from __future__ import annotations

import math
import struct
import zipfile
from collections.abc import Mapping
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from rollgait.errors import MISSING, InputError
from rollgait.files import MB

Layout = Mapping[str, tuple[str, tuple[int | str, ...]]]
"""Kind of number (f, i or b) and shape of each array. A length given by a name is the same wherever the name
stands, and at least 1."""

KINDS: Final[dict[str, tuple[Any, str]]] = {
    "f": (np.float64, "floating-point numbers"),
    "i": (np.int64, "whole numbers"),
    "b": (np.bool_, "truth values"),
}
TEXT_MAX: Final = 16 * MB
"""Largest text, bytes in memory; each character takes 4."""
UNPACKED_SHARE: Final = 10
"""By how many times arrays beyond a limit may be larger than their file: numbers that were measured or solved
for are packed to a half, rarely to a tenth, those of a bomb to a thousandth."""
_DIRECTORY_MAX: Final = 64 * 1024
"""Largest list of members, bytes: some 500."""
_PREAMBLE_MAX: Final = 10_000
"""Longest description of an array, bytes; also NumPy's limit."""
_END: Final = struct.Struct("<4s4H2LH")
"""End of an archive: signature, …, size of the list of members, …, length of a comment, which must be 0."""
_FAR_END: Final = struct.Struct("<4sLQL")
"""What precedes it where the archive needs 64-bit sizes."""


class Npz:
    """The members of an .npz file. Whatever is wrong with the archive itself raises some exception.

    Args:
        stream: the file.
        size: of the file, bytes.
    """

    def __init__(self, stream: BinaryIO, size: int) -> None:
        self._size = size
        _check_end(stream, size)
        self._archive = zipfile.ZipFile(stream)

    def text(self, name: str) -> str:
        """The text in a member that holds one."""
        dtype, shape = self._described(name)
        if dtype.kind != "U" or shape != () or dtype.itemsize > TEXT_MAX:
            raise ValueError(f"{name} must be a text of at most {TEXT_MAX // 4} characters")
        return str(self._numbers(name))

    def arrays(self, layout: Layout, most: int) -> dict[str, NDArray[Any]]:
        """The arrays that a layout names, and no others.

        Args:
            layout: what each must be.
            most: what all may take together, bytes; more only if the file itself is large.

        Raises:
            InputError: one is missing, another than the layout says, or they are too large.
        """
        lengths: dict[str, int] = {}
        total = 0
        for name, (kind, shape) in layout.items():
            if self._member(name) is None:
                raise InputError(name, MISSING, "is missing")
            dtype, found = self._described(name)
            wanted = tuple(lengths.get(n, n) if isinstance(n, str) else n for n in shape)
            fits = len(found) == len(wanted) and all(
                length >= 1 if isinstance(n, str) else length == n
                for n, length in zip(wanted, found, strict=True)
            )
            if not fits or dtype.kind != kind or not np.can_cast(dtype, KINDS[kind][0], "safe"):
                shape_text = f"({', '.join(map(str, wanted))}{',' * (len(wanted) == 1)})"
                raise InputError(name, found, f"must have the shape {shape_text} and hold {KINDS[kind][1]}")
            lengths |= {n: length for n, length in zip(shape, found, strict=True) if isinstance(n, str)}
            total += math.prod(found) * KINDS[kind][0]().itemsize
        if total > max(most, UNPACKED_SHARE * self._size):
            limit = f"at most {most / MB:.3g} MB are read from a file of {self._size / MB:.3g} MB"
            raise InputError("arrays", MISSING, f"take {total / MB:.3g} MB unpacked; {limit}")
        return {
            name: self._numbers(name).astype(KINDS[kind][0], copy=False) for name, (kind, _) in layout.items()
        }

    def _member(self, name: str) -> zipfile.ZipInfo | None:
        return self._archive.NameToInfo.get(f"{name}.npy")

    def _described(self, name: str) -> tuple[np.dtype[Any], tuple[int, ...]]:
        """Type and shape of an array. Raises `InputError` unless the archive states the size that follows."""
        info = self._archive.getinfo(f"{name}.npy")
        if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise ValueError(f"{name} is compressed in a way that NumPy does not use")
        with self._archive.open(info) as stream:
            if npy.read_magic(stream) != (1, 0):  # the others are for descriptions of more than 64 KB
                raise ValueError(f"{name} has another version")
            shape, _, dtype = npy.read_array_header_1_0(stream, max_header_size=_PREAMBLE_MAX)
            begin = stream.tell()
        if dtype.hasobject or begin + math.prod(shape) * dtype.itemsize != info.file_size:
            raise InputError(name, shape, "is not the shape of the numbers in the file")
        return dtype, shape

    def _numbers(self, name: str) -> NDArray[Any]:
        with self._archive.open(f"{name}.npy") as stream:
            numbers: NDArray[Any] = npy.read_array(stream, allow_pickle=False)
        return numbers


def _check_end(stream: BinaryIO, size: int) -> None:
    """Raises ValueError unless the list of members, which `ZipFile` reads as a whole, is short."""
    tail = min(size, _FAR_END.size + _END.size)
    stream.seek(size - tail)
    far, end = (data := stream.read(tail))[: -_END.size], data[-_END.size :]
    signature, *_, listed, _, comment = _END.unpack(end)
    if signature != b"PK\x05\x06" or comment or listed > _DIRECTORY_MAX or far.startswith(b"PK\x06\x07"):
        raise ValueError("the archive does not end as those of NumPy do")
    stream.seek(0)
