"""Where the whole robot can be, on a grid: feet on ground that they roll on or step over, and the belly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from rollgait.discover.refusals import BELLY, below
from rollgait.footing.footing import FEET, Array
from rollgait.robot.robot import turn_lever
from rollgait.terrain.regions import Regions

CELL: Final = 0.05
"""Of the grid on which feet are looked up, m: finer than any wheel."""
NOWHERE: Final = -2
"""In place of a region: a foot can neither stand there nor step over it."""
OVER: Final = -1
"""In place of a region: a foot can step over it."""


@dataclass(frozen=True, eq=False)
class FootGrid:
    """What the ground is for one foot, cell by cell.

    Attributes:
        low: place of the first cell, (2,), m.
        label: number of a region, `OVER` or `NOWHERE`, (nx, ny).
        room: distance to the next cell where the foot cannot stand, (nx, ny), m.
    """

    low: Array
    label: NDArray[np.intp]
    room: Array

    def with_room(self, room: float) -> FootGrid:
        """The same, but the foot stands only where it has some room (m)."""
        return replace(self, label=np.where((self.label >= 0) & (self.room < room), OVER, self.label))

    def at(self, places: Array) -> NDArray[np.intp]:
        """The labels at places (…, 2); `NOWHERE` off the grid."""
        cell = np.round((places - self.low) / CELL).astype(np.intp)
        inside = np.asarray(((cell >= 0) & (cell < self.label.shape)).all(axis=-1))
        kept = np.where(inside[..., None], cell, 0)
        return np.where(inside, self.label[kept[..., 0], kept[..., 1]], NOWHERE)


@dataclass(frozen=True, eq=False)
class Passages:
    """Where a robot can be.

    Attributes:
        feet: the ground for each foot.
        heights: of the ground, holes that one can step over filled, (nx, ny), m.
        stance: nominal places of the feet, base-yaw frame, (4, 2) or (4, 3), m.
        belly: highest ground below the base over the mean of that under the feet, m.
    """

    feet: Sequence[FootGrid]
    heights: FootHeights
    stance: Array
    belly: float

    def with_room(self, room: float) -> Passages:
        """The same, but feet stand only where they have some room (m): a grid is not exact."""
        return replace(self, feet=[foot.with_room(room) for foot in self.feet])

    def labels(self, poses: Array) -> NDArray[np.intp]:
        """Of the feet of a base at poses (…, 3): (…, 4)."""
        return np.stack([self.feet[leg].at(_seen(poses, self.stance[leg])) for leg in range(FEET)], axis=-1)

    def blocked(self, poses: Array, labels: NDArray[np.intp] | None = None) -> NDArray[np.bool_]:
        """Whether the robot cannot be at poses (…, 3), not even in the middle of a step."""
        found = self.labels(poses) if labels is None else labels
        under = self.heights.at(_seen(poses[..., None, :], self.stance)).mean(axis=-1)
        top = self.heights.at(_seen(poses[..., None, :], below(self.stance))).max(axis=-1)
        return np.asarray((found == NOWHERE).any(axis=-1) | (top - under > self.belly))


@dataclass(frozen=True, eq=False)
class FootHeights:
    """Heights on the same grid; what is not known, or off it, counts as level with the lowest."""

    low: Array
    value: Array

    def at(self, places: Array) -> Array:
        """The heights at places (…, 2), m."""
        cell = np.round((places - self.low) / CELL).astype(np.intp)
        kept = np.clip(cell, 0, np.array(self.value.shape) - 1)
        return np.asarray(self.value[kept[..., 0], kept[..., 1]])


def passages(
    regions: Sequence[Regions],
    stance: Array,
    low: Array,
    high: Array,
    *,
    rise_max: float,
    stride: float,
    height: float,
) -> Passages:
    """Where a robot can be in a window.

    Args:
        regions: of the foot of each leg.
        stance: nominal places of the feet, base-yaw frame, (4, 2) or (4, 3), m.
        low, high: corners of the window for the base, (2,), m.
        rise_max: highest step, m.
        stride: longest step, m.
        height: of the CoM over the ground, m.
    """
    reach = turn_lever(stance) + 2.0 * CELL
    low, high = low - reach, high + reach
    count = np.ceil((high - low) / CELL).astype(int) + 1
    x, y = (low[axis] + CELL * np.arange(count[axis]) for axis in range(2))
    nodes = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    raw = regions[0].terrain.height(nodes[..., 0], nodes[..., 1])
    known = ~np.isnan(raw)
    lowest = float(raw[known].min(initial=0.0)) if known.any() else 0.0
    ground = np.where(known, raw, lowest)
    size = 2 * int(np.ceil(0.5 * stride / CELL)) + 1
    filled = ndimage.grey_closing(ground, size=(size, size))
    hole = filled - ground > rise_max  # narrow and deep: one steps over it
    level = np.where(hole, filled, ground)
    jump = ndimage.maximum_filter(level, 3) - ndimage.minimum_filter(level, 3)
    wall = (jump > rise_max) | ~known
    grids: dict[int, FootGrid] = {}
    for region in regions:
        if id(region) in grids:
            continue
        labels = region.label(nodes.reshape(-1, 2)).reshape(raw.shape)
        stands = (labels >= 0) & ~hole & ~wall
        far = CELL * ndimage.distance_transform_edt(~stands) > 0.5 * stride
        labels = np.where(stands, labels, np.where(wall | far, NOWHERE, OVER))
        room = CELL * ndimage.distance_transform_edt(stands)
        grids[id(region)] = FootGrid(low, np.asarray(labels, dtype=np.intp), np.asarray(room))
    feet = [grids[id(region)] for region in regions]
    return Passages(feet, FootHeights(low, level), stance, BELLY * height)


def _seen(poses: Array, place: Array) -> Array:
    """Places (…, 2) of the base-yaw frame in the world, for poses (…, 3)."""
    c, s = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    x, y = place[..., 0], place[..., 1]
    return np.stack([poses[..., 0] + c * x - s * y, poses[..., 1] + s * x + c * y], axis=-1)
