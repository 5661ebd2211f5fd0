"""A base that is carried to its goals, and its feet in their boxes until they step.

Of a foot counts where it is in its box: e = Rz(yaw)ᵀ (p − r) − p̄ in x and y. A point foot stands still. A
fixed wheel rolls until it is abreast of its nominal place; what is left is its distance across its heading,
and that changes as the nominal place moves across it, wherever the wheel is. A steerable wheel follows.

On ground that is not flat the track of a foot, its nominal place on the way of the base, lies on ground where
it can stand here and there: its arcs. A point foot stands at a place of an arc; a wheel rolls abreast of the
base within one and waits at its end. A foot gets from arc to arc by a step.

Fixed wheels turn or go sideways by stepping only, but roll forwards for nothing, and who turns by stepping
may go sideways meanwhile, half the way from axle to axle per radian. So ways differ in where they turn.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.footing.footing import FEET, Array, Index
from rollgait.footing.pace import goal_times, poses_of, ramped
from rollgait.robot.robot import Robot, turn_lever
from rollgait.scenario.scenario import Scenario

STEP: Final = 0.02
"""s, between two places of a way."""
SPEED: Final = 0.5
"""m/s; of the base at most."""
SPEED_OF_WHEELS: Final = 0.6
"""The same in parts of the top speed of the slowest foot: a wheel that has stepped has to catch up."""
NOTHING: Final = 1e-6
"""m; a shorter way is none."""
RAMP: Final = 1.0
"""s, in which the base takes up its speed, and in which it comes to rest, where the way is long enough."""
REACH: Final = 0.75
"""Part of the box in which feet are used: the rest is for the base, which moves over the feet that stand."""
WIDER_REACH: Final = 0.95
"""The same where an edge asks for more."""
REACH_OF_HEIGHT: Final = 0.28
"""The most that this is, in heights of the CoM: longer steps take longer than the usual swing."""
HEADINGS: Final = 36
"""Yaws to each side, over a quarter turn, at which it is tried to drive."""
WAY_OF_EFFORT: Final = 0.1
"""How much turns count even where they are for nothing: of two ways as good, that which turns less."""
WORTH: Final = 1.1
"""A way that turns elsewhere than the direct one is looked at if that has so many times its effort."""
LAND: Final = 0.25
"""Utility with which a foot lands at least: so far before its nominal place it may be."""
LAND_LAST: Final = 0.1
"""The same of its last step, which ends at its place below the goal."""
SETTLED: Final = 0.9
"""Utility at the end with which a foot that has stepped need not step again: landing places can be moved."""
AHEAD: Final = 3.0
"""s of the way: by so much before its nominal place a foot lands at most."""


ArcsOf = Callable[[Array], Sequence[Index]]
"""From tracks of the feet, (n, 4, 2), m, to the numbers of the first and last place of each of their arcs,
(m, 2) for each foot; the first arc begins with the track."""


@dataclass(frozen=True)
class Carried:
    """A base on its way, as fast as it may go, and its feet.

    Attributes:
        base: x, y, yaw every `STEP` s, (n, 3), m and rad.
        reached: when each goal is, (g,), s.
        begins: from when on the base may go to each goal, (g,), s of the motion.
        nominal: places of the feet in the plane, (n, 4, 2), m.
        sideways: how far the nominal place of each foot has come across the heading of its wheel, (n, 4), m.
        robot: whose feet they are.
        box: how far feet are used behind and to the right of their nominal places, and before and to the left
            of them, (4, 2, 2), m.
        arcs: where the tracks of the feet lie on ground where these can stand: numbers of the first and the
            last place of each arc, (m, 2) for each foot.
    """

    base: Array
    reached: Array
    begins: Array
    nominal: Array
    sideways: Array
    robot: Robot
    box: Array
    arcs: Sequence[Index]

    @classmethod
    def through(
        cls,
        legs: Sequence[Array],
        scenario: Scenario,
        arcs_of: ArcsOf | None = None,
        begins: Sequence[float] | None = None,
        reach: float = REACH,
    ) -> Carried:
        """Straight from pose to pose, at rest at each.

        Args:
            legs: of the way, one to each goal: x, y, yaw, (m, 3), m and rad, from where the one before ends.
            scenario: with its robot.
            arcs_of: finds the arcs of tracks; all of them can be stood on if not given.
            begins: from when on the base may go along each part, s; as the scenario's goals say if not given.
            reach: part of the box in which feet are used.
        """
        robot = scenario.body
        speed = min(SPEED, SPEED_OF_WHEELS * min(scenario.speed_max(leg) for leg in range(FEET)))
        parts, count, reached = [legs[0][:1]], 0, []
        for leg in legs:
            for a, b in pairwise(leg):
                shares = _shares(
                    float(np.hypot(*(b - a)[:2]) + turn_lever(robot.stance) * abs(b[2] - a[2])), speed
                )
                parts.append(a + shares[:, None] * (b - a))
                count += len(shares)
            reached.append(count * STEP)
        base = np.vstack(parts)
        c, s = np.cos(base[:, 2:]), np.sin(base[:, 2:])
        x, y = robot.stance[:, 0], robot.stance[:, 1]
        nominal = np.stack([base[:, :1] + c * x - s * y, base[:, 1:2] + s * x + c * y], axis=-1)
        heading = base[:, 2:] + np.array([leg.heading for leg in robot.leg_list])
        middle, moved = 0.5 * (heading[1:] + heading[:-1]), np.diff(nominal, axis=0)
        across = moved[..., 1] * np.cos(middle) - moved[..., 0] * np.sin(middle)
        sideways = np.vstack([np.zeros(FEET), np.cumsum(across, axis=0)])
        used = used_boxes(robot, scenario.bounds.box, reach)
        begins = goal_times(scenario) if begins is None else begins
        arcs = [np.array([[0, len(base) - 1]])] * FEET if arcs_of is None else arcs_of(nominal)
        return cls(base, np.array(reached), np.array(begins), nominal, sideways, robot, used, arcs)

    @property
    def duration(self) -> float:
        """Of the whole way, s."""
        return STEP * (len(self.base) - 1)

    def index(self, time: float) -> int:
        """Number of the place at a time (s) of the way, the last one after its end."""
        return min(int(time / STEP + 0.5), len(self.base) - 1)

    def open_until(self, time: float) -> float:
        """How far the base may be at a time (s) of the motion, s of the way: later goals begin later."""
        return float(self.reached[np.searchsorted(self.begins, time + 1e-9, side="right") - 1])

    def there_at(self, place: float, time: float, gone: float) -> float:
        """When the base gets to a place (s of the way) at the earliest, s of the motion."""
        result = time + place - gone
        for begin, before in zip(self.begins[1:], self.reached[:-1], strict=True):
            if before < place:
                result = max(result, begin + place - max(before, gone))
        return float(result)

    def arc_of(self, leg: int, at: int) -> int:
        """Number of the arc in which a place of the track lies, or of the last one before it."""
        return max(0, int(np.searchsorted(self.arcs[leg][:, 0], at, side="right")) - 1)

    def stands(self, leg: int, first: int, last: int) -> NDArray[np.bool_]:
        """At which places of the track, from the first up to before the last, a foot can stand."""
        number = np.arange(first, last)
        which = np.searchsorted(self.arcs[leg][:, 0], number, side="right") - 1
        return np.asarray((which >= 0) & (number <= self.arcs[leg][which, 1]))

    def offsets(self, leg: int, nominal_at: int | slice, at: int | slice, arc: int = 0) -> Array:
        """Places in its box, (n, 2), m, base-yaw axes, of a foot that does not step.

        Args:
            leg: 0 … 3.
            nominal_at: numbers of the places of the way at which it is, or was, or will be nominal.
            at: numbers of those at which this is asked; one of both is a single one.
            arc: in which a wheel rolls, and at whose ends it waits.
        """
        data = self.robot.leg_list[leg]
        if data.foot == "point":
            return self._seen(leg, self.nominal[nominal_at, leg], at)
        across = np.zeros(max(np.size(self.base[nominal_at, 0]), np.size(self.base[at, 0])))
        if data.foot == "fixed":
            across = self.sideways[nominal_at, leg] - self.sideways[at, leg]
        aside = np.stack([-np.sin(data.heading) * across, np.cos(data.heading) * across], axis=-1)
        if len(self.arcs[leg]) == 1:
            return aside
        waits_at = np.clip(np.arange(len(self.base))[at], *self.arcs[leg][arc])
        return aside + self._seen(leg, self.nominal[waits_at, leg], at)

    def _seen(self, leg: int, places: Array, at: int | slice) -> Array:
        """Places less the nominal ones of a foot, (n, 2), m, in base-yaw axes."""
        x, y = (places - self.nominal[at, leg]).T
        c, s = np.cos(self.base[at, 2]), np.sin(self.base[at, 2])
        return np.stack([c * x + s * y, c * y - s * x], axis=-1)

    def utility(self, leg: int, nominal_at: int | slice, at: int | slice, arc: int = 0) -> Array:
        """1 where a foot is nominal, 0 at the border of what it uses of its box, less beyond, (n,)."""
        return utility_of(self.offsets(leg, nominal_at, at, arc), self.box[leg])

    @property
    def effort(self) -> float:
        """How many times all feet together would cross half of their boxes."""
        result = 0.0
        for leg, data in enumerate(self.robot.leg_list):
            box = self.box[leg].mean(axis=0)
            if data.foot == "fixed":
                across = np.array([np.sin(data.heading), np.cos(data.heading)]) / box
                result += np.linalg.norm(across) * np.abs(np.diff(self.sideways[:, leg])).sum()
            elif data.foot == "point":
                x, y = np.diff(self.nominal[:, leg], axis=0).T
                c, s = np.cos(self.base[1:, 2]), np.sin(self.base[1:, 2])
                result += np.hypot((c * x + s * y) / box[0], (c * y - s * x) / box[1]).sum()
        return float(result)


def used_boxes(robot: Robot, half_sizes: Sequence[float] | None, reach: float) -> Array:
    """How far feet are used behind and to the right of their nominal places, and before and to the left.

    Args:
        robot: whose feet they are.
        half_sizes: of a box for all feet that goes before those of the robot, m.
        reach: part of the box in which feet are used.

    Returns:
        (4, 2, 2), m.
    """
    box = np.abs(robot.foot_boxes(half_sizes)[..., :2])
    return np.asarray(np.clip(reach * box, NOTHING, REACH_OF_HEIGHT * robot.height))


def utility_of(offsets: Array, box: Array) -> Array:
    """1 for a nominal foot, 0 at the border of its box (2, 2), less beyond; (n, 2) → (n,)."""
    return np.asarray(1.0 - np.linalg.norm(offsets / np.where(offsets < 0.0, *box), axis=-1))


class Feet:
    """The feet of a base on its way.

    Attributes:
        way: of the base.
        at: number of the place of the way at which each foot is nominal: it stands there, or rolls abreast.
        arc: in which arc of its track each foot is.
    """

    def __init__(self, way: Carried) -> None:
        self.way, self.at, self.arc = way, [0] * FEET, [0] * FEET
        self._utility = [way.utility(leg, 0, slice(None)) for leg in range(FEET)]
        self._has_stepped, self._inside_from = [False] * FEET, [0] * FEET

    def keeps_until(self, leg: int, gone: float) -> float:
        """Time of the way at which a foot leaves what it uses of its box, inf if it does not."""
        now = max(self.way.index(gone), self._inside_from[leg])
        outside = np.flatnonzero(self._utility[leg][now:] < 0.0)
        return STEP * max(now, now + int(outside[0]) - 1) if outside.size else np.inf

    def lands_from(self, leg: int, gone: float) -> float:
        """How far the base must have come, s of the way, for a foot to land as far as it can before it must.

        Where an edge is before it, that is beyond the edge.

        Raises:
            StuckError: it cannot land any farther than where it is.
        """
        until = self.keeps_until(leg, gone)
        if not np.isfinite(until) or len(self.way.arcs[leg]) == 1:
            return gone
        low, high = self.way.index(gone), self.way.index(until)
        at, arc = self.landing(leg, high)
        if arc == self.arc[leg] and at <= self.at[leg]:
            raise StuckError(leg, at)
        if self.landing(leg, low)[1] == arc:
            return gone
        while high - low > 1:  # it lands the farther the later
            middle = (low + high) // 2
            low, high = (low, middle) if self.landing(leg, middle)[1] == arc else (middle, high)
        return STEP * high

    def is_settled(self, leg: int) -> bool:
        """Whether a foot ends where it has to: nominal, if it has stepped at all."""
        return not self._has_stepped[leg] or bool(self._utility[leg][-1] >= SETTLED)

    def may_settle(self, leg: int) -> float:
        """From when on (s of the way) a foot may land for good."""
        arc = len(self.way.arcs[leg]) - 1
        early = np.flatnonzero(self.way.utility(leg, -1, slice(None), arc) < LAND_LAST)
        return STEP * float(early[-1] + 1) if early.size else 0.0

    def landing(self, leg: int, now: int, for_good: bool = False) -> tuple[int, int]:
        """Where a foot lands, `at` and `arc`, below a base: as late as its box allows, or at the end."""
        way, last = self.way, len(self.way.base) - 1
        own = way.arcs[leg]
        if for_good or way.utility(leg, last, slice(now, None), len(own) - 1).min() >= LAND_LAST:
            return last, len(own) - 1
        arc, most = self.arc[leg], now + round(AHEAD / STEP)
        if way.robot.leg_list[leg].foot != "point":
            while arc + 1 < len(own) and (
                own[arc, 1] < now
                and (
                    own[arc + 1, 0] <= now
                    or float(way.utility(leg, now, slice(now, now + 1), arc + 1)[0]) >= LAND
                )
            ):
                arc += 1
        there = way.utility(leg, slice(now, most), now, arc)
        too_far = np.flatnonzero(there < LAND)
        at = now + max(0, int(too_far[0] if too_far.size else there.size) - 1)
        if way.robot.leg_list[leg].foot == "point" and len(own) > 1:
            first = min(now, self.at[leg])
            free = np.flatnonzero(way.stands(leg, first, at + 1))
            at = first + int(free[-1]) if free.size else self.at[leg]
            arc = way.arc_of(leg, at)
        return at, arc

    def land(self, leg: int, gone: float, for_good: bool = False) -> None:
        """Puts a foot down where it will be nominal as late as its box allows, or at the end."""
        way, now = self.way, self.way.index(gone)
        self.at[leg], self.arc[leg] = self.landing(leg, now, for_good)
        self._utility[leg] = way.utility(leg, self.at[leg], slice(None), self.arc[leg])
        self._inside_from[leg] = now + int(np.argmax(self._utility[leg][now:] >= 0.0))
        self._has_stepped[leg] = True


class StuckError(Exception):
    """A foot gets no farther: the next ground is out of its reach.

    Attributes:
        leg: whose.
        at: number of the place of its track that it gets to.
    """

    def __init__(self, leg: int, at: int) -> None:
        super().__init__(leg, at)
        self.leg, self.at = leg, at


def direct_way(scenario: Scenario, arcs_of: ArcsOf | None = None, reach: float = REACH) -> Carried:
    """The straight way through start and goals; `arcs_of` and `reach` as in `Carried.through`."""
    legs = [np.array(leg) for leg in pairwise(poses_of(scenario))]
    return Carried.through(legs, scenario, arcs_of, reach=reach)


def carried_ways(scenario: Scenario) -> list[Carried]:
    """Ways through start and goals of a scenario on flat ground, the most promising first."""
    poses, direct = poses_of(scenario), direct_way(scenario)
    headings = {leg.heading for leg in scenario.body.leg_list if leg.foot == "fixed"}
    if len(headings) != 1:
        return [direct]
    (heading,) = headings
    legs = [np.vstack([a, _driving(a, b, scenario.body, heading), b]) for a, b in pairwise(poses)]
    turning = Carried.through(legs, scenario)
    return [turning, direct] if direct.effort > WORTH * turning.effort else [direct]


def _driving(a: Array, b: Array, robot: Robot, heading: float) -> Array:
    """Poses between two, (2, 3), between which it drives, at the yaw at which least is left for steps."""
    lever = 0.5 * float(np.ptp(robot.stance[:, 0]))
    way = b[:2] - a[:2]
    turns = np.arange(-HEADINGS, HEADINGS + 1) * (0.5 * np.pi / HEADINGS)
    yaw = np.concatenate([a[2] + turns, b[2] + turns])
    first, last = np.abs(yaw - a[2]), np.abs(b[2] - yaw)
    across = way[1] * np.cos(yaw + heading) - way[0] * np.sin(yaw + heading)
    aside, turned = np.abs(across), lever * (first + last)
    side = np.sign(way[1] * np.cos(a[2] + heading) - way[0] * np.sin(a[2] + heading))
    to_the_side = 1e-6 * side * (yaw - a[2])  # of two that mirror one another, that on the side of the goal
    k = int(np.argmin(np.maximum(aside, turned) + WAY_OF_EFFORT * (aside + turned) - to_the_side))
    if turned[k] == 0.0:
        return np.array([a, b])
    free = min(1.0, turned[k] / max(aside[k], 1e-9)) * across[k]
    normal = np.array([-np.sin(yaw[k] + heading), np.cos(yaw[k] + heading)]) * free
    before = first[k] / (first[k] + last[k])
    return np.array([[*(a[:2] + before * normal), yaw[k]], [*(b[:2] - (1.0 - before) * normal), yaw[k]]])


def _shares(length: float, speed: float) -> Array:
    """How much of a way has been gone after each `STEP`, at rest at both ends and evenly between, (n,)."""
    if length < NOTHING:
        return np.zeros(0)
    ramp = min(RAMP, np.sqrt(length * RAMP / speed))
    duration = length / speed + ramp
    count = int(np.ceil(duration / STEP))
    time = np.arange(1, count + 1) / count * duration
    return ramped(time, duration, ramp)
