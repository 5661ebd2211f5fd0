"""The collision shapes of a whole body as convex hulls, each fixed to a joint of the model."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from rollgait.robot.urdf_model import BASE_V, WholeBodyModel
from rollgait.robot.urdf_shapes import directions, shapes_of

Array = NDArray[np.float64]

CORNERS_MAX: Final = 160
"""Most corners of a hull: the farthest points in so many directions all around, 16 degrees apart. That cuts
2 % of the radius off a ball. The library for distances refuses hulls of many more."""

SPACING: Final = 0.02
"""About the distance of sample points on a hull, m: a corner of ground is seen when it is half as deep."""


@dataclass(frozen=True)
class Hull:
    """The convex hull of a collision shape.

    Attributes:
        link: name of its link in the URDF.
        joint: number of pinocchio's joint that carries it.
        leg: number of its leg; None if it belongs to none.
        touches: whether it is there to touch the ground: a wheel, or what hangs below its joint.
        corners: in the frame of the joint, (n, 3), m.
    """

    link: str
    joint: int
    leg: int | None
    touches: bool
    corners: Array

    @cached_property
    def surface(self) -> Array:
        """Points on it, about `SPACING` from each other, (n, 3), m."""
        triangles = self.corners[ConvexHull(self.corners).simplices]
        sides = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2)
        parts = np.maximum(1, np.ceil(sides.max(axis=1) / SPACING)).astype(int)
        points = [_grid(count) @ triangles[parts == count] for count in np.unique(parts)]
        return _thinned(np.concatenate([self.corners, *(found.reshape(-1, 3) for found in points)]))


def hulls_of(model: WholeBodyModel) -> tuple[Hull, ...]:
    """Hulls of all collision shapes that have a volume; none where the URDF has no such shapes."""
    owners = _owners(model)
    result = []
    for frame in model.pin.frames:
        if frame.name not in model.urdf.links or str(frame.type) != "BODY":
            continue
        pose = (np.array(frame.placement.rotation), np.array(frame.placement.translation))
        leg, touches = owners[frame.parentJoint]
        for shape in shapes_of(model.urdf, {frame.name: pose}, "collision"):
            corners = _corners(shape.outline())
            if corners is not None:
                result.append(Hull(frame.name, int(frame.parentJoint), leg, touches, corners))
    return tuple(result)


def _owners(model: WholeBodyModel) -> list[tuple[int | None, bool]]:
    """For each joint of pinocchio's, the leg that it belongs to, and whether it is a wheel's or below one."""
    own: dict[int, tuple[int | None, bool]] = {}
    for number, leg in enumerate(model.legs):
        for v in leg.joints:
            own[_joint(model, v)] = (number, False)
        if leg.wheel is not None:
            own[_joint(model, leg.wheel)] = (number, True)
    result: list[tuple[int | None, bool]] = [(None, False)]
    for joint in range(1, len(model.pin.parents)):
        result.append(own.get(joint, result[model.pin.parents[joint]]))
    return result


def _joint(model: WholeBodyModel, v: int) -> int:
    return int(model.pin.getJointId(model.joint_names[v - BASE_V]))


def _corners(points: Array) -> Array | None:
    """Corners of their hull, at most `CORNERS_MAX`; None if they have no volume."""
    if len(points) > CORNERS_MAX:
        points = points[np.unique(np.argmax(directions(CORNERS_MAX) @ points.T, axis=1))]
    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except (QhullError, ValueError, IndexError):
        return None


def _grid(count: int) -> Array:
    """Weights of the corners of a triangle at points that part its sides in `count`, (n, 3)."""
    i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1))
    inside = i + j <= count
    a, b = i[inside] / count, j[inside] / count
    return np.column_stack([a, b, 1.0 - a - b])


def _thinned(points: Array) -> Array:
    """One point, the first, of each cell of side `SPACING`."""
    cells = np.floor((points - points.min(axis=0)) / SPACING).astype(int)
    number = np.ravel_multi_index(tuple(cells.T), tuple(cells.max(axis=0) + 1))
    return np.asarray(points[np.sort(np.unique(number, return_index=True)[1])])
