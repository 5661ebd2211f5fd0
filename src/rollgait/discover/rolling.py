"""Gaits for robots on wheels that can be steered: they roll, and step where their tracks leave the ground.

The straight way is the first that is looked at. Ways around, to the side, and with another yaw of the base
are further ones; each is taken at several paces, and its steps in several orders.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Final

import numpy as np

from rollgait.discover.candidate import Candidate
from rollgait.discover.crossings import Crossing, crossings, lengths
from rollgait.discover.detours import Network
from rollgait.discover.orders import monotone, other_orders, straying
from rollgait.discover.passages import Passages, passages
from rollgait.discover.refusals import STRIDE, Refusal, belly_refusal, landing_refusal
from rollgait.discover.serial import gait_values
from rollgait.discover.timing import Pace, timed
from rollgait.errors import NotSolvedError
from rollgait.footing.footing import Array
from rollgait.footing.on_terrain import regions_for, rise_max
from rollgait.footing.pace import poses_of
from rollgait.footing.route import BaseWay
from rollgait.robot.robot import turn_lever
from rollgait.scenario.scenario import Scenario

FLAT_PACE: Final = Pace(speed=0.5)
"""Where nothing is in the way: as fast as a goal is reached without haste."""
SLOWER: Final = 1.4
"""Times the time: what a motion is given that is not found in the usual one."""
FASTEST: Final = 0.6
"""Times the time: no gait is hurried more where the horizon is short."""
YAWS: Final = (20.0, -20.0, 35.0, -35.0)
"""By which the base is turned while it steps, degrees."""
OFFSETS: Final = (0.12, -0.12, 0.25, -0.25)
"""To which side of the straight way the base goes while it steps, m."""
BESIDE: Final = 0.35
"""So far before the first step and after the last one it turns, or goes aside, m."""
ROOM: Final = 2.5
"""So far around start and goal a way around is looked for, m."""
ROOMS: Final = (0.1, 0.0)
"""What feet have between them and edges on ways around, m: more than the grid is wrong by; else none."""
STEP_TIME: Final = 0.5
"""What a step counts in the score beside its time, s: who rolls cannot stumble."""
DOUBT: Final = 2.0
"""What any alternative counts in the score, s: what comes as it comes is mostly right."""
STRAY: Final = 0.16
"""By so much the base may stray from where its feet want it, m: more is out of their boxes."""


@dataclass(frozen=True)
class Way:
    """A way that feet can get along.

    Attributes:
        name: for people; empty for the straight one.
        poses: that it leads through, the start first, (n + 1, 3), m and rad.
        base: the way itself.
        steps: where feet must step, in the order of their middles.
    """

    name: str
    poses: Array
    base: BaseWay
    steps: Sequence[Crossing]


def rolling(scenario: Scenario) -> Iterator[Candidate]:
    """The candidates for a robot on wheels; none where it has point feet, or wheels locked.

    Raises:
        NotSolvedError: there is no way over the ground; says where and why.
    """
    if all(leg.foot == "steerable" for leg in scenario.body.leg_list) or (
        scenario.ground.kind != "flat" and all(leg.foot != "point" for leg in scenario.body.leg_list)
    ):
        yield from _Rolling(scenario).candidates()


class _Rolling:
    """The ways of a scenario, and the gaits along them."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario, self.robot = scenario, scenario.body
        self.poses = poses_of(scenario)
        self.lever = turn_lever(self.robot.stance)
        self.flat = scenario.ground.kind == "flat"
        self.regions = [] if self.flat else regions_for(scenario)
        self.rise = rise_max(self.robot)
        self.stride = STRIDE * float(self.robot.box[0])
        self.too_long: list[float] = []

    # -- ways --------------------------------------------------------------------------------------------

    def candidates(self) -> Iterator[Candidate]:
        """The straight way and those around, each as it comes; only then what is tried instead."""
        straight = self.look("", self.poses)
        ways = [straight] if isinstance(straight, Way) else []
        if not ways or ways[0].steps:
            ways += self.around(isinstance(straight, Way))
        if not ways and not isinstance(straight, Way):
            raise NotSolvedError(f"no way found: {straight()}")
        usual = sorted((c for way in ways for c in self.usual(way)), key=lambda c: c.score)
        yield from usual
        others = [c for way in ways for c in self.others(way)]
        if isinstance(straight, Way) and straight.steps:
            others += [c for way in self.aside(straight) for c in (*self.usual(way), *self.others(way))]
        yield from sorted(others, key=lambda c: c.score)
        if not usual and not others:
            raise NotSolvedError(
                f"no motion found: the quickest one that is known takes {min(self.too_long):g} s, "
                f"the horizon is {self.scenario.horizon:g} s"
            )

    def look(self, name: str, poses: Array) -> Way | Refusal:
        """The way through poses, or why there is none."""
        base = BaseWay.through(poses, self.lever)
        if self.flat:
            return Way(name, poses, base, ())
        stance = self.robot.stance
        refusal = landing_refusal(base, stance, self.regions, self.rise, self.stride)
        refusal = refusal or belly_refusal(base, stance, self.regions, self.rise, self.robot.height)
        if refusal is not None:
            return refusal
        return Way(name, poses, base, crossings(base, stance, self.regions, self.rise))

    def around(self, is_straight: bool) -> Iterator[Way]:
        """Ways around: with no step at all, and where there is no straight one, with some."""
        for steps in (False,) if is_straight else (False, True):
            for room in ROOMS:
                poses = self.detour(room, steps)
                if poses is None:
                    continue
                way = self.look("around" if not steps else "around, with steps", poses)
                if isinstance(way, Way) and (steps or not way.steps):
                    yield way
                    break

    def detour(self, room: float, steps: bool) -> Array | None:
        """The poses of a way around; None if there is none."""
        poses = self.poses[:1]
        passages = self.passages.with_room(room)
        for start, goal in pairwise(self.poses):
            network = Network.between(passages, start, goal, *self.window, self.lever, steps)
            path = network.path(start, goal)
            if path is None:
                return None
            poses = np.vstack([poses, network.pulled(path)[1:]])
        return poses

    def aside(self, straight: Way) -> Iterator[Way]:
        """Ways that go to the side, or turn, while feet step."""
        base, steps = straight.base, straight.steps
        length = lengths(base)
        if len(self.poses) > 2 or length[-1] <= 0.0:
            return
        first = np.interp(min(step.leaves for step in steps), base.s, length) - BESIDE
        last = np.interp(max(step.lands for step in steps), base.s, length) + BESIDE
        s = np.interp([max(first, 0.0), min(last, length[-1])], length, base.s)
        ends = base.at(s)
        along = (ends[1, :2] - ends[0, :2]) / max(1e-9, float(np.linalg.norm(ends[1, :2] - ends[0, :2])))
        left = np.array([-along[1], along[0]])
        changes = [(f"base turned by {yaw:+g}°", np.zeros(2), np.radians(yaw)) for yaw in YAWS]
        changes += [(f"{abs(y):g} m to the {'left' if y > 0 else 'right'}", y * left, 0.0) for y in OFFSETS]
        for name, shift, turn in changes:
            there = ends + np.append(shift, turn)
            way = self.look(name, np.vstack([self.poses[:1], there, self.poses[1:]]))
            if isinstance(way, Way):
                yield way

    @cached_property
    def window(self) -> tuple[Array, Array]:
        return self.poses[:, :2].min(axis=0) - ROOM, self.poses[:, :2].max(axis=0) + ROOM

    @cached_property
    def passages(self) -> Passages:
        return passages(
            self.regions,
            self.robot.stance,
            *self.window,
            rise_max=self.rise,
            stride=self.stride,
            height=self.robot.height,
        )

    # -- gaits -------------------------------------------------------------------------------------------

    def usual(self, way: Way) -> Iterator[Candidate]:
        """The gait along a way, as it comes."""
        yield from self.paced(self.name(way), way, way.steps, self.pace, self.doubt(way))

    def others(self, way: Way) -> Iterator[Candidate]:
        """Other gaits along a way: slower, its steps in other orders."""
        name, doubt = self.name(way), self.doubt(way) + DOUBT
        yield from self.paced(
            f"{name}, {SLOWER:g} × the time", way, way.steps, self.pace.times(SLOWER), doubt
        )
        length = lengths(way.base, self.lever)
        per_metre = way.base.s[-1] / max(1e-9, float(length[-1]))
        for order in other_orders(way.steps, 0.1 * per_metre):
            stray = straying(order) / per_metre
            if stray <= STRAY:
                more = doubt + DOUBT * stray / STRAY
                yield from self.paced(f"{name}, another order", way, order, self.pace, more)

    @property
    def pace(self) -> Pace:
        return FLAT_PACE if self.flat else Pace()

    def name(self, way: Way) -> str:
        return way.name or ("as it comes" if way.steps else "driving")

    def doubt(self, way: Way) -> float:
        return DOUBT if way.name and way.steps else 0.0

    def paced(
        self, name: str, way: Way, steps: Sequence[Crossing], pace: Pace, doubt: float
    ) -> Iterator[Candidate]:
        """A gait, hurried where the horizon asks for it; none where it would have to be hurried too much."""
        length = lengths(way.base, self.lever)
        places = [float(p) for p in monotone([step.middle for step in steps])]
        plan = timed(steps, way.base.s, length, pace, places)
        if plan.horizon > self.scenario.horizon + 1e-9:
            factor = (self.scenario.horizon - 0.1) / plan.horizon
            hurried = timed(steps, way.base.s, length, pace.times(max(factor, FASTEST)), places)
            if hurried.horizon > self.scenario.horizon + 1e-9:
                self.too_long.append(hurried.horizon)
                return
            name, plan = f"{name}, hurried", hurried
        values = gait_values(way.base, way.poses, steps, plan, self.scenario.gait, self.lever)
        yield Candidate(name, float(plan.horizon + STEP_TIME * len(steps) + doubt), values)
