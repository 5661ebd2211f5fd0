"""Files that a page sends: gathered here until they are whole, so that viser never holds parts of one."""

from __future__ import annotations

import io
import zipfile
from typing import Final

import viser
from viser import _messages as wire

from rollgait.errors import FileError
from rollgait.view.gate.controls import Controls
from rollgait.view.gate.messages import Message, RefusedError, shown

UPLOAD_MAX: Final = 64 * 2**20
"""Largest file, bytes: several times the log of ten minutes."""
UNPACKED_MAX: Final = 4 * UPLOAD_MAX
"""Of what a file unpacks to, bytes."""
PARTS_MAX: Final = 1024
"""Viser's page sends parts of half a megabyte."""
UPLOAD_SILENCE: Final = 20.0
"""A file of which nothing has come for so long is forgotten, s."""


class Upload:
    """The file that one page is sending: one at a time, the last that it began.

    Args:
        controls: of the page.
    """

    def __init__(self, controls: Controls) -> None:
        self._controls = controls
        self._start: wire.FileTransferStartUpload | None = None
        self._parts: dict[int, wire.FileTransferPart] = {}
        self._size = 0

    @property
    def unfinished(self) -> bool:
        """Whether parts are missing."""
        return self._start is not None

    def forget(self) -> None:
        """Lets go of what has come."""
        self._start, self._parts, self._size = None, {}, 0

    def begin(self, start: wire.FileTransferStartUpload) -> list[Message]:
        """A new file; what viser shall hear. Raises `RefusedError`."""
        self.forget()
        handle = self._controls.find(start.source_component_uuid)
        if not isinstance(handle, viser.GuiUploadButtonHandle):
            raise RefusedError("files cannot be sent there")
        if not 0 <= start.size_bytes <= UPLOAD_MAX:
            raise RefusedError(f"a file of {start.size_bytes} bytes; at most {UPLOAD_MAX} can be sent")
        if not 0 <= start.part_count <= PARTS_MAX or (start.part_count == 0) != (start.size_bytes == 0):
            raise RefusedError(f"{start.size_bytes} bytes in {start.part_count} parts")
        if start.part_count == 0:
            return [start]
        self._start = start
        return []

    def add(self, part: wire.FileTransferPart) -> list[Message]:
        """A part of it; the whole file once it is the last one. Raises `RefusedError`."""
        start = self._start
        if start is None or part.transfer_uuid != start.transfer_uuid:
            raise RefusedError(f"a part of {shown(part.transfer_uuid)}, which is not being sent")
        if not 0 <= part.part_index < start.part_count or part.part_index in self._parts:
            raise RefusedError(f"part {part.part_index} of a file of {start.part_count}")
        self._size += len(part.content)
        last = len(self._parts) + 1 == start.part_count
        if self._size > start.size_bytes or (last and self._size != start.size_bytes):
            self.forget()
            raise RefusedError(f"not the {start.size_bytes} bytes of which it spoke")
        part.source_component_uuid = start.source_component_uuid
        self._parts[part.part_index] = part
        if not last:
            return []
        whole = [start, *self._parts.values()]
        self.forget()
        return whole


def check_unpacked(name: str, content: bytes) -> None:
    """Raises `FileError` for an archive that would unpack to more than `UNPACKED_MAX`, before anything does.

    What is no archive at all is told by those who read it.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            size = sum(member.file_size for member in archive.infolist())  # no reader goes beyond these
    except Exception:  # damaged bytes lead anywhere
        return
    if size > UNPACKED_MAX:
        raise FileError("file", name, f"unpacks to {size} bytes; at most {UNPACKED_MAX} are read")
