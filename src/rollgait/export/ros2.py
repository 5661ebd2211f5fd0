"""A motion as messages of ROS 2: topics, types and times. Writers of files are `mcap.py` and `rosbag2.py`.

The types are those of ROS 2 Humble, which its later releases did not change.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

import numpy as np
from scipy.spatial.transform import Rotation

from rollgait.errors import MissingExtraError
from rollgait.export.motion import LEGS, Motion, Sampled, sampled
from rollgait.plan.samples import Array
from rollgait.terrain.mesh import mesh_of, window_around

WORLD: Final = "odom"
BASE: Final = "base_link"
"""Names of frames, REP-105."""
FOREVER: Final = 2147483647
"""Seconds, or nanoseconds, that mean "never" in a quality of service."""
GROUND_CELLS: Final = 8000
"""Most cells of a map that are drawn: each is two triangles of 120 bytes."""
START: Final = 1_000_000_000
"""Stamp of t = 0, ns: 1 s, as stamp 0 means "the latest" to tf."""
FORCE_SCALE: Final = 1.0e-3
"""Length of the arrow of a force, m/N."""
BODY_HEIGHT: Final = 0.14
"""Of the box that stands for the body, m."""
COLOURS: Final = ((0.0, 0.447, 0.698), (0.835, 0.369, 0.0), (0.0, 0.620, 0.451), (0.8, 0.475, 0.655))
"""Of the legs, FL, FR, HL, HR: those of the figures."""


@dataclass(frozen=True)
class Topic:
    """A topic and its type.

    Attributes:
        name: of the topic.
        type: of its messages.
        latched: whether who comes later gets the last message, too.
    """

    name: str
    type: str
    latched: bool = False


TF: Final = Topic("/tf", "tf2_msgs/msg/TFMessage")
JOINT_STATES: Final = Topic("/joint_states", "sensor_msgs/msg/JointState")
JOINT_TRAJECTORY: Final = Topic("/joint_trajectory", "trajectory_msgs/msg/JointTrajectory")
COM_PATH: Final = Topic("/plan/com", "nav_msgs/msg/Path")
FOOT_PATHS: Final = tuple(Topic(f"/plan/{leg}_foot", "nav_msgs/msg/Path") for leg in LEGS)
WRENCHES: Final = tuple(Topic(f"/contact/{leg}", "geometry_msgs/msg/WrenchStamped") for leg in LEGS)
MARKERS: Final = Topic("/markers", "visualization_msgs/msg/MarkerArray")
GROUND: Final = Topic("/ground", "visualization_msgs/msg/Marker", latched=True)
TOPICS: Final = (GROUND, TF, JOINT_STATES, JOINT_TRAJECTORY, COM_PATH, *FOOT_PATHS, *WRENCHES, MARKERS)


@dataclass(frozen=True)
class Message:
    """A message: its topic, its time (ns), its content as CDR."""

    topic: Topic
    time: int
    data: bytes


def messages(motion: Motion, rate: float) -> Iterator[Message]:
    """All messages of a motion at a rate (Hz), in the order of time. Paths and the trajectory come first."""
    builder = _Builder(sampled(motion, rate))
    yield from builder.once()
    for index in range(len(builder.s.time)):
        yield from builder.at(index)


def definition(topic: Topic) -> str:
    """The definition of a topic's type with all that it refers to, as MCAP's `ros2msg` wants it."""
    text, _ = typestore().generate_msgdef(topic.type, ros_version=2)
    return str(text)


def qualities(topic: Topic) -> tuple[Any, ...]:
    """The qualities of service that a topic offers, where they are not ROS's own, as rosbags has them."""
    from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

    if not topic.latched:
        return ()
    never = QosTime(sec=FOREVER, nsec=FOREVER)
    return (
        Qos(
            history=QosHistory.KEEP_LAST,
            depth=1,
            reliability=QosReliability.RELIABLE,
            durability=QosDurability.TRANSIENT_LOCAL,
            deadline=never,
            lifespan=never,
            liveliness=QosLiveliness.AUTOMATIC,
            liveliness_lease_duration=never,
            avoid_ros_namespace_conventions=False,
        ),
    )


@lru_cache(maxsize=1)
def typestore() -> Any:
    """The types. Raises `MissingExtraError`."""
    try:
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise MissingExtraError("an export to ROS 2", "mcap") from None
    return get_typestore(Stores.ROS2_HUMBLE)


class _Builder:
    """Messages of a sampled motion."""

    def __init__(self, s: Sampled) -> None:
        self.s = s
        self.types: dict[str, Any] = typestore().types
        self._radius = [leg.wheel_radius for leg in s.robot.leg_list]

    def once(self) -> Iterator[Message]:
        """What is said once, at the beginning."""
        s = self.s.samples
        yield self._message(GROUND, 0, self._ground())
        yield self._message(JOINT_TRAJECTORY, 0, self._trajectory())
        yield self._message(COM_PATH, 0, self._path(s.com_position, self.s.base_quaternion))
        for leg, topic in enumerate(FOOT_PATHS):
            yield self._message(topic, 0, self._path(s.foot_position[:, leg], _yaw(s.heading[:, leg])))

    def at(self, index: int) -> Iterator[Message]:
        """What is said at a sample."""
        yield self._message(TF, index, self._tf(index))
        yield self._message(JOINT_STATES, index, self._joint_state(index))
        for leg, topic in enumerate(WRENCHES):
            yield self._message(topic, index, self._wrench(index, leg))
        yield self._message(MARKERS, index, self._markers(index))

    def _message(self, topic: Topic, index: int, content: Any) -> Message:
        data = typestore().serialize_cdr(content, topic.type)
        return Message(topic, self._nanoseconds(index), bytes(data))

    def _make(self, name: str, /, **parts: Any) -> Any:
        return self.types[name](**parts)

    def _nanoseconds(self, index: int) -> int:
        return START + round(1e9 * float(self.s.time[index]))

    def _header(self, index: int, frame: str) -> Any:
        stamp = self._time("builtin_interfaces/msg/Time", self._nanoseconds(index))
        return self._make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)

    def _time(self, name: str, nanoseconds: int) -> Any:
        return self._make(name, sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)

    def _point(self, p: Array, name: str = "geometry_msgs/msg/Point") -> Any:
        return self._make(name, x=float(p[0]), y=float(p[1]), z=float(p[2]))

    def _vector(self, p: Array) -> Any:
        return self._point(p, "geometry_msgs/msg/Vector3")

    def _quaternion(self, q: Array) -> Any:
        x, y, z, w = (float(part) for part in q)
        return self._make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)

    def _colour(self, colour: tuple[float, float, float]) -> Any:
        r, g, b = colour
        return self._make("std_msgs/msg/ColorRGBA", r=r, g=g, b=b, a=1.0)

    def _pose(self, p: Array, q: Array) -> Any:
        return self._make("geometry_msgs/msg/Pose", position=self._point(p), orientation=self._quaternion(q))

    def _tf(self, index: int) -> Any:
        """The base in the world, contact points in the world (axes of the world), wheels in the base."""
        s = self.s
        parts = [(WORLD, BASE, s.base_position[index], s.base_quaternion[index])]
        base = Rotation.from_quat(s.base_quaternion[index])
        for leg, name in enumerate(LEGS):
            place = s.samples.foot_position[index, leg]
            parts.append((WORLD, f"{name}_contact", place, _IDENTITY))
            centre = place + np.array([0.0, 0.0, self._radius[leg] or 0.0])
            turn = base.inv() * self._wheel(index, leg)
            within = base.inv().apply(centre - s.base_position[index])
            parts.append(
                (
                    BASE,
                    f"{name}_wheel" if s.robot.leg_list[leg].has_wheel else f"{name}_foot",
                    within,
                    turn.as_quat(),
                )
            )
        transforms = [
            self._make(
                "geometry_msgs/msg/TransformStamped",
                header=self._header(index, parent),
                child_frame_id=child,
                transform=self._make(
                    "geometry_msgs/msg/Transform",
                    translation=self._vector(p),
                    rotation=self._quaternion(q),
                ),
            )
            for parent, child, p, q in parts
        ]
        return self._make(TF.type, transforms=transforms)

    def _wheel(self, index: int, leg: int) -> Rotation:
        """Orientation of a wheel in the world: axle along y, turned by its angle."""
        s = self.s.samples
        heading = s.heading[index, leg] if self.s.robot.leg_list[leg].foot != "point" else s.euler[index, 0]
        return Rotation.from_euler("ZY", [heading, self.s.wheel_angle[index, leg]])

    def _joint_state(self, index: int) -> Any:
        s = self.s
        return self._make(
            JOINT_STATES.type,
            header=self._header(index, ""),
            name=list(s.joint_names),
            position=s.joint_position[index].astype(np.float64),
            velocity=s.joint_velocity[index].astype(np.float64),
            effort=s.joint_effort[index].astype(np.float64),
        )

    def _ground(self) -> Any:
        """Triangles with their colours: walls and all, and seen without a plug-in, as no grid would be."""
        s = self.s.samples
        window = window_around(np.concatenate([s.foot_position.reshape(-1, 3), s.com_position]))
        mesh = mesh_of(self.s.terrain, *window, GROUND_CELLS)
        marker = self._marker(
            0, "ground", 0, _TRIANGLES, self._pose(np.zeros(3), _IDENTITY), np.ones(3), (1.0, 1.0, 1.0)
        )
        marker.points = [self._point(p) for p in mesh.corners.reshape(-1, 3)]
        marker.colors = [
            self._colour((r / 255.0, g / 255.0, b / 255.0))
            for r, g, b in np.repeat(mesh.colours, 3, axis=0).tolist()
        ]
        return marker

    def _trajectory(self) -> Any:
        s = self.s
        points = [
            self._make(
                "trajectory_msgs/msg/JointTrajectoryPoint",
                positions=s.joint_position[i].astype(np.float64),
                velocities=s.joint_velocity[i].astype(np.float64),
                accelerations=np.zeros(0),
                effort=s.joint_effort[i].astype(np.float64),
                time_from_start=self._time("builtin_interfaces/msg/Duration", round(1e9 * float(t))),
            )
            for i, t in enumerate(s.time - s.time[0])
        ]
        return self._make(
            JOINT_TRAJECTORY.type,
            header=self._header(0, BASE),
            joint_names=list(s.joint_names),
            points=points,
        )

    def _path(self, places: Array, quaternions: Array) -> Any:
        poses = [
            self._make("geometry_msgs/msg/PoseStamped", header=self._header(i, WORLD), pose=self._pose(p, q))
            for i, (p, q) in enumerate(zip(places, quaternions, strict=True))
        ]
        return self._make(COM_PATH.type, header=self._header(0, WORLD), poses=poses)

    def _wrench(self, index: int, leg: int) -> Any:
        """The contact force on the robot, in world axes at the contact point."""
        wrench = self._make(
            "geometry_msgs/msg/Wrench",
            force=self._vector(self.s.samples.force[index, leg]),
            torque=self._vector(np.zeros(3)),
        )
        return self._make(
            WRENCHES[leg].type, header=self._header(index, f"{LEGS[leg]}_contact"), wrench=wrench
        )

    def _markers(self, index: int) -> Any:
        s, robot = self.s.samples, self.s.robot
        length, width = np.ptp(robot.stance[:, :2], axis=0)
        body = np.array([0.7 * length, 0.7 * width, BODY_HEIGHT])
        pose = self._pose(s.com_position[index], Rotation.from_euler("ZYX", s.euler[index]).as_quat())
        markers = [self._marker(index, "body", 0, _CUBE, pose, body, (0.25, 0.27, 0.3))]
        for leg, colour in enumerate(COLOURS):
            place, is_wheel = s.foot_position[index, leg], robot.leg_list[leg].has_wheel
            size = self._radius[leg] or 0.035
            turn = self._wheel(index, leg) * Rotation.from_euler("X", np.pi / 2)
            pose = self._pose(place + np.array([0.0, 0.0, size]), turn.as_quat())
            shape = _CYLINDER if is_wheel else _SPHERE
            extent = np.array([2 * size, 2 * size, 0.5 * size if is_wheel else 2 * size])
            markers.append(self._marker(index, "feet", leg, shape, pose, extent, colour))
            ends = [place, place + FORCE_SCALE * s.force[index, leg]]
            arrow = self._marker(
                index, "forces", leg, _ARROW, self._pose(np.zeros(3), _IDENTITY), _ARROW_SIZE, colour, ends
            )
            markers.append(arrow)
        return self._make(MARKERS.type, markers=markers)

    def _marker(
        self,
        index: int,
        namespace: str,
        number: int,
        shape: int,
        pose: Any,
        size: Array,
        colour: tuple[float, float, float],
        points: list[Array] | None = None,
    ) -> Any:
        return self._make(
            "visualization_msgs/msg/Marker",
            header=self._header(index, WORLD),
            ns=namespace,
            id=number,
            type=shape,
            action=0,
            pose=pose,
            scale=self._vector(size),
            color=self._colour(colour),
            lifetime=self._time("builtin_interfaces/msg/Duration", 0),
            frame_locked=False,
            points=[self._point(p) for p in points or ()],
            colors=[],
            texture_resource="",
            texture=self._make(
                "sensor_msgs/msg/CompressedImage",
                header=self._header(index, ""),
                format="",
                data=np.zeros(0, dtype=np.uint8),
            ),
            uv_coordinates=[],
            text="",
            mesh_resource="",
            mesh_file=self._make(
                "visualization_msgs/msg/MeshFile", filename="", data=np.zeros(0, dtype=np.uint8)
            ),
            mesh_use_embedded_materials=False,
        )


_ARROW, _CUBE, _SPHERE, _CYLINDER, _TRIANGLES = 0, 1, 2, 3, 11
"""Kinds of markers."""
_IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])
_ARROW_SIZE = np.array([0.02, 0.045, 0.08])
"""Diameter of the shaft, diameter and length of the head, m."""


def _yaw(angle: Array) -> Array:
    """Quaternions (x, y, z, w) of turns about the vertical, (n, 4)."""
    return np.asarray(Rotation.from_euler("Z", angle[:, None]).as_quat()).reshape(-1, 4)
