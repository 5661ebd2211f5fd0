"""What forbids a way, in a sentence: where a foot finds no landing, by how much; where the belly touches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Final

import numpy as np

from rollgait.footing.footing import FEET, Array
from rollgait.footing.route import BaseWay, track_arcs
from rollgait.robot.robot import LEG_NAMES
from rollgait.terrain.regions import MARGIN, Regions

Refusal = Callable[[], str]
"""Why there is no way, as a sentence: made when it is asked for, as it may take a while."""
Lacking = Callable[[], float]
"""By how much something is too short, m; 0 if it is not."""

STRIDE: Final = 3.0
"""Longest way of a foot in the air, in half-lengths of its box: a whole box, and what the base goes on."""
CLIMB: Final = 0.84
"""Highest step up, in highest steps: with its reserves CENTAURO finds no way up more than 0.25 m."""
DESCENT: Final = 0.9
"""The same of a step down: CENTAURO finds a way down 0.27 m, and none down 0.28 m."""
OVER: Final = 0.8
"""The same of what goes down again behind it: 0.23 m; of 0.25 m CENTAURO found one of three."""
HURDLE: Final = 0.4
"""The same of what no foot can stand on, so that one swing leads over all of it: 0.12 m, and not 0.15 m."""
BELLY: Final = 0.45
"""So high over the mean ground under the feet nothing may stand below the base, in heights of the CoM: half
of CENTAURO's trunk hangs below its CoM, and it tilts."""
BELLY_PLACES: Final = 7
"""Places below the base along and across at which the ground is looked up."""
BELLY_EVERY: Final = 5
"""Every which place of a way is looked at: 5 cm apart."""
EDGE: Final = 0.02
"""Rises by more than this from one place to the next, 1 cm on, are edges, m."""
FINDINGS: Final = 12
"""How often an amount is halved: to less than a tenth of a millimetre."""


def landing_refusal(
    way: BaseWay,
    stance: Array,
    regions: Sequence[Regions],
    rise_max: float,
    stride: float,
    treads: Lacking = lambda: 0.0,
) -> Refusal | None:
    """Why the feet cannot get along a way; None if they can.

    Args:
        way: of the base.
        stance: nominal places of the feet, base-yaw frame, (4, 2) or (4, 3), m.
        regions: of the foot of each leg.
        rise_max: highest step, m.
        stride: longest step, m.
        treads: by how much treads on the way are too short for the robot as a whole.
    """
    for leg in range(FEET):
        track = way.foot(way.s, stance[leg])
        found = track_arcs(regions[leg], track, way.s, rise_max)
        if not len(found):
            return partial(str, f"{LEG_NAMES[leg]} cannot stand at its first place {place(track[0])} m")
        index = np.searchsorted(way.s, found - 1e-12)
        say = partial(_no_landing, leg, rise_max=rise_max, stride=stride, treads=treads)
        if found[-1, 1] < way.s[-1] - 1e-9:
            across = track[index[-1, 1] :]
            return partial(
                say, across, regions[leg], highest=_highest(across, len(across), regions[leg], rise_max)
            )
        for (_, leaves), (lands, _) in pairwise(index):
            across = track[leaves : lands + 1]
            highest = _highest(track[leaves:], len(across), regions[leg], rise_max)
            if _too_high(across, regions[leg], rise_max, highest) or _length(across) > stride:
                return partial(say, across, regions[leg], highest=highest)
    return None


def belly_refusal(
    way: BaseWay, stance: Array, regions: Sequence[Regions], rise_max: float, height: float
) -> Refusal | None:
    """Why the base cannot go along a way; None if it can.

    Args:
        way: of the base, along which the feet can get.
        stance: nominal places of the feet, base-yaw frame, (4, 2) or (4, 3), m.
        regions: of the foot of each leg.
        rise_max: highest step, m.
        height: of the CoM over the ground, m.
    """
    s = np.unique(np.append(way.s[::BELLY_EVERY], way.s[-1]))
    under = np.mean(
        [_heights_under(way, s, stance[leg], regions[leg], rise_max) for leg in range(FEET)], axis=0
    )
    places = np.stack([way.foot(s, offset) for offset in below(stance)], axis=1)
    ground = regions[0].terrain.height(places[..., 0], places[..., 1])
    over = np.nan_to_num(ground - under[:, None], nan=-np.inf)
    worst = np.unravel_index(int(np.argmax(over)), over.shape)
    excess = float(over[worst]) - BELLY * height
    if excess <= 0.0:
        return None
    return partial(
        str,
        f"the base cannot pass over {place(places[worst])} m: the ground is {over[worst]:.2f} m higher "
        f"there than under the feet, {up(excess):.2f} m more than fits below it",
    )


def _heights_under(way: BaseWay, s: Array, stance: Array, region: Regions, rise_max: float) -> Array:
    """Of the ground under a foot at progress s, (n,), m: in the air it counts as if that rose evenly."""
    found = track_arcs(region, way.foot(way.s, stance), way.s, rise_max)
    stands = ((s[:, None] >= found[:, 0] - 1e-9) & (s[:, None] <= found[:, 1] + 1e-9)).any(axis=1)
    return np.interp(s, s[stands], region.terrain.height(*way.foot(s[stands], stance).T))


def below(stance: Array) -> Array:
    """Places below the base, base-yaw frame, (n, 2), m: a grid in the rectangle of the feet."""
    low, high = 0.9 * stance[:, :2].min(axis=0), 0.9 * stance[:, :2].max(axis=0)
    x, y = (np.linspace(a, b, BELLY_PLACES) for a, b in zip(low, high, strict=True))
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def _too_high(across: Array, region: Regions, rise_max: float, highest: float) -> bool:
    heights = region.terrain.height(*across.T)
    top = np.nanmax(heights)
    return bool(
        top - heights[0] > highest
        or top - heights[-1] > rise_max
        or heights[0] - heights[-1] > DESCENT * rise_max
    )


def _highest(beyond: Array, count: int, region: Regions, rise_max: float) -> float:
    """How high over the first of some places a foot can get to the others, of which it passes so many, m."""
    heights = np.nan_to_num(region.terrain.height(*beyond.T), nan=-np.inf)
    first = int(np.argmax(heights[:count] >= heights[:count].max() - EDGE))
    lower = heights[first:] < heights[first] - EDGE
    if not lower.any():
        return CLIMB * rise_max
    top = beyond[first : first + int(np.argmax(lower))]
    return (OVER if region.free(top).any() else HURDLE) * rise_max


def _no_landing(
    leg: int,
    across: Array,
    region: Regions,
    *,
    rise_max: float,
    highest: float,
    stride: float,
    treads: Lacking,
) -> str:
    """The sentence for a foot that leaves the ground at the first of some places and finds none to land."""
    heights = region.terrain.height(*across.T)
    top = float(np.nanmax(heights) - heights[0])
    here = heights - heights[0]
    next_place = int(np.argmax(np.abs(np.nan_to_num(here, nan=np.inf)) > rise_max))
    if np.isnan(heights).any() and np.isnan(heights[: max(1, next_place + 1)]).any():
        across = across[: _known_again(heights) + 1]
        reason = "the ground there is not known"
    elif (tread := _short_tread(across, region, rise_max, stride)) is not None:
        across = across[: tread[1] + 1]
        short, whole = up(tread[0]), up(treads())
        who = "robot" if whole > short else _foot(region)
        reason = f"the tread is {100.0 * max(short, whole):.0f} cm shorter than the {who} needs"
    elif top > highest:
        does = "steps up" if highest == CLIMB * rise_max else "steps over"
        reason = f"the ground rises by {top:.2f} m there, {up(top - highest):.2f} m more than a leg {does}"
    elif (beyond := _next_level(across, region, rise_max)) is not None:
        across = across[: beyond + 1]
        reason = f"that is {up(_length(across) - stride):.2f} m more than a step"
    else:
        drop = float(-np.nanmin(here))
        more = up(drop - DESCENT * rise_max)
        reason = f"the ground falls by {drop:.2f} m there, {more:.2f} m more than a leg steps down"
    return f"no landing between {between(across)} for {LEG_NAMES[leg]}: {reason}"


def _known_again(heights: Array) -> int:
    """Number of the first known height after those that are not; of the last one if there is none."""
    known = ~np.isnan(heights)
    again = known & np.logical_or.accumulate(~known)
    return int(np.argmax(again)) if again.any() else len(heights) - 1


def _next_level(across: Array, region: Regions, rise_max: float) -> int | None:
    """Number of the first place beyond an edge that is no higher than a step; None if there is none."""
    heights = region.terrain.height(*across.T)
    here = np.nan_to_num(heights - heights[0], nan=np.inf)
    level = (here <= rise_max) & (here >= -DESCENT * rise_max)
    beyond = np.logical_or.accumulate(~region.free(across)) & level & region.free(across)
    return int(np.argmax(beyond)) if beyond.any() else None


def up(amount: float) -> float:
    """An amount as it is written, m: a centimetre is not cut off, so that what is named is enough."""
    return float(np.ceil(100.0 * amount - 1e-6)) / 100.0


def _short_tread(across: Array, region: Regions, rise_max: float, stride: float) -> tuple[float, int] | None:
    """By how much the next tread is too short, m, and the number of its last place; None if there is none."""
    step = _length(across) / max(1, len(across) - 1)
    reached = across[: max(2, min(len(across) - 1, 1 + int(stride / max(step, 1e-9))))]
    rise = region.terrain.height(*reached.T) - region.terrain.height(*across[0])
    level = (rise >= -DESCENT * rise_max) & ~np.logical_or.accumulate(rise > CLIMB * rise_max)
    level &= np.append(False, np.logical_or.accumulate(np.abs(np.diff(rise)) > EDGE))  # beyond an edge

    def passes(margin: float) -> bool:
        return bool((replace(region, margin=margin).free(reached) & level).any())

    low, high = -region.surface.radius, MARGIN
    if len(across) < 3 or not passes(low) or passes(high):
        return None
    for _ in range(FINDINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if passes(middle) else (low, middle)
    return 2.0 * (MARGIN - low), int(np.flatnonzero(level)[-1])


def _foot(region: Regions) -> str:
    return "wheel" if region.surface.radius > 0.0 else "foot"


def _length(places: Array) -> float:
    return float(np.linalg.norm(places[-1] - places[0]))


def between(places: Array) -> str:
    """From where to where, in words; along an axis where it is one."""
    a, b = places[0], places[-1]
    change = np.abs(b - a)
    for axis, name in enumerate("xy"):
        if change[1 - axis] <= 0.02 + 0.1 * change[axis]:
            return f"{name} = {a[axis]:.2f} and {b[axis]:.2f} m"
    return f"{place(a)} and {place(b)} m"


def place(at: Array) -> list[float]:
    """A place (2,) as it is written, m."""
    return [round(float(c), 2) + 0.0 for c in at]
