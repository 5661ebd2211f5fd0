"""Messages of ROS 2 as plain data: dicts of their fields, nested as their types are.

What is left out is zero, empty or false, as it is in a new message of ROS. Stamps are in ns, quaternions
(x, y, z, w), everything else in SI units and radians.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Fields = dict[str, Any]
"""The fields of a message by name: numbers, texts, arrays, lists of these, and `Fields`."""

NANO = 1_000_000_000
"""ns in 1 s."""


@dataclass(frozen=True, eq=False)
class Pose:
    """Where a frame is in another one.

    Attributes:
        parent: the other frame.
        child: the frame.
        position: of its origin, (3,), m.
        quaternion: from its axes to those of the parent, (x, y, z, w), (4,).
    """

    parent: str
    child: str
    position: Array
    quaternion: Array


def stamp(nanoseconds: int) -> Fields:
    """`builtin_interfaces/Time` or `Duration`."""
    return {"sec": nanoseconds // NANO, "nanosec": nanoseconds % NANO}


def header(time: int, frame: str = "") -> Fields:
    """`std_msgs/Header`."""
    return {"stamp": stamp(time), "frame_id": frame}


def vector(values: Sequence[float] | Array) -> Fields:
    """`geometry_msgs/Vector3` or `Point`."""
    x, y, z = values
    return {"x": float(x), "y": float(y), "z": float(z)}


def quaternion(values: Sequence[float] | Array) -> Fields:
    """`geometry_msgs/Quaternion` from (x, y, z, w)."""
    x, y, z, w = values
    return {"x": float(x), "y": float(y), "z": float(z), "w": float(w)}


def pose(position: Array, orientation: Array | Sequence[float] = (0.0, 0.0, 0.0, 1.0)) -> Fields:
    """`geometry_msgs/Pose`."""
    return {"position": vector(position), "orientation": quaternion(orientation)}


def text(content: str) -> Fields:
    """`std_msgs/String`."""
    return {"data": content}


def transforms(time: int, poses: Iterable[Pose]) -> Fields:
    """`tf2_msgs/TFMessage`."""
    return {
        "transforms": [
            {
                "header": header(time, p.parent),
                "child_frame_id": p.child,
                "transform": {"translation": vector(p.position), "rotation": quaternion(p.quaternion)},
            }
            for p in poses
        ]
    }


def joint_state(
    time: int, names: Sequence[str], position: Array, velocity: Array, effort: Array | None = None
) -> Fields:
    """`sensor_msgs/JointState`; what is not known is an empty array."""
    return {
        "header": header(time),
        "name": list(names),
        "position": position,
        "velocity": velocity,
        "effort": np.zeros(0) if effort is None else effort,
    }


def odometry(time: int, base: Pose, linear: Array, angular: Array) -> Fields:
    """`nav_msgs/Odometry` of a base; velocities in its own axes, (3,), m/s and rad/s."""
    return {
        "header": header(time, base.parent),
        "child_frame_id": base.child,
        "pose": {"pose": pose(base.position, base.quaternion)},
        "twist": {"twist": {"linear": vector(linear), "angular": vector(angular)}},
    }


def joint_trajectory(
    names: Sequence[str], times: Array, position: Array, velocity: Array, acceleration: Array
) -> Fields:
    """`trajectory_msgs/JointTrajectory` as joint_trajectory_controller accepts it.

    Its stamp is 0, "begin now"; there are no efforts, which that controller refuses.

    Args:
        names: of the n_j joints.
        times: from the beginning, (n,), s.
        position, velocity, acceleration: (n, n_j), rad, rad/s, rad/s².
    """
    points = [
        {
            "positions": position[i],
            "velocities": velocity[i],
            "accelerations": acceleration[i],
            "time_from_start": stamp(round(NANO * float(t))),
        }
        for i, t in enumerate(times)
    ]
    return {"header": header(0), "joint_names": list(names), "points": points}


def path(times: Sequence[int], frame: str, positions: Array, quaternions: Array) -> Fields:
    """`nav_msgs/Path` of places (n, 3) with the axes (n, 4) at stamps (n,)."""
    poses = [
        {"header": header(t, frame), "pose": pose(p, q)}
        for t, p, q in zip(times, positions, quaternions, strict=True)
    ]
    return {"header": header(times[0], frame), "poses": poses}


def wrench(time: int, frame: str, force: Array, torque: Sequence[float] | Array = (0.0, 0.0, 0.0)) -> Fields:
    """`geometry_msgs/WrenchStamped`, N and N m in the axes of the frame."""
    return {"header": header(time, frame), "wrench": {"force": vector(force), "torque": vector(torque)}}
