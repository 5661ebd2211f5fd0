"""How near a robot's body comes to the ground, and its legs to one another, along a motion of its joints.

The collision shapes of the URDF count, as convex hulls. The ground is measured straight below them: beside a
riser they are as high as they are above its foot. Wheels and feet are there to touch it and are left out.
Where nobody knows the ground nothing is measured.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import Any, Final, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rollgait.robot.hulls import Hull, hulls_of
from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.terrain.terrain import Terrain

Array = NDArray[np.float64]

COARSE: Final = 0.1
"""Time between the first looks, s."""

LOOKS: Final = 4
"""How many of the nearest of them are looked at sample by sample, as far as the next looks."""

GRID: Final = 0.02
"""Distance of the places at which the highest ground around is looked for, m."""

FOOT_SHARE: Final = 1.5
"""What lies within so many radii of the centre of a point foot's ball belongs to the foot."""

FOOT_MIN: Final = 0.03
"""And what lies within this of it, m: of many feet no radius is known."""

TOUCHING: Final = 0.0
"""Shapes of two legs that are as near as this in the robot's own posture, m, are drawn too large and do not
count."""


class Nearest(NamedTuple):
    """The nearest approach of a motion.

    Attributes:
        distance: m; negative where shapes are inside one another or in the ground.
        where: link, or two links.
        time: s.
    """

    distance: float
    where: str
    time: float


class Clearances:
    """The distances of a whole body.

    Args:
        model: the whole body.
    """

    def __init__(self, model: WholeBodyModel) -> None:
        self._model = model
        self._data: Any = model.pin.createData()
        self._hulls = hulls_of(model)
        bodies = [hull for hull in self._hulls if not hull.touches]
        self._bodies = [(hull, points) for hull in bodies if len(points := self._surface(hull))]
        self._radius = max(
            (float(np.linalg.norm(hull.corners, axis=1).max()) for hull in bodies), default=0.0
        )

    def ground(self, time: Array, q: Array, terrain: Terrain) -> Nearest | None:
        """The least height of body and legs above the ground; None if no shape or no ground is known.

        Args:
            time: (n,), s.
            q: configurations, (n, nv + 1).
            terrain: the raw ground.
        """

        def look(chosen: NDArray[np.intp]) -> tuple[Array, list[str]]:
            return self._heights(q[chosen], terrain), [hull.link for hull, _ in self._bodies]

        if not self._bodies:
            return None
        found = nearest(time, look)
        return found if np.isfinite(found.distance) else None

    def legs(self, time: Array, q: Array) -> Nearest | None:
        """The least distance between shapes of two legs; None if there are none.

        Args:
            time: (n,), s.
            q: configurations, (n, nv + 1).
        """
        geometry, names = self._pairs()
        data = geometry.createData()

        def distances(configuration: Array) -> Array:
            pin.computeDistances(self._model.pin, self._data, geometry, data, configuration)
            return np.array([result.min_distance for result in data.distanceResults])

        apart = distances(self._model.posture) > TOUCHING
        if not apart.any():
            return None
        names = [name for name, counts in zip(names, apart, strict=True) if counts]

        def look(chosen: NDArray[np.intp]) -> tuple[Array, list[str]]:
            return np.array([distances(q[k])[apart] for k in chosen]), names

        return nearest(time, look)

    def _surface(self, hull: Hull) -> Array:
        """Points of a hull that must not touch the ground: not those of the ball of a point foot."""
        points = hull.surface
        if hull.leg is not None:
            leg = self._model.legs[hull.leg]
            if leg.wheel is None and hull.joint == leg.link:
                ball = max(FOOT_SHARE * leg.radius, FOOT_MIN)
                points = points[np.linalg.norm(points - leg.centre, axis=1) > ball]
        return points

    def _heights(self, q: Array, terrain: Terrain) -> Array:
        """The least height of each body's surface above the ground, (n, bodies), m.

        Infinite where another body was found to be lower: points that are higher above all ground around than
        what was found before are not looked at.
        """
        rotation, translation = self._poses(q)
        highest = self._highest_ground(translation, terrain)[:, None]
        heights, least = np.full((len(q), len(self._bodies)), np.inf), np.full((len(q), 1), np.inf)
        low = translation[..., [hull.joint for hull, _ in self._bodies], 2].mean(axis=0)
        for column in np.argsort(low):
            hull, points = self._bodies[column]
            R, p = rotation[:, hull.joint], translation[:, hull.joint]
            z = R[:, 2] @ points.T + p[:, 2:]
            row, point = np.nonzero(z - highest < least)
            if not len(row):
                continue
            world = (R[row, :2] @ points[point][..., None])[..., 0] + p[row, :2]
            above = z[row, point] - terrain.height(world[:, 0], world[:, 1])
            np.fmin.at(heights[:, column], row, above)
            least = np.minimum(least, heights[:, column, None])
        return heights

    def _highest_ground(self, translation: Array, terrain: Terrain) -> Array:
        """Height of the highest ground within reach, (n,), m, as far as a grid of `GRID` sees it."""
        xy = translation[:, 1:, :2]
        base = xy[:, 0]
        reach = float(np.linalg.norm(xy - base[:, None], axis=2).max()) + self._radius
        x, y = (
            np.arange(low, high + GRID, GRID)
            for low, high in zip(base.min(axis=0) - reach, base.max(axis=0) + reach, strict=True)
        )
        ground = terrain.height(x[:, None], y[None, :])
        ground = np.where(np.isnan(ground), -np.inf, ground)
        near_x, near_y = np.abs(x - base[:, :1]) <= reach, np.abs(y - base[:, 1:]) <= reach
        return np.array([ground[np.ix_(a, b)].max() for a, b in zip(near_x, near_y, strict=True)])

    def _poses(self, q: Array) -> tuple[Array, Array]:
        """R (n, joints, 3, 3) and p (n, joints, 3), m, of pinocchio's joints."""
        count = len(self._model.pin.parents)
        R, p = np.empty((len(q), count, 3, 3)), np.empty((len(q), count, 3))
        for k, configuration in enumerate(q):
            pin.forwardKinematics(self._model.pin, self._data, configuration)
            for joint, placement in enumerate(self._data.oMi):
                R[k, joint], p[k, joint] = placement.rotation, placement.translation
        return R, p

    def _pairs(self) -> tuple[Any, list[str]]:
        """Pinocchio's model of the pairs of shapes of two legs, and their names."""
        import coal

        geometry, names = pin.GeometryModel(), []
        legs = [hull for hull in self._hulls if hull.leg is not None]
        for number, hull in enumerate(legs):
            points = coal.StdVec_Vec3s()
            points.extend(list(hull.corners))
            shape = coal.Convex.convexHull(points, True, "Qt")
            name = f"{number} {hull.link}"
            geometry.addGeometryObject(pin.GeometryObject(name, hull.joint, pin.SE3.Identity(), shape))
        for (i, one), (k, other) in combinations(enumerate(legs), 2):
            if one.leg != other.leg:
                geometry.addCollisionPair(pin.CollisionPair(i, k))
                names.append(f"{one.link}, {other.link}")
        return geometry, names


def nearest(time: Array, look: Callable[[NDArray[np.intp]], tuple[Array, list[str]]]) -> Nearest:
    """The least of what `look` sees: at times `COARSE` apart, then at all samples about the least of them.

    Args:
        time: (n,), s.
        look: distances, (k, columns), at k samples, and the names of the columns.
    """
    step = max(1, round(COARSE / float(np.median(np.diff(time)))))
    coarse = np.unique([*range(0, len(time), step), len(time) - 1])
    least = look(coarse)[0].min(axis=1)
    near = coarse[np.argsort(least)[:LOOKS]]
    fine = np.unique(np.concatenate([np.arange(k - step + 1, k + step) for k in near]))
    fine = fine[(fine >= 0) & (fine < len(time))]
    distances, names = look(fine)
    row, column = np.unravel_index(np.argmin(distances), distances.shape)
    return Nearest(float(distances[row, column]), names[column], float(time[fine[row]]))
