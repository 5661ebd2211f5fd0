"""The meshes of a whole body, with as many triangles as a picture needs, and where they are over time."""

from __future__ import annotations

import logging
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from rollgait.errors import MissingExtraError, RollgaitError
from rollgait.plan.samples import Array
from rollgait.robot.link_poses import link_poses, vector
from rollgait.robot.robot import Robot
from rollgait.robot.urdf_files import Urdf, read_urdf
from rollgait.robot.urdf_shapes import origin_of
from rollgait.robot.whole_body import WholeBody, find_whole_body
from rollgait.view import shapes
from rollgait.view.clip import Clip
from rollgait.view.rotations import wxyz

GRID = 0.014
"""Vertices within a cube of this side become one, m: few are left of a CAD model, and its edges stay."""
STIFFNESS = 1e-3
"""How strongly a new vertex is held at the mean of those it replaces, against the planes that meet there."""
COLOUR = "#A8ADB4"

log = logging.getLogger("rollgait")


@dataclass(frozen=True)
class Part:
    """A piece of the robot that moves as one: a shape and its poses, world, at the frames of a clip.

    Attributes:
        name: of its link.
        shape: vertices in m, and faces.
        leg: number of the leg of which this is the wheel, the foot, or what carries the wheel; else None.
        wheel: whether it is a wheel.
        position: (n, 3), m.
        turn: (w, x, y, z), (n, 4).
    """

    name: str
    shape: shapes.Shape
    leg: int | None
    wheel: bool
    position: Array
    turn: Array


def whole_body_of(robot: Robot) -> WholeBody | None:
    """The whole body of a robot; None if there is none, or its model is not installed."""
    try:
        return find_whole_body(robot)
    except (RollgaitError, MissingExtraError):
        return None


def parts_of(clip: Clip) -> list[Part]:
    """The pieces of the whole body of a clip; none if its joints or its meshes are not known."""
    body = whole_body_of(clip.robot)
    if clip.joints is None or body is None:
        return []
    urdf = read_urdf(body.urdf)
    joints = clip.joints
    poses = link_poses(urdf, joints.names, joints.position, joints.base_position, joints.base_quaternion)
    legs = dict(_ends_of_legs(urdf, body))
    result = []
    for name, element in urdf.links.items():
        pieces = list(_shapes_of(urdf, element))
        if pieces and name in poses:
            pose = poses[name]
            shape = shapes.joined(*pieces)
            leg, wheel = legs.get(name, (None, False))
            result.append(Part(name, shape, leg, wheel, pose.p, wxyz(pose.R)))
    return result


def _ends_of_legs(urdf: Urdf, body: WholeBody) -> Iterator[tuple[str, tuple[int, bool]]]:
    """Links at the ends of the legs, with the number of the leg and whether they are its wheel."""
    for number, (_, leg) in enumerate(body.leg_list()):
        yield leg.frame, (number, leg.wheel is not None)
        if leg.wheel is not None:
            yield urdf.chain(leg.wheel)[-1].parent, (number, False)


def _shapes_of(urdf: Urdf, link: ET.Element) -> Iterator[shapes.Shape]:
    """What a link looks like, in its own frame."""
    for visual in link.findall("visual"):
        R, p = origin_of(visual)
        geometry = visual.find("geometry")
        shape = None if geometry is None else _geometry(urdf, geometry)
        if shape is not None:
            vertices, faces = shape
            yield vertices @ R.T + p, faces


def _geometry(urdf: Urdf, geometry: ET.Element) -> shapes.Shape | None:
    for element in geometry:
        if element.tag == "mesh":
            file = urdf.find_mesh(element.get("filename", ""))
            return None if file is None else _mesh(file, tuple(_scale(element)))
        if element.tag == "sphere":
            vertices, faces = shapes.ball()
            return vertices * float(element.get("radius", "0")), faces
        if element.tag == "cylinder":
            vertices, faces = shapes.cylinder(24)
            radius, length = float(element.get("radius", "0")), float(element.get("length", "0"))
            return (vertices - [0.0, 0.0, 0.5]) * [radius, radius, length], faces
        if element.tag == "box":
            x, y, z = 0.5 * vector(element, "size")
            return shapes.prism(np.array([[x, -y], [x, y], [-x, y], [-x, -y]]), -z, z)
    return None


def _scale(element: ET.Element) -> Array:
    return vector(element, "scale", "1 1 1")


@lru_cache(maxsize=64)
def _mesh(path: Path, scale: tuple[float, float, float]) -> shapes.Shape | None:
    """A mesh file, simplified; mirrored faces are turned so that their outside stays outside.

    None if it cannot be read, which is said once: a motion can be seen without.
    """
    try:
        import trimesh
    except ImportError:
        raise MissingExtraError("showing the whole body", "view") from None
    try:
        loaded: Any = trimesh.load_mesh(path)
        if len(loaded.faces) == 0:
            raise ValueError("there is no surface in it")
    except Exception as error:  # of any of its readers, on a file that somebody else made
        log.warning("%s cannot be read and is not drawn: %s", path.name, " ".join(str(error).split())[:200])
        return None
    vertices = np.asarray(loaded.vertices, dtype=float) * np.array(scale)
    faces = np.asarray(loaded.faces)
    if np.prod(scale) < 0.0:
        faces = faces[:, ::-1]
    return simplified(vertices, faces)


def simplified(vertices: Array, faces: Any, grid: float = GRID) -> shapes.Shape:
    """The same surface with the vertices of each cell of a grid (m) put together.

    The new vertex is where it is nearest to the planes of the faces that meet in the cell, so that edges and
    corners stay where they are (Lindstrom, Out-of-core simplification of large polygonal models, 2000).
    """
    cells, number = np.unique(np.floor(vertices / grid).astype(int), axis=0, return_inverse=True)
    number = number.reshape(-1)
    counts = np.bincount(number, minlength=len(cells))[:, None]
    sums = np.stack([np.bincount(number, vertices[:, k], minlength=len(cells)) for k in range(3)], axis=1)
    means: Array = sums / counts
    merged = number[faces]
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])  # twice the area long
    A, b = np.zeros((len(cells), 3, 3)), np.zeros((len(cells), 3))
    outer = normal[:, :, None] * normal[:, None, :]
    for corner in range(3):  # every face pulls at the cells of its corners
        cell = merged[:, corner]
        height = np.einsum("ij,ij->i", normal, corners[:, 0] - means[cell])
        np.add.at(A, cell, outer)
        np.add.at(b, cell, normal * height[:, None])
    hold = STIFFNESS * np.trace(A, axis1=1, axis2=2) + np.finfo(float).tiny
    shift = np.linalg.solve(A + hold[:, None, None] * np.eye(3), b[..., None])[..., 0]
    shift = np.clip(shift, -0.5 * grid, 0.5 * grid)
    first, second, third = merged.T
    merged = merged[(first != second) & (second != third) & (third != first)]
    kept = np.unique(np.sort(merged, axis=1), axis=0, return_index=True)[1]
    return means + shift, merged[np.sort(kept)].astype(np.uint32)
