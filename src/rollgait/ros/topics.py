"""Names of topics and frames, and the qualities of service that those who listen ask for.

Frames by REP-105: `map` and `odom` are the world, `base_link` the base; `base_footprint`, by REP-120, is what
is left of the base on the ground. Contact points have frames of their own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from rollgait.robot.robot import LEG_NAMES

MAP: Final = "map"
ODOM: Final = "odom"
BASE_LINK: Final = "base_link"
BASE_FOOTPRINT: Final = "base_footprint"
"""Names of frames."""

LEGS: Final = tuple(name.lower() for name in LEG_NAMES)
"""Names of the legs in topics, frames and joints: lower case, as ROS has it."""


@dataclass(frozen=True)
class Quality:
    """The quality of service of a topic. All are reliable: nothing here is so fast that losses are better.

    Attributes:
        depth: how many messages are kept for those who are slow.
        latched: whether who comes later gets the last message, too (durability "transient local").
    """

    depth: int = 10
    latched: bool = False


@dataclass(frozen=True)
class Topic:
    """A topic, the type of its messages, and its quality of service."""

    name: str
    type: str
    quality: Quality = Quality()


LATCHED: Final = Quality(1, latched=True)
"""Of what is said once: what robot_state_publisher and tf2 have for descriptions and fixed frames."""
TRANSFORMS: Final = Quality(100)
"""Of moving frames: what tf2 has."""
ONCE: Final = Quality(1)
"""Of a command. It is not latched: a controller that starts later must not begin to move."""

ROBOT_DESCRIPTION: Final = Topic("/robot_description", "std_msgs/msg/String", LATCHED)
TF: Final = Topic("/tf", "tf2_msgs/msg/TFMessage", TRANSFORMS)
TF_STATIC: Final = Topic("/tf_static", "tf2_msgs/msg/TFMessage", LATCHED)
JOINT_STATES: Final = Topic("/joint_states", "sensor_msgs/msg/JointState")
ODOMETRY: Final = Topic("/odom", "nav_msgs/msg/Odometry")
COM_PATH: Final = Topic("/plan/com", "nav_msgs/msg/Path", LATCHED)
FOOT_PATHS: Final = tuple(Topic(f"/plan/{leg}_foot", "nav_msgs/msg/Path", LATCHED) for leg in LEGS)
FOOTHOLDS: Final = Topic("/plan/footholds", "visualization_msgs/msg/MarkerArray", LATCHED)
WRENCHES: Final = tuple(Topic(f"/contact/{leg}", "geometry_msgs/msg/WrenchStamped") for leg in LEGS)
MARKERS: Final = Topic("/markers", "visualization_msgs/msg/MarkerArray")
GROUND: Final = Topic("/ground", "visualization_msgs/msg/Marker", LATCHED)


def trajectory_of(controller: str) -> Topic:
    """The topic on which a joint_trajectory_controller of ros2_control of this name takes trajectories."""
    return Topic(f"/{controller}/joint_trajectory", "trajectory_msgs/msg/JointTrajectory", ONCE)


def contact_frame(leg: str) -> str:
    """The frame of where a foot (`fl` …) touches the ground: axes of the world."""
    return f"{leg}_contact"
