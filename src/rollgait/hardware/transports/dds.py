"""ROS 2 without ROS: its topics on DDS, by Cyclone DDS.

ROS 2 puts a topic `/joint_states` of type `sensor_msgs/msg/JointState` on DDS as `rt/joint_states` of type
`sensor_msgs::msg::dds_::JointState_`. Messages cross as the CDR that they come in; Cyclone only needs to know
what the type looks like, which is told from ROS's own definitions.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

from rollgait.errors import InputError, MissingExtraError
from rollgait.hardware.topics import EXTRA, types
from rollgait.hardware.transports.transport import Receive
from rollgait.ros.topics import Topic

DOMAIN_MAX: Final = 232
"""Largest number of a DDS domain: beyond it there are no ports."""
TAKEN: Final = 64
"""Most messages of a topic that are taken at a time."""


def mangled(kind: str) -> str:
    """A type's name on DDS: `pkg::msg::dds_::Name_` for `pkg/msg/Name`."""
    package, _, name = kind.split("/")
    return f"{package}::msg::dds_::{name}_"


def topic_name(topic: Topic) -> str:
    """A topic's name on DDS."""
    return "rt/" + topic.name.removeprefix("/")


def domain_of(domain: int | None) -> int:
    """The number of the domain: as given, or `ROS_DOMAIN_ID`, or 0. Raises `InputError`."""
    text = os.environ.get("ROS_DOMAIN_ID", "0") if domain is None else str(domain)
    if not text.strip().isdigit() or int(text) > DOMAIN_MAX:
        rule = f"must be a whole number from 0 to {DOMAIN_MAX}"
        raise InputError("domain" if domain is not None else "ROS_DOMAIN_ID", text, rule)
    return int(text)


def need_dds() -> None:
    """Raises `MissingExtraError` if Cyclone DDS is not installed."""
    types()
    try:
        import cyclonedds.idl  # noqa: F401
    except ImportError:
        raise MissingExtraError("DDS", EXTRA) from None


@cache
def idl_type(kind: str) -> type:
    """The type as Cyclone wants it, named as ROS 2 names it on DDS, e.g. of `sensor_msgs/msg/JointState`."""
    from cyclonedds.idl import make_idl_struct

    _, fields = types().fielddefs[kind]
    parts = {name: _idl_field(description) for name, description in fields}
    if not parts:  # ROS 2 puts this into empty messages
        parts["structure_needs_at_least_one_member"] = _base("uint8")
    name = mangled(kind)
    return make_idl_struct(name.split("::")[-1], name.replace("::", "."), parts)


def _idl_field(description: Any) -> Any:
    """A field as rosbags describes it: (kind of node, what it holds)."""
    idl: Any = importlib.import_module("cyclonedds.idl.types")
    node, detail = description
    match node.name:
        case "BASE":
            name, bound = detail
            return idl.bounded_str[bound] if name == "string" and bound else _base(name)
        case "NAME":
            return idl_type(detail)
        case "ARRAY":
            inner, length = detail
            return idl.array[_idl_field(inner), length]
        case _:
            inner, bound = detail
            return idl.sequence[_idl_field(inner), bound] if bound else idl.sequence[_idl_field(inner)]


def _base(name: str) -> Any:
    from cyclonedds.idl import types as idl

    names = {"string": str, "bool": bool, "octet": idl.byte, "byte": idl.byte, "char": idl.uint8}
    return names[name] if name in names else getattr(idl, name)


@dataclass
class _Raw:
    """CDR on its way through Cyclone, which would else serialise field by field, in Python."""

    data: bytes

    def serialize(self, **_: Any) -> bytes:
        return self.data

    @staticmethod
    def deserialize(data: bytes) -> _Raw:
        return _Raw(bytes(data))

    @staticmethod
    def deserialize_key(data: bytes) -> None:
        """Of a writer that has gone, Cyclone asks what it wrote about: nothing, these types have no keys."""


class DdsTransport:
    """Topics of ROS 2 on a DDS domain.

    Args:
        domain: number of the domain; `ROS_DOMAIN_ID`, or 0, if not given.

    Raises:
        MissingExtraError: Cyclone DDS or the message types are not installed.
        InputError: the domain is none.
    """

    def __init__(self, domain: int | None = None) -> None:
        need_dds()
        from cyclonedds.core import WaitSet
        from cyclonedds.domain import DomainParticipant

        self._participant = DomainParticipant(domain_of(domain))
        self._waitset = WaitSet(self._participant)
        self._topics: dict[Topic, Any] = {}
        self._writers: dict[Topic, Any] = {}
        self._readers: list[tuple[Any, Any, Receive]] = []

    def publish(self, topic: Topic, data: bytes) -> None:
        """Sends a message, as CDR."""
        self.writer(topic).write(_Raw(data))

    def writer(self, topic: Topic) -> Any:
        """Cyclone's writer of a topic; made when it is first asked for."""
        if topic not in self._writers:
            from cyclonedds.pub import DataWriter

            self._writers[topic] = DataWriter(self._participant, self._topic(topic), _qos(topic))
        return self._writers[topic]

    def advertise(self, topics: Sequence[Topic]) -> None:
        """Says what will be published, so that readers are found before the first message."""
        for topic in topics:
            self.writer(topic)

    def subscribe(self, topic: Topic, receive: Receive) -> None:
        """From now on hands messages of a topic to `receive`."""
        from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState
        from cyclonedds.sub import DataReader

        reader = DataReader(self._participant, self._topic(topic), _qos(topic))
        mask = SampleState.NotRead | ViewState.Any | InstanceState.Alive
        condition = ReadCondition(reader, mask)
        self._waitset.attach(condition)
        self._readers.append((reader, condition, receive))

    def receive(self, seconds: float) -> None:
        """Hands on what has come; if nothing has, waits for the first to come, so long at most."""
        if not self._take() and seconds > 0.0:
            self._waitset.wait(max(1, round(1e9 * seconds)))
            self._take()

    def _take(self) -> bool:
        came = False
        for reader, _, receive in self._readers:
            for sample in reader.take(TAKEN):
                if isinstance(sample, _Raw):
                    receive(sample.data)
                    came = True
        return came

    def _topic(self, topic: Topic) -> Any:
        if topic not in self._topics:
            from cyclonedds.topic import Topic as DdsTopic

            made: Any = DdsTopic(self._participant, topic_name(topic), idl_type(topic.type), _qos(topic))
            made.data_type = _Raw  # from here on bytes: Cyclone knows the type already
            self._topics[topic] = made
        return self._topics[topic]

    def close(self) -> None:
        """Leaves the domain."""
        for reader, condition, _ in self._readers:
            self._waitset.detach(condition)
            del reader
        self._readers.clear()
        self._writers.clear()
        self._topics.clear()


def _qos(topic: Topic) -> Any:
    """Reliable, as ROS 2 offers and asks for by default; XCDR1, as it has."""
    from cyclonedds.core import Policy, Qos
    from cyclonedds.util import duration

    durability = Policy.Durability.TransientLocal if topic.quality.latched else Policy.Durability.Volatile
    return Qos(
        Policy.Reliability.Reliable(max_blocking_time=duration(milliseconds=100)),
        Policy.History.KeepLast(topic.quality.depth),
        durability,
        Policy.DataRepresentation(use_cdrv0_representation=True),
    )
