"""The frames of a motion: the world, the base, every link of the robot, and where its feet touch the ground.

    map → odom → base_link → every link of the URDF
           │         └→ base_footprint
           └→ <leg>_contact

By REP-105 localisation says how `odom` lies in `map`; who only plans has no drift, so they are the same. A
URDF whose root has another name than `base_link` hangs below it without a turn, unless it has a link of that
name; then `odom` leads to its root. `base_footprint` is that of REP-120: amid the feet, at the height of the
lowest one, with the yaw of the base.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from rollgait.export.description import Description, free_name
from rollgait.export.motion import Sampled
from rollgait.plan.samples import Array
from rollgait.robot.link_poses import joint_frames
from rollgait.robot.urdf_files import Urdf
from rollgait.ros.markers import UPRIGHT
from rollgait.ros.messages import Pose
from rollgait.ros.topics import BASE_FOOTPRINT, BASE_LINK, LEGS, MAP, ODOM, contact_frame


@dataclass(frozen=True)
class Names:
    """Names of the frames that are not links of the robot; where it has a link of that name, another one.

    Attributes:
        map, odom: the world.
        base: in which the pose of the base is given.
        footprint: of the base on the ground.
        contacts: where the feet touch the ground.
    """

    map: str
    odom: str
    base: str
    footprint: str
    contacts: tuple[str, ...]


def names_for(urdf: Urdf) -> Names:
    """Names that are no links of a robot."""
    taken = urdf.links
    return Names(
        map=free_name(MAP, taken),
        odom=free_name(ODOM, taken),
        base=urdf.root_link if BASE_LINK in taken else BASE_LINK,
        footprint=free_name(BASE_FOOTPRINT, taken),
        contacts=tuple(free_name(contact_frame(leg), taken) for leg in LEGS),
    )


@dataclass(frozen=True)
class Track:
    """A frame over time: its pose in its parent, p (n, 3), m, and q (x, y, z, w), (n, 4)."""

    parent: str
    child: str
    p: Array
    q: Array

    def at(self, index: int) -> Pose:
        """The pose at a sample; of a frame that does not move, at any."""
        row = min(index, len(self.p) - 1)
        return Pose(self.parent, self.child, self.p[row], self.q[row])


class Frames:
    """The frames of a motion.

    Attributes:
        names: of those that are no links.
        fixed: that never move.
        moving: that may.
    """

    def __init__(self, s: Sampled, robot: Description) -> None:
        self.names = names_for(robot.urdf)
        tracks = list(self._world(s, robot.urdf.root_link))
        still = [Pose(self.names.map, self.names.odom, np.zeros(3), UPRIGHT)]
        if self.names.base != robot.urdf.root_link:
            still.append(Pose(self.names.base, robot.urdf.root_link, np.zeros(3), UPRIGHT))
        for frame in joint_frames(robot.urdf, robot.joint_names, robot.position):
            count = len(s.time) if frame.moves else 1
            q: Array = Rotation.from_matrix(np.broadcast_to(frame.R, (count, 3, 3))).as_quat()
            track = Track(frame.joint.parent, frame.joint.child, np.broadcast_to(frame.p, (count, 3)), q)
            if frame.moves:
                tracks.append(track)
            else:
                still.append(track.at(0))
        self.fixed = tuple(still)
        self.moving = tuple(tracks)

    @property
    def base(self) -> Track:
        """The base in the world."""
        return self.moving[0]

    def _world(self, s: Sampled, root: str) -> Iterator[Track]:
        names = self.names
        yield Track(names.odom, names.base, s.base_position, s.base_quaternion)
        yield self._footprint(s)
        upright = np.tile(UPRIGHT, (len(s.time), 1))
        for leg, name in enumerate(names.contacts):
            yield Track(names.odom, name, s.samples.contact_position[:, leg], upright)

    def _footprint(self, s: Sampled) -> Track:
        feet = s.samples.foot_position
        place = np.column_stack([feet[..., :2].mean(axis=1), feet[..., 2].min(axis=1)])
        base = Rotation.from_quat(s.base_quaternion)
        yaw = Rotation.from_euler("Z", s.samples.euler[:, :1])
        within = base.inv().apply(place - s.base_position)
        return Track(self.names.base, self.names.footprint, within, np.asarray((base.inv() * yaw).as_quat()))
