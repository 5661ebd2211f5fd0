"""What of a robot may touch the ground besides its feet: boxes about its trunk, spheres about its legs.

A sphere goes with the base as far as it is near the hip, with its foot as far as it is near that. How
far is fitted to inverse kinematics: the foot is moved about the stance while the base is held.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rollgait.robot.hulls import Hull, hulls_of
from rollgait.robot.robot import LEG_NAMES, Box, Shapes, Sphere
from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.robot.urdf_stance import Stance, reach

Array = NDArray[np.float64]

SLICE: Final = 0.1
"""Height of the slices into which a trunk is cut, as a share of the stance's."""
PIECES: Final = 3
"""So many spheres a shape at most: those of a slender shank that leans still touch, seen from above."""
SAMPLES: Final = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, 0.5]])
"""Directions in which feet are moved; not below the ground."""
MOVED: Final = 0.1
"""How far, as a share of the stance's height."""
REACHED: Final = 1e-4
"""Error with which a place counts as reached, m or rad."""
BESIDE: Final = 0.01
"""A slice that stands out of a lower one by no more than this needs no box of its own, m."""
WITH_BASE: Final = 0.5
"""What goes with the base by less than this is left out: shanks. Beside a step they would be centimetres off
what two shares say as a leg bends, and forbid what they never touch."""
ROOT: Final = 1
"""Pinocchio's joint of the base."""


def find_underside(model: WholeBodyModel, stance: Stance) -> Shapes:
    """The shapes of a robot that must not touch the ground; none where the URDF has no collision shapes.

    Arms and heads are left out: they are where somebody holds them.
    """
    hulls = [hull for hull in hulls_of(model) if not hull.touches]
    com, height = stance.state.p_com, float(-stance.feet[:, 2].mean())
    rest = _joints(model, stance.q)
    moved = _moved(model, stance, height)
    belly: list[Box] = []
    trunk = [_points(hull, rest) - com for hull in hulls if hull.joint == ROOT]
    if trunk:
        belly = _uncovered([_box(points) for points in _sliced(np.vstack(trunk), SLICE * height)])
    limbs: list[Sphere] = []
    for leg, name in enumerate(LEG_NAMES):
        for hull in (hull for hull in hulls if hull.leg == leg):
            R, p = rest[hull.joint]
            for place, radius in _spheres(hull.surface):
                share = _share(place, hull.joint, rest, moved[leg])
                centre = R @ place + p - com
                hidden = any(_inside(centre, radius, box) for box in belly)
                if share >= WITH_BASE and not hidden:
                    x, y, z = (round(float(v), 3) for v in centre)
                    limbs.append(Sphere(leg=name, centre=(x, y, z), radius=round(radius, 3), with_base=share))
    return Shapes(belly=tuple(belly), limbs=tuple(limbs))


def _spheres(points: Array) -> list[tuple[Array, float]]:
    """Centres (3,) and radii, m, of spheres about pieces of a shape, cut across its longest axis.

    A piece is about as long as the shape is thick; its sphere holds all that it has across the axis, and so
    does not hold the rims at the ends of the shape.
    """
    middle = points.mean(axis=0)
    axes = np.linalg.svd(points - middle, full_matrices=False)[2]
    own = (points - middle) @ axes.T
    low, size = own.min(axis=0), np.ptp(own, axis=0)
    count = int(np.clip(round(float(size[0] / size[1:].max())), 1, PIECES))
    number = np.minimum(((own[:, 0] - low[0]) * count / size[0]).astype(int), count - 1)
    found = []
    for piece in range(count):
        across = own[number == piece, 1:]
        if not len(across):
            continue
        centre = 0.5 * (across.min(axis=0) + across.max(axis=0))
        along = low[0] + (piece + 0.5) * size[0] / count
        radius = float(np.linalg.norm(across - centre, axis=1).max())
        found.append((middle + np.array([along, *centre]) @ axes, radius))
    return found


def _sliced(points: Array, thickness: float) -> list[Array]:
    """The points (n, 3) of each slice."""
    slices = np.floor((points[:, 2] - points[:, 2].min()) / thickness)
    return [points[slices == number] for number in np.unique(slices)]


def _uncovered(boxes: list[Box]) -> list[Box]:
    return [box for box in boxes if not any(_covers(other, box) for other in boxes)]


def _points(hull: Hull, joints: list[tuple[Array, Array]]) -> Array:
    R, p = joints[hull.joint]
    return np.asarray(hull.surface @ R.T + p)


def _joints(model: WholeBodyModel, q: Array) -> list[tuple[Array, Array]]:
    """Rotation and place of each of pinocchio's joints."""
    data: Any = model.pin.createData()
    pin.forwardKinematics(model.pin, data, q)
    return [(np.array(M.rotation), np.array(M.translation)) for M in data.oMi]


def _moved(
    model: WholeBodyModel, stance: Stance, height: float
) -> list[list[tuple[Array, list[tuple[Array, Array]]]]]:
    """For each leg: by how much its foot was moved, and the joints then."""
    result: list[list[tuple[Array, list[tuple[Array, Array]]]]] = [[] for _ in LEG_NAMES]
    for direction in SAMPLES:
        offset = MOVED * height * direction
        state, errors = reach(model, stance.q, lambda _, by=offset: stance.state.p_foot + by)  # type: ignore[misc]
        joints = _joints(model, state.q)
        for leg in range(len(LEG_NAMES)):
            if errors[leg] < REACHED:
                result[leg].append((offset, joints))
    return result


def _share(
    point: Array,
    joint: int,
    rest: list[tuple[Array, Array]],
    moved: list[tuple[Array, list[tuple[Array, Array]]]],
) -> float:
    """How much of a point fixed to a joint goes with the base, 0 … 1: least squares over moved feet."""
    R, p = rest[joint]
    at_rest = R @ point + p
    along = squares = 0.0
    for offset, joints in moved:
        R, p = joints[joint]
        along += float((R @ point + p - at_rest) @ offset)
        squares += float(offset @ offset)
    return round(float(np.clip(1.0 - along / squares, 0.0, 1.0)), 2) if squares else 1.0


def _box(points: Array) -> Box:
    low, high = points.min(axis=0), points.max(axis=0)
    x, y = ((round(float(low[i]), 3), round(float(high[i]), 3)) for i in range(2))
    return Box(x=x, y=y, z=round(float(low[2]), 3))


def _inside(centre: Array, radius: float, box: Box) -> bool:
    """Whether a sphere has a box of the trunk below all of it."""
    x, y, z = centre
    return bool(
        z - radius >= box.z
        and box.x[0] <= x - radius
        and x + radius <= box.x[1]
        and box.y[0] <= y - radius
        and y + radius <= box.y[1]
    )


def _covers(lower: Box, upper: Box) -> bool:
    """Whether a box has another one below all of it."""
    if lower is upper or lower.z > upper.z or (lower.z == upper.z and lower == upper):
        return False
    return all(
        a[0] <= b[0] + BESIDE and a[1] >= b[1] - BESIDE for a, b in ((lower.x, upper.x), (lower.y, upper.y))
    )
