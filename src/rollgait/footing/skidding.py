"""Ways of robots on fixed wheels that may slip sideways (`legs.*.slip_max`).

They roll along one line and turn on the spot: a wheel at a distance a ahead of the middle slips by a times
the turn rate, so `slip_max` says how fast they turn. Two poses are joined by a turn, a drive ahead or back,
and a turn; or by a drive along the one yaw, a turn, and a drive along the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from rollgait.angles import near, turned
from rollgait.footing.footing import FEET, Array
from rollgait.footing.pace import goal_times, poses_of, ramped
from rollgait.robot.robot import Robot
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule

SLIP_SHARE: Final = 0.8
"""Part of `slip_max` that wheels slip by while the base turns evenly: the rest is for the solver."""
SPEED: Final = 0.4
"""m/s; with which the base drives at most."""
SPEED_OF_WHEELS: Final = 0.5
"""The same in parts of the top speed of the slowest wheel."""
RAMP: Final = 1.0
"""s, in which the base takes up its speed, and in which it comes to rest, where the way is long enough."""
NOTHING: Final = 1e-6
"""m, rad; a shorter part of a way is none."""
NEAR: Final = 2e-3
"""m; a goal that is so near is turned to, not driven to: legs that move in planes sway by that much."""
ALONG: Final = 1e-2
"""Sine of the angle between two headings below which drives along them do not lead to the side."""
DETOUR: Final = 2.0
"""In straight ways: drives along two headings that are longer are not proposed, as they lead far away."""


@dataclass(frozen=True)
class SkidWay:
    """Straight from pose to pose, at rest at each, turning or driving.

    Attributes:
        name: for people.
        poses: x, y, yaw, the start first, (n + 1, 3), m and rad.
        durations: of the parts, (n,), s.
    """

    name: str
    poses: Array
    durations: Array

    @property
    def duration(self) -> float:
        """Of the whole, s."""
        return float(self.durations.sum())

    def at(self, times: Array) -> Array:
        """Poses at times (n,) in s, (n, 3)."""
        result, begin = np.tile(self.poses[0], (times.size, 1)), 0.0
        for a, b, duration in zip(self.poses, self.poses[1:], self.durations, strict=False):
            share = ramped(times - begin, duration, min(RAMP, 0.5 * duration))
            result += share[:, None] * (b - a)
            begin += duration
        return result


def skids(scenario: Scenario) -> bool:
    """Whether all wheels may slip sideways, and roll into one direction."""
    legs = scenario.body.leg_list
    return (
        all(scenario.slip_max(leg) > 0.0 for leg in range(FEET)) and len({leg.heading for leg in legs}) == 1
    )


def turns_by_skidding(scenario: Scenario, schedule: ContactSchedule) -> bool:
    """Whether the robot turns by wheels that slip sideways, and by no step."""
    return skids(scenario) and bool(schedule.contact.all())


def turn_rate_max(scenario: Scenario) -> float:
    """How fast a robot on wheels that may slip turns on the spot, rad/s."""
    robot = scenario.body
    ahead = np.abs(turned(robot.stance[:, :2], -_heading(robot))[:, 0])
    return float(min(scenario.slip_max(leg) / max(ahead[leg], NOTHING) for leg in range(FEET)))


def skid_ways(scenario: Scenario, a: Array, b: Array, slower: float = 1.0) -> list[SkidWay]:
    """Ways from a pose to another, (3,) m and rad, the quickest first, in `slower` times the usual time."""
    joined = [
        ("turns before and after its way", _turning_first(a, b, _heading(scenario.body), 0.0)),
        ("turns before and after its way, backwards", _turning_first(a, b, _heading(scenario.body), np.pi)),
        ("turns on its way", _driving_first(a, b, _heading(scenario.body))),
    ]
    ways = [_timed(scenario, name, poses, slower) for name, poses in joined if poses is not None]
    return sorted(ways, key=lambda way: round(way.duration, 6))


def skid_route(scenario: Scenario, times: Array) -> Array:
    """Poses (x, y, yaw) of a base on its way through the goals at times (n,) in s, (n, 3).

    Where the time between two goals is short, it is hurried.
    """
    poses, begins = poses_of(scenario), goal_times(scenario)
    result = np.tile(poses[0], (times.size, 1))
    for (a, b), (begin, end) in zip(pairwise(poses), pairwise([*begins, scenario.horizon]), strict=True):
        way = skid_ways(scenario, a, b)[0]
        hurry = max(1.0, way.duration / (end - begin))
        result += way.at((times - begin) * hurry) - a
    return result


def _heading(robot: Robot) -> float:
    """Of all wheels from the base, rad."""
    return float(robot.leg_list[0].heading)


def _timed(scenario: Scenario, name: str, poses: Sequence[Array], slower: float) -> SkidWay:
    speed = min(SPEED, SPEED_OF_WHEELS * min(scenario.speed_max(leg) for leg in range(FEET)))
    rate = SLIP_SHARE * turn_rate_max(scenario)
    kept, durations = [poses[0]], []
    for a, b in pairwise(poses):
        even = max(float(np.hypot(*(b - a)[:2])) / speed, abs(float(b[2] - a[2])) / rate)
        if even * speed > NOTHING:
            kept.append(b)
            durations.append(slower * (even + min(RAMP, even)))
    return SkidWay(name, np.array(kept), np.array(durations))


def _turning_first(a: Array, b: Array, heading: float, reverse: float) -> Sequence[Array]:
    """Turns to where the goal is, drives there, ahead or back, turns to its yaw."""
    way = b[:2] - a[:2]
    if np.hypot(*way) <= NEAR:
        return [a, b]
    yaw = near(float(np.arctan2(way[1], way[0])) + reverse - heading, 0.5 * (a[2] + b[2]))
    return [a, np.array([*a[:2], yaw]), np.array([*b[:2], yaw]), b]


def _driving_first(a: Array, b: Array, heading: float) -> Sequence[Array] | None:
    """Drives along its heading, turns, and drives along the other one; None where that leads nowhere."""
    along = np.array([[np.cos(yaw + heading), np.sin(yaw + heading)] for yaw in (a[2], b[2])])
    if abs(np.linalg.det(along)) < ALONG:
        return None
    way = b[:2] - a[:2]
    first, last = np.linalg.solve(along.T, way)
    if abs(first) + abs(last) > DETOUR * np.hypot(*way):
        return None
    corner = a[:2] + first * along[0]
    return [a, np.array([*corner, a[2]]), np.array([*corner, b[2]]), b]
