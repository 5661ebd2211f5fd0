"""Which ground each foot has in each interval: its region while it stands, the way of a swing between two.

A swing that goes over something is cut into three: it rises inside the region that it leaves, is above what
lies between, and comes down inside the region where it lands. What it leaves and where it lands is decided
once, from the tracks of the feet (`route.py`); how steep the ground is there may be looked up again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from rollgait.errors import NotSolvedError
from rollgait.footing.footing import FEET, Array, SwingOver
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario.schedule import ContactSchedule, SwingPhase
from rollgait.terrain.convex_region import TOUCHING, ConvexRegion
from rollgait.terrain.regions import Regions

OVER_LEAST: Final = 2
"""Fewest intervals above what is gone over: with one alone the foot would have to be above both its borders
at the same node."""
SWING_SPEED_SHARE: Final = 0.8
"""Part of the limit of its speed at which a foot is reckoned to go over something: it rises there, too."""
OVER_CLEARANCE: Final = 0.02
"""So far above what a foot goes over it stays, m: what tracking and the ground are wrong by."""
BUMP: Final = 0.01
"""What stands out of the ground between two footholds by more than this must be gone over, m."""
ACROSS: Final = 24
"""Places along the way of a swing at which the ground is looked up."""
NEARER_MAX: Final = 0.05
"""m; a foot that a start in motion finds nearer to an edge than it may be keeps its place until it leaves, if
it is no more than this too near: as of all bounds that such a start does not keep."""
BESIDE_LOCAL: Final = 1.0e-3
"""m; where the ground of a swing's way stands so far above what its footholds' slopes let expect, it is gone
over: a foot that swings at its own clearance above these would be too low there, as at the foot of a ramp."""


@dataclass(frozen=True)
class Phase:
    """What a foot does in an interval.

    Attributes:
        region: where it stays; None if it may be anywhere.
        stance: number of the interval whose ground is its ground, if it is one of a stance near in time.
        top: height of a level plane that is its ground instead, m; NaN if there is none.
    """

    region: ConvexRegion | None
    stance: int
    top: float = float("nan")


@dataclass(frozen=True)
class Swinging:
    """How feet swing.

    Attributes:
        speed_max: limit of a foot in the air, m/s.
        clearance_over: z_fly above what it goes over, m.
        start_height: z of the feet at t = 0, for those that are in the air then, (4,), m.
    """

    speed_max: float
    clearance_over: float
    start_height: Array | None = None


@dataclass(frozen=True)
class FeetPaths:
    """Where feet are at the N + 1 nodes of a schedule.

    Attributes:
        xy: lowest points in the plane, (N + 1, 4, 2), m.
        heading: of the wheels, (N + 1, 4), rad.
        yaw: of the base, (N + 1,), rad.
    """

    xy: Array
    heading: Array
    yaw: Array


def phases_of(
    regions: Sequence[Regions], schedule: ContactSchedule, paths: FeetPaths, how: Swinging
) -> tuple[list[list[Phase]], tuple[SwingOver, ...], Array]:
    """The phases of each leg, interval by interval, how high each swing goes, and how much nearer to an edge
    each foot begins than it may be, (4,), m.

    Args:
        regions: of the foot of each leg.
        schedule: the contacts.
        paths: of the feet.
        how: limits of swings.

    Raises:
        NotSolvedError: a foot has no place to stand.
    """
    phases: list[list[Phase]] = []
    swings: list[SwingOver] = []
    nearer = np.zeros(FEET)
    for leg in range(FEET):
        own = _stances(regions[leg], schedule, paths, leg, how.start_height is not None)
        if schedule.contact[leg, 0]:
            first = own[0].region
            assert first is not None, "feet stand where they can"
            outside = -float(first.margin(paths.xy[0, leg]))
            nearer[leg] = outside if outside > TOUCHING else 0.0
        for swing in schedule.swings():
            if swing.leg == leg:
                swings.append(_add_swing(own, regions[leg], swing, paths.xy[:, leg], schedule, how))
        phases.append([own[k] for k in range(schedule.intervals)])
    return phases, tuple(swings), nearer


def _stances(
    region: Regions, schedule: ContactSchedule, paths: FeetPaths, leg: int, moving: bool
) -> dict[int, Phase]:
    """The phases of the intervals in which a foot stands; how it stands at first may come from a motion."""
    result: dict[int, Phase] = {}
    stands = schedule.contact[leg]
    borders = np.flatnonzero(np.diff(np.concatenate([[False], stands, [False]]).astype(int)))
    for begin, end in borders.reshape(-1, 2):
        path, yaw = paths.xy[begin : end + 1, leg], paths.yaw[begin:end]
        if moving and begin == 0:
            path = _off_edges(region, path)
        for k, box in enumerate(region.boxes(path, yaw)):
            if box is None:
                time = schedule.node_times[begin + k]
                place = np.round(path[k], 2).tolist()
                raise NotSolvedError(
                    f"no motion: {LEG_NAMES[leg]} would have to stand at {place} m at t = {time:.2f} s, "
                    "where it cannot: too near to an edge, too steep, or not known; a gait may step over"
                )
            result[int(begin) + k] = Phase(box, int(begin) + k)
    return result


def _off_edges(region: Regions, path: Array) -> Array:
    """The path (n, 2) of a stance; places too near to an edge are as far from it as they should be, if that
    is not far."""
    result = path.copy()
    for k in np.flatnonzero(~region.free(path)):
        free = region.nearest_free(path[k], NEARER_MAX)
        result[k] = path[k] if free is None else free
    return result


def _add_swing(
    own: dict[int, Phase],
    region: Regions,
    swing: SwingPhase,
    path: Array,
    schedule: ContactSchedule,
    how: Swinging,
) -> SwingOver:
    """Adds the phases of a swing; how high it goes."""
    begin, end = swing.lift_off, swing.touch_down
    left, lands = path[begin], path[end]
    before = own.get(begin - 1, Phase(region.box(path[begin : begin + 1]), -1))
    after = own.get(end, Phase(region.box(path[end : end + 1]), -1))
    share = np.linspace(0.0, 1.0, ACROSS)[:, None]
    way = left + share * (lands - left)
    heights = region.surface.height(*way.T)
    known = heights[~np.isnan(heights)]
    bottom, top = np.array([heights[0], heights[-1]]), known.max(initial=-np.inf)
    both = np.array([left, lands])
    boxes = (before.region, after.region)
    one_region = all(box is not None and box.contains(both).all() for box in boxes)
    if swing.begun > 0.0:
        return _go_on(own, swing, (before, after), (way, heights), schedule, how)
    over = not one_region or top > bottom.max() + BUMP or _stands_out_of_local(heights)
    assert swing.middle is not None, "only swings that have begun may be past it"
    first = last = swing.middle
    if over:
        between = ~np.logical_or.reduce([box.contains(way) for box in boxes if box is not None])
        length = between.mean() * float(np.linalg.norm(lands - left))
        first, last = _over(swing, swing.middle, length / (SWING_SPEED_SHARE * how.speed_max), schedule)
    # A swing over nothing stays in the regions of its footholds: beyond their edges there may be a riser.
    for k in range(begin, end):
        if k < first:
            own[k] = before
        elif k < last:
            own[k] = Phase(None, -1, float(top))
        else:
            own[k] = after
    return SwingOver(
        swing.leg, begin, end, float(bottom[0]), float(top), float(bottom[1]), over, how.clearance_over
    )


def _stands_out_of_local(heights: Array) -> bool:
    """Whether ground (n,) stands above the straight continuations of both its ends, each up to the middle."""
    steps, middle = np.arange(len(heights)), len(heights) // 2
    first = heights[0] + (heights[1] - heights[0]) * steps
    last = heights[-1] + (heights[-1] - heights[-2]) * (steps - steps[-1])
    local = np.where(steps < middle, first, last)
    return bool((heights - local > BESIDE_LOCAL).any())


def _go_on(
    own: dict[int, Phase],
    swing: SwingPhase,
    ends: tuple[Phase, Phase],
    ground: tuple[Array, Array],
    schedule: ContactSchedule,
    how: Swinging,
) -> SwingOver:
    """Adds what is left of a swing that has begun before t = 0; how high it goes.

    A foot that is above what is before it goes over that at once, one that still rises first rises on.

    Args:
        own: the phases of the leg.
        swing: the swing.
        ends: what it leaves, and where it lands.
        ground: places on its way, (n, 2), and heights of the ground there, (n,), m.
        schedule: the contacts.
        how: limits of swings, and how high the foot is.
    """
    (before, after), (way, heights) = ends, ground
    assert how.start_height is not None, "who knows of a swing that has begun knows where its foot is"
    assert after.region is not None, "feet land where they can stand"
    lands = float(heights[-1])
    outside = ~after.region.contains(way)
    top = float(np.nanmax(heights[outside], initial=lands))
    over = bool(outside.any())
    begin, end = swing.lift_off, swing.touch_down
    first = last = begin
    if over:
        length = outside.mean() * float(np.linalg.norm(way[-1] - way[0]))
        duration = length / (SWING_SPEED_SHARE * how.speed_max)
        if swing.middle is not None and how.start_height[swing.leg] < top + OVER_CLEARANCE:
            first, last = _over(swing, swing.middle, duration, schedule)
        else:
            past = schedule.node_times[begin] + duration
            last = int(
                np.clip(np.searchsorted(schedule.node_times, past), begin + 1, max(begin + 1, end - 1))
            )
    rises = first > begin
    for k in range(begin, end):
        above = Phase(None, -1, top)
        own[k] = before if k < first else above if k < last else after
    from_height = float(heights[0]) if rises else top if swing.middle is not None else lands
    return SwingOver(swing.leg, begin, end, from_height, top, lands, over, how.clearance_over)


def _over(swing: SwingPhase, middle: int, duration: float, schedule: ContactSchedule) -> tuple[int, int]:
    """First interval of a swing that is above what it goes over for some time (s), first one that no longer
    is."""
    wanted = max(OVER_LEAST, int(np.ceil(duration / float(schedule.lengths[middle]))) + 1)
    first = max(middle - wanted // 2, swing.lift_off + 1)
    last = min(max(first + wanted, middle + 1), swing.touch_down - 1)
    return (first, last) if first <= middle < last else (swing.lift_off, swing.touch_down)
