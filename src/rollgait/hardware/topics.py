"""What crosses between robot, bridge and operator: topics and their types."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final

from rollgait.errors import MissingExtraError
from rollgait.ros.messages import Fields, joint_state
from rollgait.ros.topics import JOINT_STATES, MARKERS, ODOMETRY, TF, Topic
from rollgait.terrain.readers.grid_map import DEFINITIONS, GRID_MAP

if TYPE_CHECKING:
    from rollgait.tracking.follower import JointTarget

EXTRA: Final = "ros"
"""The optional extra that brings message types and DDS."""

IMU: Final = Topic("/imu", "sensor_msgs/msg/Imu")
JOINT_COMMANDS: Final = Topic("/joint_commands", "sensor_msgs/msg/JointState")

VELOCITY: Final = Topic("/cmd_vel", "geometry_msgs/msg/Twist")
GOAL: Final = Topic("/goal_pose", "geometry_msgs/msg/PoseStamped")
ENABLE: Final = Topic("/enable", "std_msgs/msg/Bool")
HEIGHTS: Final = Topic("/elevation_map", GRID_MAP)

PLAN: Final = Topic("/plan", "nav_msgs/msg/Path")
DIAGNOSTICS: Final = Topic("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")

TRUTH: Final = Topic("/truth", "std_msgs/msg/Float64MultiArray")
"""Said by a simulated robot for who reports errors; no part of what a robot says."""

SENSORS: Final = (JOINT_STATES, IMU, ODOMETRY)
COMMANDS: Final = (VELOCITY, GOAL, ENABLE, HEIGHTS)
"""What the bridge reads, from the robot and from above."""
OUTPUTS: Final = (JOINT_COMMANDS, PLAN, TF, MARKERS, DIAGNOSTICS)
"""What it writes."""
SHOWN: Final = (JOINT_STATES, ODOMETRY, *OUTPUTS)
"""What a window onto a simulated run says."""


@lru_cache(maxsize=1)
def types() -> Any:
    """The types of ROS 2 and a GridMap's. Raises `MissingExtraError`."""
    try:
        import rosbags.typesys  # noqa: F401
    except ImportError:
        raise MissingExtraError("driving a robot over a transport", EXTRA) from None
    from rosbags.typesys import get_types_from_msg

    from rollgait.ros.cdr import typestore

    store = typestore()
    for name, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    return store


def encoded(topic: Topic, fields: Fields) -> bytes:
    """A message of a topic as CDR."""
    from rollgait.ros.cdr import encode

    types()
    return encode(topic.type, fields)


def decoded(topic: Topic, data: bytes) -> Fields:
    """The fields of a message. Raises whatever the bytes give rise to: they may come from anywhere."""
    from rollgait.ros.cdr import decode

    types()
    return decode(topic.type, data)


def joint_command(stamp: int, names: Sequence[str], target: JointTarget) -> bytes:
    """What the joints are told, as CDR, at a stamp, ns."""
    fields = joint_state(stamp, names, target.position, target.velocity, target.torque)
    return encoded(JOINT_COMMANDS, fields)


def nanoseconds_of(header: Fields) -> int:
    """The stamp of a header, ns."""
    return int(header["stamp"]["sec"]) * 10**9 + int(header["stamp"]["nanosec"])
