"""What crosses: topics, their types, and the bytes of their messages, as ROS 2 has them."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Final

from rollgait.errors import MissingExtraError
from rollgait.export.ros2 import Topic
from rollgait.terrain.readers.grid_map import DEFINITIONS, GRID_MAP

EXTRA: Final = "ros"
"""The optional extra that brings message types and DDS."""

JOINT_STATES: Final = Topic("/joint_states", "sensor_msgs/msg/JointState")
IMU: Final = Topic("/imu", "sensor_msgs/msg/Imu")
ODOMETRY: Final = Topic("/odom", "nav_msgs/msg/Odometry")
JOINT_COMMANDS: Final = Topic("/joint_commands", "sensor_msgs/msg/JointState")

VELOCITY: Final = Topic("/cmd_vel", "geometry_msgs/msg/Twist")
GOAL: Final = Topic("/goal_pose", "geometry_msgs/msg/PoseStamped")
ENABLE: Final = Topic("/enable", "std_msgs/msg/Bool")
MAP: Final = Topic("/elevation_map", GRID_MAP)

PLAN: Final = Topic("/plan", "nav_msgs/msg/Path")
TF: Final = Topic("/tf", "tf2_msgs/msg/TFMessage")
MARKERS: Final = Topic("/markers", "visualization_msgs/msg/MarkerArray")
DIAGNOSTICS: Final = Topic("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")

INPUTS: Final = (JOINT_STATES, IMU, ODOMETRY, VELOCITY, GOAL, ENABLE, MAP)
"""What `rollgait bridge` reads."""
OUTPUTS: Final = (JOINT_COMMANDS, PLAN, TF, MARKERS, DIAGNOSTICS)
"""What it writes."""


@lru_cache(maxsize=1)
def types() -> Any:
    """The types of ROS 2 (Humble, which later releases did not change) and a GridMap's.

    Raises:
        MissingExtraError: the extra is not installed.
    """
    try:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ImportError:
        raise MissingExtraError("driving a robot over a transport", EXTRA) from None
    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    return store


def make(kind: str, /, **parts: Any) -> Any:
    """A message, or a part of one, of a type such as `geometry_msgs/msg/Point`."""
    return types().types[kind](**parts)


def encoded(topic: Topic, message: Any) -> bytes:
    """A message as little-endian CDR with its header of four bytes."""
    return bytes(types().serialize_cdr(message, topic.type))


def decoded(topic: Topic, data: bytes) -> Any:
    """The message in CDR. Raises whatever of ValueError's kind the bytes give rise to."""
    return types().deserialize_cdr(data, topic.type)


def stamp_of(nanoseconds: int) -> Any:
    """A time of ROS."""
    return make("builtin_interfaces/msg/Time", sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


def header_of(nanoseconds: int, frame: str = "") -> Any:
    """A header with its stamp and frame."""
    return make("std_msgs/msg/Header", stamp=stamp_of(nanoseconds), frame_id=frame)


def nanoseconds_of(header: Any) -> int:
    """The stamp of a header, ns."""
    return int(header.stamp.sec) * 10**9 + int(header.stamp.nanosec)
