"""What came from one page and what of it viser shall hear."""

from __future__ import annotations

from viser import _messages as wire

from rollgait.view.gate.controls import Controls
from rollgait.view.gate.messages import Message, decode, encode
from rollgait.view.gate.uploads import Upload


class Inbox:
    """The messages of one page.

    Args:
        controls: of the page.

    Attributes:
        upload: the file that is being sent.
    """

    def __init__(self, controls: Controls) -> None:
        self._controls = controls
        self.upload = Upload(controls)

    def admit(self, raw: bytes | str) -> list[bytes]:
        """The messages that viser shall hear now, checked and cut; often one. Raises `RefusedError`."""
        return [encode(message) for message in self._admitted(decode(raw))]

    def _admitted(self, message: Message) -> list[Message]:
        if isinstance(message, wire.FileTransferStartUpload):
            return self.upload.begin(message)
        if isinstance(message, wire.FileTransferPart):
            return self.upload.add(message)
        if isinstance(message, wire.GuiUpdateMessage):
            message.updates = self._controls.cut(message.uuid, message.updates)
        return [message]
