"""Whether a robot can stand where a scenario puts it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rollgait.errors import InputError
from rollgait.robot.robot import LEG_NAMES
from rollgait.terrain.polygons import Array
from rollgait.terrain.regions import Regions
from rollgait.terrain.terrain import Terrain


def require_standing(regions: Sequence[Regions], feet: Array, field: str, with_margin: bool = True) -> None:
    """Checks that each foot stands on ground that is known, not too steep, and away from edges.

    Args:
        regions: of the wheel of each leg.
        feet: lowest points of the rims from above, in the order of the legs, (4, 2), m.
        field: what puts them there, e.g. `start`.
        with_margin: whether each keeps the margin from edges.

    Raises:
        InputError: a foot stands where none can; says which foot and why.
    """
    for name, region, foot in zip(LEG_NAMES, regions, feet, strict=True):
        place = foot[None]
        if (region.free(place) if with_margin else region.rollable(place))[0]:
            continue
        raise _refusal(field, name, foot, _reason(region, place))


def require_known(terrain: Terrain, feet: Array, field: str) -> None:
    """Checks that the ground is known under each foot, of which no region need be reckoned.

    Args:
        terrain: the ground.
        feet: as in `require_standing`.
        field: what puts them there.

    Raises:
        InputError: it is not; says under which foot and why.
    """
    for name, foot, known in zip(LEG_NAMES, feet, terrain.known(*feet.T), strict=True):
        if not known:
            raise _refusal(field, name, foot, _why_unknown(terrain, foot[None]))


def _refusal(field: str, leg: str, foot: Array, reason: str) -> InputError:
    place = [round(float(c), 4) for c in foot]
    return InputError(field, place, f"must not be where {leg} stands: {reason}")


def _why_unknown(terrain: Terrain, place: Array) -> str:
    off = terrain.map is not None and not terrain.map.covers(place)[0]
    return "that is off the map" if off else "the ground there is not known"


def _reason(region: Regions, place: Array) -> str:
    terrain = region.terrain
    if np.isnan(terrain.height(*place.T)[0]):
        return _why_unknown(terrain, place)
    if not region.rollable(place)[0]:
        return "the ground is too steep there, or the wheel would stand in a riser or over an edge"
    return f"it must be at least {region.margin:g} m away from edges and from unknown ground"
