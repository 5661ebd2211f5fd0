"""Qualities of service as bags have them, so that `ros2 bag play` offers what those who listen ask for."""

from __future__ import annotations

from typing import Any, Final

from rollgait.ros.topics import Quality

FOREVER: Final = 2147483647
"""Seconds, or nanoseconds, that mean "never"."""


def offered(quality: Quality) -> Any:
    """A quality of service as rosbags has it."""
    from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

    never = QosTime(sec=FOREVER, nsec=FOREVER)
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=quality.depth,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if quality.latched else QosDurability.VOLATILE,
        deadline=never,
        lifespan=never,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=never,
        avoid_ros_namespace_conventions=False,
    )


def offered_text(quality: Any) -> str:
    """The same as `ros2 bag` looks for it beside a topic: the words of Humble, which all later ones read."""
    from rosbags.rosbag2.metadata import dump_qos_v8

    return str(dump_qos_v8([quality]))
