"""Whether the robot can stand where a scenario begins and ends, on ground that is not flat."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Final

import numpy as np

from rollgait.angles import turned
from rollgait.terrain.regions import Regions, regions_of
from rollgait.terrain.standing import require_known, require_standing
from rollgait.terrain.terrain import Terrain

if TYPE_CHECKING:
    from rollgait.scenario.scenario import Goal, LaterGoal, Scenario, Start

AROUND: Final = 0.3
"""How far around the feet a map is looked at, m: beyond the margin from edges, and little of a map."""

Window = tuple[tuple[float, float], tuple[float, float]]


def require_standing_at_ends(scenario: Scenario) -> None:
    """Checks that each foot can stand at its nominal place at the start and at the last goal.

    The goal may be missed by a little, so that margins from edges do not count there.

    Raises:
        InputError: a foot would stand off the map, on unknown ground, too steeply, in a riser or over an
            edge, or at the start too near to one.
    """
    later = scenario.goal.then
    name = f"goal.then.{len(later) - 1}" if later else "goal"
    _require(scenario, scenario.start, "start", with_margin=True)
    _require(scenario, later[-1] if later else scenario.goal, name, with_margin=False)


def _require(scenario: Scenario, place: Start | Goal | LaterGoal, field: str, with_margin: bool) -> None:
    offsets = turned(scenario.body.stance, np.radians(place.yaw_deg))[:, :2]
    feet = np.array([place.x, place.y]) + offsets
    require_known(scenario.terrain, feet, field)
    low, high = feet.min(axis=0) - AROUND, feet.max(axis=0) + AROUND
    window = (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))
    seen = None if scenario.terrain.planar else window  # planes are reckoned with as a whole
    radii = [leg.wheel_radius or 0.0 for leg in scenario.body.leg_list]
    regions = [_regions(scenario.terrain, radius, seen) for radius in radii]
    require_standing(regions, feet, field, with_margin)


@lru_cache(maxsize=4)
def _regions(terrain: Terrain, radius: float, window: Window | None) -> Regions:
    """Regions of a wheel, kept for a while: a scenario is looked at again with each value that is set."""
    return regions_of(terrain, radius, window=window)
