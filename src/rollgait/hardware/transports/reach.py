"""Who is spoken to: a DDS domain, and perhaps Foxglove as well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rollgait.hardware.topics import OUTPUTS
from rollgait.hardware.transports.dds import DdsTransport, domain_of, need_dds
from rollgait.hardware.transports.foxglove import FoxgloveTransport, need_foxglove
from rollgait.hardware.transports.transport import Several, Transport
from rollgait.ros.topics import Topic


@dataclass(frozen=True)
class Reach:
    """Which transports are open.

    Attributes:
        domain: of DDS.
        foxglove: port of Foxglove's WebSocket, 0 for a free one; None for none.
        foxglove_commands: whether its clients may publish.
    """

    domain: int = 0
    foxglove: int | None = None
    foxglove_commands: bool = False


def reach_of(domain: int | None, foxglove: bool, port: int, commands: bool = False) -> Reach:
    """What options ask for, checked; nothing is opened yet.

    Args:
        domain: of DDS; None for `ROS_DOMAIN_ID`, or 0.
        foxglove: whether there shall be Foxglove's WebSocket.
        port: of that.
        commands: whether its clients may publish; then there is one.

    Raises:
        MissingExtraError: Cyclone DDS, foxglove-sdk or the message types are not installed.
        InputError: the domain is none.
    """
    need_dds()
    served = foxglove or commands
    if served:
        need_foxglove()
    return Reach(domain_of(domain), port if served else None, commands)


def opened(reach: Reach, topics: Sequence[Topic] = OUTPUTS) -> tuple[Transport, tuple[str, ...]]:
    """The transport, and what a person wants to know of it, line by line.

    Args:
        reach: which transports.
        topics: that will be published.

    Raises:
        InputError: the port is in use.
    """
    dds = DdsTransport(reach.domain)
    dds.advertise(topics)
    said = (f"ROS 2 on domain {reach.domain}",)
    if reach.foxglove is None:
        return dds, said
    try:
        server = FoxgloveTransport(reach.foxglove, commands=reach.foxglove_commands, topics=topics)
    except BaseException:
        dds.close()
        raise
    return Several(dds, [server]), (*said, f"Foxglove: ws://127.0.0.1:{server.port}")
