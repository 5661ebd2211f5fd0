"""What a page may say: a few of viser's messages, each of its own shape, with numbers that are numbers.

Viser believes its page: it sets whatever attribute of a control a message names. Here a message is read
strictly and written anew, so that viser gets nothing that was not checked.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from typing import Any, Final

import msgspec
from viser import _messages as wire

NUMBER_MAX: Final = 1e9
"""Largest number that means anything on a page: places in m, sizes in pixels, bytes."""
TEXT_MAX: Final = 1024
"""Longest text of a message, characters: names of nodes and files, values of controls."""
SHOWN_MAX: Final = 80
"""Of a value in a line of the log, characters."""

Message = Any
"""One of the classes below; viser's base class of messages has no type that helps here."""

_KINDS: Final = (
    wire.ViewerCameraMessage,
    wire.GuiUpdateMessage,
    wire.CommandTriggerMessage,
    wire.TransformControlsUpdateMessage,
    wire.TransformControlsDragStartMessage,
    wire.TransformControlsDragEndMessage,
    wire.SceneNodeClickMessage,
    wire.SceneNodeDragMessage,
    wire.FileTransferStartUpload,
    wire.FileTransferPart,
)
_DECODERS: Final[dict[str, Any]] = {kind.__name__: msgspec.msgpack.Decoder(kind) for kind in _KINDS}


class RefusedError(Exception):
    """A message is not believed; the text says why, in one short line."""


class _Kind(msgspec.Struct):
    type: str


def decode(raw: bytes | str) -> Message:
    """The message in what came from a page. Raises `RefusedError`."""
    if isinstance(raw, str):
        raise RefusedError("it is text")
    try:
        kind = msgspec.msgpack.decode(raw, type=_Kind).type
        decoder = _DECODERS.get(kind)
        if decoder is None:
            raise RefusedError(f"{shown(kind)} is nothing that this page says")
        message: Message = decoder.decode(raw)
    except (msgspec.MsgspecError, RecursionError, UnicodeDecodeError) as error:
        raise RefusedError(f"it cannot be read: {_line(str(error))}") from None
    for field in dataclasses.fields(message):
        check(f"{kind}.{field.name}", getattr(message, field.name))
    return message


def encode(message: Message) -> bytes:
    """A message as viser reads it."""
    fields = {field.name: getattr(message, field.name) for field in dataclasses.fields(message)}
    return msgspec.msgpack.encode({"type": type(message).__name__, **fields})


def check(name: str, value: Any) -> None:
    """Raises `RefusedError` for a number that is none or far too large, or a text that is far too long."""
    if isinstance(value, float | int) and not (math.isfinite(value) and abs(value) <= NUMBER_MAX):
        raise RefusedError(f"{name} is {shown(value)}")
    if isinstance(value, str) and len(value) > TEXT_MAX:
        raise RefusedError(f"{name} has {len(value)} characters")
    if isinstance(value, tuple):
        _check_all(name, value)


def _check_all(name: str, values: Iterable[Any]) -> None:
    for value in values:
        check(name, value)


def shown(value: Any) -> str:
    """A value in a line: short, without control characters."""
    return _line(repr(value))


def _line(text: str) -> str:
    text = "".join(letter if letter.isprintable() else " " for letter in text)
    return text if len(text) <= SHOWN_MAX else f"{text[: SHOWN_MAX - 1]}…"
