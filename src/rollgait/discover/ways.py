"""The ways of a base over its ground: the straight one, around what is in the way, to the side, turned.

Of each it is known where its feet must step; what forbids one says why.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from itertools import pairwise
from typing import Final

import numpy as np

from rollgait.discover.crossings import Crossing, crossings, lengths
from rollgait.discover.detours import Network
from rollgait.discover.openings import opening_refusal
from rollgait.discover.passages import Passages, passages
from rollgait.discover.refusals import STRIDE, Refusal, belly_refusal, landing_refusal
from rollgait.discover.steepness import lacking
from rollgait.discover.stops import stops
from rollgait.errors import NotSolvedError
from rollgait.footing.footing import Array
from rollgait.footing.on_terrain import regions_for, rise_max
from rollgait.footing.pace import poses_of
from rollgait.footing.route import BaseWay
from rollgait.robot.robot import turn_lever
from rollgait.scenario.scenario import Scenario

YAWS: Final = (20.0, -20.0, 35.0, -35.0)
"""By which the base is turned while it steps, degrees."""
OFFSETS: Final = (0.12, -0.12, 0.25, -0.25)
"""To which side of the straight way the base goes while it steps, m."""
ALIKE: Final = 0.02
"""Steps that lead as far as others but for so much do the same, m: tracks are looked up every centimetre."""
BESIDE: Final = 0.35
"""So far before the first step and after the last one it turns, or goes aside, m."""
ROOM: Final = 2.5
"""So far around start and goal a way around is looked for, m."""
ROOMS: Final = (0.1, 0.0)
"""What feet have between them and edges on ways around, m: more than the grid is wrong by; else none."""


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

    def is_alike(self, other: Way) -> bool:
        """Whether its feet step in the same order over the same: to the side the ground is as it is there."""
        own, others = self.reaches(), other.reaches()
        same_legs = [step.leg for step in self.steps] == [step.leg for step in other.steps]
        return same_legs and bool(np.allclose(own, others, atol=ALIKE))

    def reaches(self) -> Array:
        """How far each step leads, (n,), m."""
        length = lengths(self.base)
        ends = np.array([[step.leaves, step.lands] for step in self.steps]).reshape(-1, 2)
        return np.asarray(np.diff(np.interp(ends, self.base.s, length), axis=1)[:, 0])


class Ways:
    """The ways of a scenario.

    Attributes:
        scenario: what is asked.
        poses: start and goals, (g + 1, 3), m and rad.
        stance: nominal places of the feet, base-yaw frame, (4, 3), m.
        lever: what a turn of 1 rad counts as, m.
        regions: where each foot can stand; none on flat ground.
        rise: the highest step, m.
        stride: the longest step, m.
        wider: the ways of the robot as it is, where this one is thought to be narrower.
    """

    def __init__(self, scenario: Scenario, wider: Ways | None = None, by: float = 0.0) -> None:
        self.scenario, self.robot, self.wider = scenario, scenario.body, wider
        self.poses = poses_of(scenario)
        nominal = self.robot.stance
        self.stance = nominal - np.sign(nominal) * np.array([0.0, by, 0.0])
        self.lever = turn_lever(nominal)
        self.flat = scenario.ground.kind == "flat"
        self.regions = [] if self.flat else regions_for(scenario)
        self.rise = rise_max(self.robot)
        self.stride = STRIDE * float(self.robot.box[0])

    @cached_property
    def straight(self) -> Way | Refusal:
        """The straight way, or why there is none."""
        return self.look("", self.poses)

    @cached_property
    def promising(self) -> list[Way]:
        """The straight way, and where it is not free of steps, ways around.

        Raises:
            NotSolvedError: there is none; says why.
        """
        result = [self.straight] if isinstance(self.straight, Way) else []
        if not result or result[0].steps:
            result += self.around(bool(result))
        if not result and not isinstance(self.straight, Way):
            raise NotSolvedError(f"no way found: {opening_refusal(self) or self.straight()}")
        return result

    def narrower(self, by: float) -> Ways:
        """The ways of a robot whose feet stand nearer to its middle by so much (m)."""
        return Ways(self.scenario, self, by)

    def any_way(self, steps: bool) -> Way | None:
        """The straight way, else one around, free of steps if there may be none; None if there is no such."""
        straight = self.straight
        if isinstance(straight, Way) and (steps or not straight.steps):
            return straight
        return next((way for way in self.around(not steps)), None)

    def look(self, name: str, poses: Array) -> Way | Refusal:
        """The way through poses, or why there is none."""
        base = BaseWay.through(poses, self.lever)
        if self.flat:
            return Way(name, poses, base, ())
        stance, height = self.stance, self.robot.height
        treads = partial(lacking, base, stance, self.regions, self.rise, height)
        refusal = landing_refusal(base, stance, self.regions, self.rise, self.stride, treads)
        refusal = refusal or belly_refusal(base, stance, self.regions, self.rise, height)
        if refusal is not None:
            return refusal
        steps = crossings(base, stance, self.regions, self.rise)
        return Way(name, poses, base, steps)

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

    def aside(self) -> Iterator[Way]:
        """Ways that go to the side of the straight one, or turn, while feet step."""
        if not isinstance(self.straight, Way) or not self.straight.steps:
            return
        base, steps = self.straight.base, self.straight.steps
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

    def steered(self) -> Iterator[Way]:
        """Instead of a straight way on which wheels come to a stop of their steering.

        Ways that turn before they go, or at other yaws; on those where stops are left, and on the straight
        one, feet step there. None where no wheel comes to a stop.
        """
        if not isinstance(self.straight, Way) or len(self.poses) > 2 or not self.stops(self.straight):
            return
        start, goal = self.poses
        ahead = np.arctan2(*(goal - start)[1::-1])
        yaws = [(f"turned to {name}", yaw) for name, yaw in (("the goal's yaw", goal[2]), ("its way", ahead))]
        yaws += [("turned at the end", start[2]), ("turned to its way, backwards", ahead + np.pi)]
        for name, yaw in yaws:
            yaw = start[2] + (yaw - start[2] + np.pi) % (2.0 * np.pi) - np.pi
            turned = np.array([[*start[:2], yaw], [*goal[:2], yaw]])
            poses = np.vstack([start, turned, goal])
            changes = np.append(True, np.abs(np.diff(poses, axis=0)).max(axis=1) > 1e-9)
            way = self.look(name, poses[changes])
            if isinstance(way, Way):
                yield from self.stepping_at_stops(way)
        yield from self.stepping_at_stops(self.straight)

    def stepping_at_stops(self, way: Way) -> Iterator[Way]:
        """A way with steps at the stops that are on it; none where a step would be too long."""
        found = self.stops(way)
        with_steps = replace(way, steps=sorted((*way.steps, *found), key=lambda step: step.middle))
        if not found or with_steps.reaches().max() <= self.stride:
            name = ", ".join(part for part in (way.name, "steps to steer" if found else "") if part)
            yield replace(with_steps, name=name)

    def stops(self, way: Way) -> Sequence[Crossing]:
        """Where wheels come to a stop of their steering on a way."""
        free = (-np.inf, np.inf)
        legs = enumerate(self.robot.leg_list)
        ranges = [
            self.scenario.steering_range(leg) if data.foot == "steerable" else free for leg, data in legs
        ]
        return stops(way.base, self.robot.stance, ranges)

    @cached_property
    def window(self) -> tuple[Array, Array]:
        return self.poses[:, :2].min(axis=0) - ROOM, self.poses[:, :2].max(axis=0) + ROOM

    @cached_property
    def passages(self) -> Passages:
        if self.wider is not None:  # the same ground, looked at for other feet
            return replace(self.wider.passages, stance=self.stance)
        return passages(
            self.regions,
            self.stance,
            *self.window,
            rise_max=self.rise,
            stride=self.stride,
            height=self.robot.height,
        )


@lru_cache(maxsize=1)
def ways_of(scenario: Scenario) -> Ways:
    """The ways of a scenario; the last are kept, as several proposers ask for them."""
    return Ways(scenario)
