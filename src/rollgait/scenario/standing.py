"""Whether the robot can stand where a scenario puts it, on ground that is not flat."""

from __future__ import annotations

from typing import Final

import numpy as np

from rollgait.angles import turned
from rollgait.robot.robot import Robot
from rollgait.terrain.regions import regions_about
from rollgait.terrain.standing import require_known, require_standing
from rollgait.terrain.terrain import Terrain

AROUND: Final = 0.3
"""How far around the feet a map is looked at, m: beyond the margin from edges, and little of a map."""


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
    feet = np.array([x, y]) + turned(robot.stance[:, :2], np.radians(yaw_deg))
    require_known(terrain, feet, field)
    regions = regions_about(terrain, [leg.foot_radius for leg in robot.leg_list], feet, AROUND)
    require_standing(regions, feet, field, with_margin)
