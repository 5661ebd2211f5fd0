"""Where the links of a URDF are, for many postures at once, by its own rules. Needs no robot library."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rollgait.robot.urdf_files import Joint, Urdf
from rollgait.robot.urdf_shapes import numbers, origin_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Poses:
    """Poses of a frame over time, world: R (n, 3, 3) and p (n, 3), m."""

    R: Array
    p: Array

    def then(self, R: Array, p: Array) -> Poses:
        """The poses of a frame that is fixed in (or moves by `R` (n, 3, 3) in) this one."""
        return Poses(self.R @ R, self.p + (self.R @ np.broadcast_to(p, self.p.shape)[..., None])[..., 0])


@dataclass(frozen=True)
class JointFrame:
    """A joint over time: the pose of its child link in its parent link.

    Attributes:
        joint: the joint.
        R: (n, 3, 3), or (1, 3, 3) where nothing moves it.
        p: (n, 3) or (1, 3), m.
    """

    joint: Joint
    R: Array
    p: Array

    @property
    def moves(self) -> bool:
        """Whether the joint may move, be it that it stands still here."""
        return self.joint.kind != "fixed"


def joint_frames(urdf: Urdf, names: Sequence[str], angles: Array) -> Iterator[JointFrame]:
    """All joints of a robot from its root outwards.

    Args:
        urdf: the robot.
        names: of the joints whose angles are known; one that is not follows the joint that it mimics, or
            stays at 0.
        angles: (n, n_j), rad or m.
    """
    column = {name: angles[:, number] for number, name in enumerate(names)}
    waiting = [urdf.root_link]
    while waiting:
        for joint in urdf.children_of(waiting.pop(0)):
            waiting.append(joint.child)
            element = urdf.joint_elements[joint.name]
            R, p = origin_of(element)
            turn, shift = _motion(element, joint, _angle_of(element, joint, column))
            yield JointFrame(joint, R @ turn, p + shift @ R.T)


def link_poses(
    urdf: Urdf, names: Sequence[str], angles: Array, base_position: Array, base_quaternion: Array
) -> dict[str, Poses]:
    """The poses of all links of a robot with a free base; arguments as those of `joint_frames`, and the base.

    Args:
        base_position: origin of the root link, (n, 3), m.
        base_quaternion: root link to world, (x, y, z, w), (n, 4).
    """
    base: Array = Rotation.from_quat(base_quaternion).as_matrix()
    poses = {urdf.root_link: Poses(base, base_position)}
    for frame in joint_frames(urdf, names, angles):
        poses[frame.joint.child] = poses[frame.joint.parent].then(frame.R, frame.p)
    return poses


def vector(element: ET.Element, key: str, default: str = "0 0 0") -> Array:
    """Three numbers in an attribute."""
    return numbers(element.get(key, default))


def axis_of(element: ET.Element) -> Array:
    """The axis of a joint as it is written; x if there is none."""
    axis = element.find("axis")
    return np.array([1.0, 0.0, 0.0]) if axis is None else vector(axis, "xyz")


def _angle_of(element: ET.Element, joint: Joint, known: Mapping[str, Array]) -> Array | None:
    """Angles of a joint, (n,), rad or m; None if nothing moves it."""
    mimic = element.find("mimic")
    if joint.name in known or mimic is None:
        return known.get(joint.name)
    offset = float(mimic.get("offset", "0"))
    followed = known.get(joint.mimics or "", np.zeros(1))
    return np.asarray(float(mimic.get("multiplier", "1")) * followed + offset)


def _motion(element: ET.Element, joint: Joint, values: Array | None) -> tuple[Array, Array]:
    """How a joint has moved from its origin: R (n, 3, 3) and p (n, 3), m."""
    if joint.kind == "fixed" or values is None:
        return np.eye(3)[None], np.zeros((1, 3))
    axis = axis_of(element)
    if joint.kind == "prismatic":
        return np.eye(3)[None], values[:, None] * axis
    turns = values[:, None] * axis / np.linalg.norm(axis)
    return np.asarray(Rotation.from_rotvec(turns).as_matrix()), np.zeros((1, 3))
