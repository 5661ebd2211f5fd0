"""The geometry of a URDF: its shapes in the frame of a link, and what is welded to what."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rollgait.robot.urdf_files import Urdf

Array = NDArray[np.float64]

MESH_BYTES_MAX: Final = 100_000_000
"""Largest mesh that is measured."""

ROUND_POINTS: Final = 24
"""Corners of a circle in an outline: 1 % of the radius is cut off."""


@dataclass(frozen=True)
class Shape:
    """A shape in the frame of a link.

    Attributes:
        element: its XML, below `geometry`.
        R: from its own axes to those of the link, (3, 3).
        p: its origin in the frame of the link, (3,), m.
        mesh: the file of its mesh; None if it is no mesh.
    """

    element: ET.Element
    R: Array
    p: Array
    mesh: Path | None

    @property
    def kind(self) -> str:
        """`mesh`, `box`, `cylinder`, `sphere` or `capsule`."""
        return self.element.tag

    def length(self, key: str) -> float:
        """A length in its XML, m; 0 where there is none."""
        return float(self.element.get(key, "0"))

    def points(self) -> Array:
        """Vertices, or points that span the shape as well, (n, 3), m."""
        if self.mesh is not None:
            local = _vertices(self.mesh, numbers(self.element.get("scale", "1 1 1")))
        elif self.kind == "box":
            local = 0.5 * numbers(self.element.get("size", "0 0 0")) * _CORNERS
        else:  # the ends of a cylinder or capsule
            local = 0.5 * self.length("length") * np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
        return np.asarray(local @ self.R.T + self.p)

    def outline(self) -> Array:
        """Points whose convex hull is the shape, or that of its mesh, (n, 3), m; round ones have corners."""
        if self.kind in ("mesh", "box"):
            return self.points()
        radius = self.length("radius")
        rim = _CIRCLE @ self.R.T if self.kind == "cylinder" else _BALL
        ends = self.points() if self.kind != "sphere" else self.p[None]
        return np.concatenate([end + radius * rim for end in ends])


def _circle() -> Array:
    angle = 2.0 * np.pi * np.arange(ROUND_POINTS) / ROUND_POINTS
    return np.column_stack([np.cos(angle), np.sin(angle), np.zeros(ROUND_POINTS)])


def directions(count: int) -> Array:
    """Unit vectors all around, evenly, (count, 3)."""
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    angle = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    across = np.sqrt(1.0 - z**2)
    return np.column_stack([across * np.cos(angle), across * np.sin(angle), z])


_CIRCLE: Final = _circle()
_BALL: Final = directions(ROUND_POINTS**2 // 4)
_CORNERS: Final = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


# -- what is welded to what --


def welded(urdf: Urdf, link: str) -> dict[str, tuple[Array, Array]]:
    """All links of the rigid body of a link, with their poses in its frame."""
    top = link
    R, p = np.eye(3), np.zeros(3)
    for joint in reversed(urdf.chain(link)):
        if joint.kind != "fixed":
            break
        R_joint, p_joint = origin_of(urdf.joint_elements[joint.name])
        R, p = R_joint @ R, R_joint @ p + p_joint
        top = joint.parent
    return below(urdf, top, R.T, -R.T @ p)


def below(
    urdf: Urdf, link: str, R: Array | None = None, p: Array | None = None
) -> dict[str, tuple[Array, Array]]:
    """A link and what is welded below it, with poses in a frame in which the link's own is (R, p)."""
    poses = {link: (np.eye(3) if R is None else R, np.zeros(3) if p is None else p)}
    waiting = [link]
    while waiting:
        above = waiting.pop()
        for joint in urdf.children_of(above):
            if joint.kind == "fixed":
                R_above, p_above = poses[above]
                R_joint, p_joint = origin_of(urdf.joint_elements[joint.name])
                poses[joint.child] = (R_above @ R_joint, R_above @ p_joint + p_above)
                waiting.append(joint.child)
    return poses


def moving_origin(urdf: Urdf, link: str) -> Array:
    """The origin of the last moving joint above a link, in the link's frame."""
    R, p = np.eye(3), np.zeros(3)
    for joint in reversed(urdf.chain(link)):
        if joint.kind != "fixed":
            break
        R_joint, p_joint = origin_of(urdf.joint_elements[joint.name])
        R, p = R_joint @ R, R_joint @ p + p_joint
    return np.asarray(-R.T @ p)


def shapes_of(urdf: Urdf, poses: Mapping[str, tuple[Array, Array]], part: str) -> Iterator[Shape]:
    """The shapes of links whose meshes can be read.

    Args:
        urdf: the robot.
        poses: R and p of each link in the frame in which the shapes are wanted.
        part: `collision` or `visual`.
    """
    for link, (R, p) in poses.items():
        for element in urdf.links[link].findall(part):
            R_shape, p_shape = origin_of(element)
            for geometry in element.findall("geometry/*"):
                mesh = urdf.find_mesh(geometry.get("filename", "")) if geometry.tag == "mesh" else None
                if geometry.tag != "mesh" or (mesh is not None and _readable(mesh)):
                    yield Shape(geometry, R @ R_shape, R @ p_shape + p, mesh)


def origin_of(element: ET.Element) -> tuple[Array, Array]:
    """R (3, 3) and p (3,), m, of the `origin` in an element; identity if there is none."""
    origin = element.find("origin")
    if origin is None:
        return np.eye(3), np.zeros(3)
    turn = Rotation.from_euler("xyz", numbers(origin.get("rpy", "0 0 0")))
    return np.asarray(turn.as_matrix()), numbers(origin.get("xyz", "0 0 0"))


def numbers(text: str) -> Array:
    """The numbers in a text."""
    return np.array([float(word) for word in text.split()])


def _readable(mesh: Path) -> bool:
    return len(_vertices(mesh, np.ones(3))) > 0


def _vertices(mesh: Path, scale: Array) -> Array:
    """Vertices of a mesh file, (n, 3), m; none if it cannot be read."""
    status = mesh.stat()
    if status.st_size > MESH_BYTES_MAX:
        return np.zeros((0, 3))
    return np.asarray(_unscaled(mesh, status.st_mtime_ns) * scale)


@lru_cache(maxsize=64)
def _unscaled(mesh: Path, written: int) -> Array:
    """Vertices as a file has them that was written at this time, ns: left and right legs share theirs."""
    import coal

    try:
        loaded: Any = coal.MeshLoader().load(str(mesh))
        return np.asarray(loaded.vertices(), dtype=float).reshape(-1, 3)
    except (ValueError, RuntimeError):
        return np.zeros((0, 3))
