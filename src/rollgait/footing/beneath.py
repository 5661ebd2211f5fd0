"""The ground that body and legs must not touch: which points come near it when, and which way out.

Points lie under the boxes of a robot's trunk and the spheres of its legs (`Robot.underside`). A point goes
with the base by a share and with its foot by the rest: q = w (r + R c) + (1 − w) (p + Rz (c − p̄)), with c its
place from the CoM in the nominal stance. What stands near a point decides on the half-space n · q ≥ b in
which it has to stay: above the ground around it or, where that is too high to be risen above, beside it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.step import rotations
from rollgait.footing.footing import FEET, Array
from rollgait.robot.robot import LEG_NAMES, Box, Robot, Sphere

if TYPE_CHECKING:
    from rollgait.terrain.terrain import Terrain

Mask = NDArray[np.bool_]

SPACING: Final = 0.08
"""Distance of the points of a box, m."""
LIMBS: Final = 0.01
"""Legs stay off the ground by no more than this, m: their spheres are drawn large."""
RINGS: Final = (0.6, 1.0)
"""Radii of the rings of points under a sphere, in radii of that."""
AROUND: Final = 6
"""Points of a ring."""
CELL: Final = 0.03
"""Of the grid on which the ground is looked up, m."""
WINDOW: Final = 2
"""So many cells beside a point its ground counts: half the spacing, and what a motion is beside what is
expected."""
NEAR: Final = 0.08
"""What is farther from the ground than this beyond what is asked does not touch it, m: the base is no higher
or lower in the solved motion than in the expected one by more."""
LOWER: Final = 0.02
"""What is no nearer to the ground than in the nominal stance, less this, is left out, m: a shank by its
foot."""
ROWS: Final = 2
"""Points of each leg's share of the robot that are looked after in an interval: the one for which the base
has to rise most, and the one that has to go farthest to the side."""
RISE: Final = 0.1
"""A base may rise by so much to keep a point off the ground, in heights of the CoM: legs are not much
longer. What would need more goes beside."""
RIGID: Final = 0.9
"""What goes with the base by less than this does not go beside anything: where it is to the side is not known
well enough, as legs bend."""
BESIDE: Final = 0.02
"""A point that must stay beside something keeps so far from it, m."""
SEARCHED: Final = 0.3
"""So far around a point a way out to the side is looked for, m."""
DIRECTIONS: Final = 16
"""In so many directions if it stands still."""
STEP: Final = 0.01
"""At places so far from one another, m. What moves less from one node to the one after the next stands."""
NUMBERS: Final = 10
"""Of a row: w, w c, (1 − w) (c − p̄), n."""


@dataclass(frozen=True, eq=False)
class BodyPath:
    """Where a robot is at the N + 1 nodes of a schedule.

    Attributes:
        com: r, (N + 1, 3), m.
        euler: yaw, pitch, roll, (N + 1, 3), rad.
        feet: lowest points, (N + 1, 4, 3), m.
    """

    com: Array
    euler: Array
    feet: Array


@dataclass(frozen=True, eq=False)
class Underside:
    """Points of a robot that must not touch the ground.

    Attributes:
        place: c, from the CoM in the nominal stance, base frame, (n, 3), m.
        with_base: w, (n,).
        leg: whose foot each follows, or which is nearest to it, (n,).
        stance: p̄ of that foot, (n, 3), m.
        height: above level ground in the nominal stance, (n,), m.
        is_trunk: whether a point is one of the trunk, not of a leg, (n,).
    """

    place: Array
    with_base: Array
    leg: NDArray[np.intp]
    stance: Array
    height: Array
    is_trunk: NDArray[np.bool_]

    @classmethod
    def of(cls, robot: Robot) -> Underside:
        """The points of a robot; none where nothing is known of its shapes."""
        belly = [_under_box(box) for box in robot.underside.belly]
        limbs = [_under_sphere(sphere) for sphere in robot.underside.limbs]
        place = np.vstack([np.zeros((0, 3)), *belly, *limbs])
        trunk, counts = sum(map(len, belly)), [len(points) for points in limbs]
        leg, share = np.zeros(len(place), dtype=np.intp), np.ones(len(place))
        leg[:trunk] = np.linalg.norm(place[:trunk, None, :2] - robot.stance[:, :2], axis=-1).argmin(axis=1)
        leg[trunk:] = np.repeat([LEG_NAMES.index(s.leg) for s in robot.underside.limbs], counts)
        share[trunk:] = np.repeat([s.with_base for s in robot.underside.limbs], counts)
        return cls(
            place, share, leg, robot.stance[leg], place[:, 2] + robot.height, np.arange(len(place)) < trunk
        )

    def asked(self, clearance: float) -> Array:
        """How far from the ground each point must stay, (n,), m."""
        return np.asarray(np.where(self.is_trunk, clearance, min(clearance, LIMBS)))

    @cached_property
    def arms(self) -> tuple[Array, Array]:
        """w c, which turns with the base, and (1 − w) (c − p̄), which stays upright: (n, 3) each, m."""
        w = self.with_base[:, None]
        return w * self.place, (1.0 - w) * (self.place - self.stance)

    def at(self, path: BodyPath) -> Array:
        """Where the points are, (N + 1, n, 3), m."""
        with_base, with_foot = self.arms
        level = np.zeros_like(path.euler)
        level[:, 0] = path.euler[:, 0]
        w = self.with_base[:, None]
        return np.asarray(
            w * path.com[:, None]
            + (1.0 - w) * path.feet[:, self.leg]
            + with_base @ rotations(path.euler).swapaxes(-1, -2)
            + with_foot @ rotations(level).swapaxes(-1, -2)
        )


@dataclass(frozen=True, eq=False)
class Beneath:
    """Half-spaces n · q ≥ b of the points that come near the ground, by leg and interval.

    Attributes:
        numbers: w, w c, (1 − w) (c − p̄), n of each row, (4, N, `ROWS`, `NUMBERS`).
        bound: b, (4, N, `ROWS`), m; −∞ where there is no row.
    """

    numbers: Array
    bound: Array

    @classmethod
    def nothing(cls, count: int) -> Beneath:
        """Nothing is near in N intervals."""
        return cls(np.zeros((FEET, count, ROWS, NUMBERS)), np.full((FEET, count, ROWS), -np.inf))

    @property
    def near(self) -> Mask:
        """In which intervals of each leg there is a row, (4, N)."""
        return np.asarray(np.isfinite(self.bound).any(axis=-1))


def beneath(underside: Underside, terrain: Terrain, path: BodyPath, clearance: float) -> Beneath:
    """What comes near the ground in a motion that goes along a path.

    Args:
        underside: the points.
        terrain: the raw ground.
        path: where the robot is expected.
        clearance: how far points must stay from the ground, m.
    """
    count = len(path.com) - 1
    result = Beneath.nothing(count)
    if not len(underside.place):
        return result
    q = underside.at(path)
    asked = underside.asked(clearance)
    lacking = asked - (q[..., 2] - _highest(terrain, q))
    nominal = asked - underside.height + LOWER
    near = (lacking > -NEAR) & (lacking > nominal)
    near[0] = False  # the robot is where it is at the start
    for node, leg in np.argwhere(
        np.stack([near[:, underside.leg == leg].any(axis=1) for leg in range(FEET)], 1)
    ):
        k = min(int(node), count - 1)
        if node == count and np.isfinite(result.bound[leg, k]).any():
            continue  # the last interval keeps to what holds at its beginning
        points = np.flatnonzero(near[node] & (underside.leg == leg))
        moves = q[min(node + 1, count), :, :2] - q[max(node - 1, 0), :, :2]
        found = [
            (p, _way_out(underside, terrain, q[node, p], moves[p], lacking[node, p], p, asked[p]))
            for p in points.tolist()
        ]
        ways = [(p, way) for p, way in found if way is not None]
        for row, kind in enumerate((True, False)):
            own = [(p, way) for p, way in ways if way.is_up is kind]
            if not own:
                continue
            point, way = max(own, key=lambda pair: pair[1].needed)
            with_base, with_foot = (arm[point] for arm in underside.arms)
            result.numbers[leg, k, row] = [underside.with_base[point], *with_base, *with_foot, *way.normal]
            result.bound[leg, k, row] = way.bound
    return result


@dataclass(frozen=True)
class _Way:
    """A half-space n · q ≥ b in which a point is to stay, and by how much it or the base must move, m."""

    normal: tuple[float, float, float]
    bound: float
    needed: float

    @property
    def is_up(self) -> bool:
        return self.normal[2] > 0.0


def _way_out(
    underside: Underside, terrain: Terrain, q: Array, moves: Array, lacking: float, point: int, asked: float
) -> _Way | None:
    """The way off the ground for a point at q, (3,), that is too low for it by `lacking`, m; None if unknown.

    Up if the base can rise so far, else to the side. A point that moves has things beside it, not ahead or
    behind: a line across its way would tell it when to be where. One that is beside already need not go
    farther away.
    """
    w = float(underside.with_base[point])
    up = _Way((0.0, 0.0, 1.0), float(q[2] + lacking), lacking / w)
    if up.needed <= max(0.0, -RISE * float(underside.stance[point, 2])):
        return up
    if w < RIGID:
        return None
    length = float(np.linalg.norm(moves))
    if length > STEP:
        x, y = moves / length
        around = np.array([[-y, x], [y, -x]])
    else:
        angle = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
        around = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    far = STEP * np.arange(round(SEARCHED / STEP) + 1)
    places = q[:2] + far[:, None, None] * around
    ground = terrain.height(places[..., 0], places[..., 1])
    free = ~(np.nan_to_num(ground, nan=-np.inf) > q[2] - asked)
    is_free = bool(free[0, 0])
    first = np.where((free != is_free).any(axis=0), (free != is_free).argmax(axis=0), len(far))
    best = int(first.argmin())
    if first[best] == len(far):  # no border within reach: only a trunk is lifted by what it has below it
        return up if not is_free and w == 1.0 else None
    x, y = -around[best] if is_free else around[best]
    beside = min(BESIDE, far[first[best] - 1]) if is_free else BESIDE
    border = q[:2] + far[first[best] - is_free] * around[best]
    bound = float(x * border[0] + y * border[1]) + beside
    return _Way((float(x), float(y), 0.0), bound, bound - float(x * q[0] + y * q[1]))


def _highest(terrain: Terrain, q: Array) -> Array:
    """The highest ground about points (N + 1, n, 3), from the node before to that after, (N + 1, n), m.

    Looked up once, on a grid: points are many, and one passes where another was.
    """
    low = q[..., :2].min(axis=(0, 1)) - WINDOW * CELL
    cell = np.rint((q[..., :2] - low) / CELL).astype(int)
    x, y = (low[axis] + CELL * np.arange(cell[..., axis].max() + WINDOW + 1) for axis in range(2))
    ground = terrain.height(x[:, None], y[None, :])
    ground = np.pad(np.nan_to_num(ground, nan=-np.inf), WINDOW, constant_values=-np.inf)
    for axis in range(2):
        shifted = [np.roll(ground, by, axis) for by in range(-WINDOW, WINDOW + 1)]
        ground = np.max(shifted, axis=0)
    found = ground[cell[..., 0] + WINDOW, cell[..., 1] + WINDOW]
    highest = found.copy()
    highest[1:] = np.maximum(highest[1:], found[:-1])
    highest[:-1] = np.maximum(highest[:-1], found[1:])
    return np.asarray(highest)


def _under_box(box: Box) -> Array:
    x, y = (np.linspace(a, b, max(2, int(np.ceil((b - a) / SPACING)) + 1)) for a, b in (box.x, box.y))
    xy = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return np.column_stack([xy, np.full(len(xy), box.z)])


def _under_sphere(sphere: Sphere) -> Array:
    """Its lowest point, and rings on its lower half."""
    angle = 2.0 * np.pi * np.arange(AROUND) / AROUND
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(AROUND)])
    rings = [share * ring - [0.0, 0.0, np.sqrt(1.0 - share**2)] for share in RINGS]
    return np.asarray(sphere.centre + sphere.radius * np.vstack([[0.0, 0.0, -1.0], *rings]))
