"""Messages as bytes: CDR, little endian, as ROS 2 has it on wires and in files. Needs the extra `mcap`.

The types are those of ROS 2 Humble, which its later releases did not change.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, Final

import numpy as np

from rollgait.errors import MissingExtraError
from rollgait.ros.messages import Fields


@cache
def typestore() -> Any:
    """The types. Raises `MissingExtraError`."""
    try:
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise MissingExtraError("an export to ROS 2", "mcap") from None
    return get_typestore(Stores.ROS2_HUMBLE)


def definition(name: str) -> str:
    """The definition of a type with all that it refers to, as MCAP's `ros2msg` wants it."""
    text, _ = typestore().generate_msgdef(name, ros_version=2)
    return str(text)


def type_hash(name: str) -> str:
    """The hash of a type, REP-2016: `RIHS01_…`."""
    return str(typestore().hash_rihs01(name))


def encode(name: str, fields: Fields) -> bytes:
    """A message of a type, what is left out being zero, empty or false; with CDR's head of 4 bytes.

    Raises:
        ValueError: the type has no such field.
    """
    return bytes(typestore().serialize_cdr(_maker(name)(fields), name, little_endian=True))


def decode(name: str, data: bytes) -> Fields:
    """The fields of a message of a type."""
    read: Fields = _plain(typestore().deserialize_cdr(data, name))
    return read


_DEFAULTS: Final[Mapping[str, Fields]] = {"geometry_msgs/msg/Quaternion": {"w": 1.0}}
"""Of types whose new messages are not all zeros."""


@cache
def _maker(name: str) -> Callable[[Mapping[str, Any]], Any]:
    """What makes a message of a type of plain data."""
    from rosbags.interfaces import Nodetype

    kind, parts, empty = typestore().types[name], {}, {}
    for field, (node, what) in typestore().get_msgdef(name).fields:
        if node is Nodetype.BASE:
            empty[field] = _empty(what[0])
        elif node is Nodetype.NAME:
            parts[field] = _nested(_maker(what))
        else:
            inner, content = what[0]
            count = what[1] if node is Nodetype.ARRAY else 0
            parts[field] = (
                _several(_maker(content)) if inner is Nodetype.NAME else _numbers(content[0], count)
            )
    known = {*empty, *parts}
    empty |= _DEFAULTS.get(name, {})

    def make(fields: Mapping[str, Any]) -> Any:
        if not known.issuperset(fields):
            raise ValueError(f"{name} has no field {', '.join(sorted(set(fields) - known))}")
        made = {field: part(fields.get(field)) for field, part in parts.items()}
        return kind(**{**empty, **fields, **made})

    return make


def _nested(make: Callable[[Mapping[str, Any]], Any]) -> Callable[[Any], Any]:
    return lambda value: make(value or {})


def _several(make: Callable[[Mapping[str, Any]], Any]) -> Callable[[Any], Any]:
    return lambda values: [make(value) for value in values or ()]


def _empty(base: str) -> Any:
    return "" if base == "string" else False if base == "bool" else 0.0 if "float" in base else 0


def _numbers(base: str, count: int) -> Callable[[Any], Any]:
    if base == "string":
        return lambda values: list(values or ())
    kind = np.dtype({"octet": "uint8", "byte": "uint8", "char": "uint8"}.get(base, base))
    return lambda values: np.zeros(count, kind) if values is None else np.ascontiguousarray(values, kind)


def _plain(value: Any) -> Any:
    if hasattr(value, "__msgtype__"):
        fields = typestore().get_msgdef(value.__msgtype__).fields
        return {field: _plain(getattr(value, field)) for field, _ in fields}
    return [_plain(part) for part in value] if isinstance(value, list) else value
