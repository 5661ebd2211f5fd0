"""Where the links of a URDF are, for many postures at once. Only what a picture needs; NumPy alone."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass

import numpy as np

from rollgait.plan.samples import Array
from rollgait.robot.urdf_files import Urdf
from rollgait.view.rotations import matrix_from_axis, matrix_from_quaternion, matrix_from_rpy


@dataclass(frozen=True)
class Poses:
    """Poses of a frame over time, world: R (n, 3, 3) and p (n, 3), m."""

    R: Array
    p: Array

    def then(self, R: Array, p: Array) -> Poses:
        """The poses of a frame that is fixed in (or moves by `R` (n, 3, 3) in) this one."""
        return Poses(self.R @ R, self.p + (self.R @ np.broadcast_to(p, self.p.shape)[..., None])[..., 0])


def link_poses(
    urdf: Urdf, names: tuple[str, ...], angles: Array, base_position: Array, base_quaternion: Array
) -> dict[str, Poses]:
    """The poses of all links of a robot with a free base.

    Args:
        urdf: the robot.
        names: of the joints whose angles are known; all others stay at 0.
        angles: (n, n_j), rad or m.
        base_position: origin of the root link, (n, 3), m.
        base_quaternion: root link to world, (x, y, z, w), (n, 4).
    """
    column = {name: number for number, name in enumerate(names)}
    children = {joint.child for joint in urdf.joints.values()}
    root = next(name for name in urdf.links if name not in children)
    poses = {root: Poses(matrix_from_quaternion(base_quaternion), base_position)}
    waiting = list(urdf.root.findall("joint"))
    while waiting:
        later = []
        for element in waiting:
            joint = urdf.joints.get(element.get("name", ""))
            if joint is None or joint.parent not in poses:
                later.append(element)
                continue
            R, p = origin_of(element)
            pose = poses[joint.parent].then(R, p)
            if joint.name in column and joint.kind != "fixed":
                pose = _moved(pose, element, joint.kind, angles[:, column[joint.name]])
            poses[joint.child] = pose
        if len(later) == len(waiting):
            break  # what hangs on nothing is not shown
        waiting = later
    return poses


def origin_of(element: ET.Element) -> tuple[Array, Array]:
    """R (3, 3) and p (3,) of the `origin` in an element; identity if there is none."""
    origin = element.find("origin")
    if origin is None:
        return np.eye(3), np.zeros(3)
    return matrix_from_rpy(*vector(origin, "rpy")), vector(origin, "xyz")


def vector(element: ET.Element, key: str, default: str = "0 0 0") -> Array:
    """Three numbers in an attribute."""
    return np.array([float(text) for text in element.get(key, default).split()])


def axis_of(element: ET.Element) -> Array:
    """The axis of a joint as it is written; x if there is none."""
    axis = element.find("axis")
    return np.array([1.0, 0.0, 0.0]) if axis is None else vector(axis, "xyz")


def _moved(pose: Poses, element: ET.Element, kind: str, values: Array) -> Poses:
    axis = axis_of(element)
    if kind == "prismatic":
        return pose.then(np.eye(3), values[:, None] * axis)
    return pose.then(matrix_from_axis(axis, values), np.zeros(3))
