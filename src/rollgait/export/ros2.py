"""A motion as messages of ROS 2: which topics, and when. Writers of files are `mcap.py` and `rosbag2.py`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

from rollgait.export.controllers import Controllers, joints_of_controllers
from rollgait.export.description import Description, Meshes, describe
from rollgait.export.frames import Frames, Names
from rollgait.export.motion import Motion, Sampled, sampled
from rollgait.plan.samples import Array
from rollgait.ros import markers, messages, topics
from rollgait.ros.cdr import encode
from rollgait.ros.messages import NANO, Fields
from rollgait.ros.topics import Topic
from rollgait.terrain.mesh import mesh_of, window_around

GROUND_CELLS: Final = 8000
"""Most cells of a map that are drawn: each is two triangles of 120 bytes."""
START: Final = NANO
"""Stamp of t = 0, ns: 1 s, as stamp 0 means "the latest" to tf."""

REST: Final = 0.01
"""Joints that end slower than this, rad/s, end at rest: plans end so but for their smoothing, and newer
joint_trajectory_controllers refuse what does not."""


@dataclass(frozen=True)
class Message:
    """A message: its topic, its time (ns), its content as CDR."""

    topic: Topic
    time: int
    data: bytes


class Recording:
    """A motion as others hear it.

    Args:
        motion: a plan, joints or a log.
        rate: messages per second, Hz.
        meshes: how the robot's description names its meshes.
        controllers: which of them gets which joints; by default one for wheels and one for all others.

    Attributes:
        s: the motion.
        robot: as others build it.
        names: of its frames.
        joints: of each controller.

    Raises:
        InputError: the rate, the meshes or the controllers are not what they must be.
        FileError: the robot's URDF cannot be read.
        MissingExtraError: an extra is not installed.
    """

    def __init__(
        self,
        motion: Motion,
        rate: float,
        meshes: Meshes = "beside",
        controllers: Controllers | None = None,
    ) -> None:
        self.s: Sampled = sampled(motion, rate)
        self.robot: Description = describe(self.s, meshes)
        self.joints = joints_of_controllers(self.robot, controllers)
        self._frames = Frames(self.s, self.robot)

    @property
    def names(self) -> Names:
        """Names of the frames that are not links."""
        return self._frames.names

    @property
    def links(self) -> tuple[str, ...]:
        """Names of all frames, the world first."""
        seen = [self.names.map, *(pose.child for pose in self._frames.fixed)]
        return tuple(dict.fromkeys([*seen, *(track.child for track in self._frames.moving)]))

    @property
    def trajectories(self) -> dict[str, Topic]:
        """The topic of each controller."""
        return {name: topics.trajectory_of(name) for name in self.joints}

    @property
    def topics(self) -> tuple[Topic, ...]:
        """All topics that there are messages on."""
        paths = (topics.COM_PATH, *topics.FOOT_PATHS, topics.FOOTHOLDS)
        often = (topics.TF, topics.JOINT_STATES, topics.ODOMETRY, *topics.WRENCHES, topics.MARKERS)
        described = (topics.ROBOT_DESCRIPTION, topics.TF_STATIC, topics.GROUND)
        return (*described, *paths, *self.trajectories.values(), *often)

    def messages(self) -> Iterator[Message]:
        """All messages in the order of time; what is said once comes first."""
        for topic, fields in self._once():
            yield self._message(topic, 0, fields)
        for index in range(len(self.s.time)):
            for topic, fields in self._at(index):
                yield self._message(topic, index, fields)

    def _message(self, topic: Topic, index: int, fields: Fields) -> Message:
        return Message(topic, self._stamp(index), encode(topic.type, fields))

    def _stamp(self, index: int) -> int:
        return START + round(NANO * float(self.s.time[index]))

    def _once(self) -> Iterator[tuple[Topic, Fields]]:
        s, begin, odom = self.s.samples, self._stamp(0), self.names.odom
        yield topics.ROBOT_DESCRIPTION, messages.text(self.robot.text)
        yield topics.TF_STATIC, messages.transforms(begin, self._frames.fixed)
        window = window_around(np.concatenate([s.foot_position.reshape(-1, 3), s.com_position]))
        mesh = mesh_of(self.s.terrain, *window, GROUND_CELLS)
        yield topics.GROUND, markers.triangles(begin, odom, "ground", mesh.corners, mesh.colours)
        stamps = [self._stamp(index) for index in range(len(s.time))]
        base = np.asarray(Rotation.from_euler("ZYX", s.euler).as_quat())
        yield topics.COM_PATH, messages.path(stamps, odom, s.com_position, base)
        for leg, topic in enumerate(topics.FOOT_PATHS):
            yield topic, messages.path(stamps, odom, s.foot_position[:, leg], _yaw(s.heading[:, leg]))
        yield topics.FOOTHOLDS, markers.foothold_markers(begin, odom, self._footholds())
        for name, topic in self.trajectories.items():
            yield topic, self._trajectory(self.joints[name])

    def _at(self, index: int) -> Iterator[tuple[Topic, Fields]]:
        s, robot, time = self.s.samples, self.robot, self._stamp(index)
        yield topics.TF, messages.transforms(time, [track.at(index) for track in self._frames.moving])
        state = (robot.position[index], robot.velocity[index], robot.effort[index])
        yield topics.JOINT_STATES, messages.joint_state(time, robot.joint_names, *state)
        linear, angular = self.s.base_velocity[index].reshape(2, 3)
        yield topics.ODOMETRY, messages.odometry(time, self._frames.base.at(index), linear, angular)
        for leg, topic in enumerate(topics.WRENCHES):
            yield topic, messages.wrench(time, self.names.contacts[leg], s.force[index, leg])
        turn = Rotation.from_euler("ZYX", s.euler[index]).as_quat()
        yield (
            topics.MARKERS,
            markers.robot_markers(
                time,
                self.names.odom,
                self.s.robot,
                s.com_position[index],
                turn,
                s.foot_position[index],
                self._wheels(index),
                s.force[index],
            ),
        )

    def _wheels(self, index: int) -> Array:
        """Orientations of the wheels, axle along y, turned by their angles, (4, 4)."""
        s = self.s.samples
        is_point = np.array([leg.foot == "point" for leg in self.s.robot.leg_list])
        heading = np.where(is_point, s.euler[index, 0], s.heading[index])
        turned = Rotation.from_euler("ZY", np.column_stack([heading, self.s.wheel_angle[index]]))
        return np.asarray(turned.as_quat())

    def _footholds(self) -> list[tuple[int, Array, Array]]:
        """Where feet land: leg, place and normal at the first sample of each stance that follows a swing."""
        s = self.s.samples
        landed = s.contact[1:] & ~s.contact[:-1]
        return [
            (int(leg), s.contact_position[row + 1, leg], s.contact_normal[row + 1, leg])
            for row, leg in np.argwhere(landed)
        ]

    def _trajectory(self, joints: tuple[str, ...]) -> Fields:
        s, columns = self.s, [self.s.joint_names.index(name) for name in joints]
        velocity, acceleration = s.joint_velocity[:, columns].copy(), s.joint_acceleration[:, columns].copy()
        if np.abs(velocity[-1]).max() <= REST:
            velocity[-1], acceleration[-1] = 0.0, 0.0
        since = s.time - s.time[0]
        return messages.joint_trajectory(joints, since, s.joint_position[:, columns], velocity, acceleration)


def _yaw(angle: Array) -> Array:
    """Quaternions (x, y, z, w) of turns about the vertical, (n, 4)."""
    return np.asarray(Rotation.from_euler("Z", angle[:, None]).as_quat()).reshape(-1, 4)
