"""Whether a robot can stand where a scenario puts it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rollgait.errors import InputError
from rollgait.robot.robot import LEG_NAMES
from rollgait.terrain.polygons import Array
from rollgait.terrain.regions import Regions


def require_standing(regions: Sequence[Regions], feet: Array, field: str) -> None:
    """Checks that each foot stands on ground that is known, not too steep, and away from edges.

    Args:
        regions: of the wheel of each leg.
        feet: lowest points of the rims from above, in the order of the legs, (4, 2), m.
        field: what puts them there, e.g. `start`.

    Raises:
        InputError: a foot stands where none can; says which foot and why.
    """
    for name, region, foot in zip(LEG_NAMES, regions, feet, strict=True):
        place = foot[None]
        if region.free(place)[0]:
            continue
        raise InputError(
            field,
            [round(float(c), 4) for c in foot],
            f"must not be where {name} stands: {_reason(region, place)}",
        )


def _reason(region: Regions, place: Array) -> str:
    terrain = region.terrain
    if np.isnan(terrain.height(*place.T)[0]):
        raster = terrain.map
        off = raster is not None and not raster.covers(place)[0]
        return "that is off the map" if off else "the ground there is not known"
    if not region.rollable(place)[0]:
        return "the ground is too steep there, or the wheel would stand in a riser or over an edge"
    return f"it must be at least {region.margin:g} m away from edges and from unknown ground"
