"""Whether the robot can stand where a scenario puts it, on ground that is not flat."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np

from rollgait.angles import turned
from rollgait.robot.robot import Robot
from rollgait.terrain.regions import Regions, regions_of
from rollgait.terrain.standing import require_known, require_standing
from rollgait.terrain.terrain import Terrain

AROUND: Final = 0.3
"""How far around the feet a map is looked at, m: beyond the margin from edges, and little of a map."""

Window = tuple[tuple[float, float], tuple[float, float]]


def require_stance(
    terrain: Terrain, robot: Robot, pose: tuple[float, float, float], field: str, with_margin: bool
) -> None:
    """Checks that each foot can stand at its nominal place.

    Args:
        terrain: the ground.
        robot: its stance and its wheels.
        pose: x and y of the CoM, m, and yaw, degrees.
        field: what puts it there, e.g. `start`.
        with_margin: whether feet keep the margin from edges.

    Raises:
        InputError: a foot would stand off the map, on unknown ground, too steeply, in a riser or over an
            edge, or too near to one.
    """
    x, y, yaw_deg = pose
    feet = np.array([x, y]) + turned(robot.stance, np.radians(yaw_deg))[:, :2]
    require_known(terrain, feet, field)
    low, high = feet.min(axis=0) - AROUND, feet.max(axis=0) + AROUND
    window = (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))
    seen = None if terrain.planar else window  # planes are reckoned with as a whole
    regions = [_regions(terrain, leg.wheel_radius or 0.0, seen) for leg in robot.leg_list]
    require_standing(regions, feet, field, with_margin)


@lru_cache(maxsize=4)
def _regions(terrain: Terrain, radius: float, window: Window | None) -> Regions:
    """Regions of a wheel, kept for a while: a scenario is looked at again with each value that is set."""
    return regions_of(terrain, radius, window=window)
