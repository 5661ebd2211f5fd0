"""Where a scenario goes, how far a change of pose is, and how long wheels take for it. Needs no SciPy."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.ocp.lift import minimum_jerk
from rollgait.robot.robot import turn_lever
from rollgait.scenario.scenario import Scenario

Array = NDArray[np.float64]

CRUISE: Final = 0.9
"""Part of its top speed that the fastest wheel reaches."""
PEAK: Final = 1.875
"""Largest speed of a minimum-jerk path, in mean speeds."""
SHORTEST: Final = 1.5
"""s that wheels take for a change of pose, however small."""
START: Final = 2.0
"""m/s² with which a drive begins that is as quick as its cost asks: the usual limit of wheels."""
STEP: Final = 0.01
"""s; so finely such a drive is reckoned."""
ARRIVED: Final = 0.98
"""Part of its way that it must have made in the time that there is: else it would still be on its way."""


def ramped(times: Array, duration: float, ramp: float) -> Array:
    """Part of a way that has been gone, (n,): at rest at both ends, minimum-jerk ramps, evenly between."""
    return np.asarray((_rise(times, ramp) - _rise(times - (duration - ramp), ramp)) / (duration - ramp))


def _rise(times: Array, ramp: float) -> Array:
    """Integral of a minimum-jerk rise from 0 to 1 within `ramp`."""
    s = np.clip(times / ramp, 0.0, 1.0)
    return np.asarray(ramp * s**4 * (2.5 - 3.0 * s + s**2) + np.maximum(times - ramp, 0.0))


def driving_time(scenario: Scenario, change: Array, available: float) -> float:
    """Time that wheels take for a change of pose (x, y, yaw), m and rad, at most what there is, s."""
    way, speed = _way_and_speed(scenario, change)
    return min(max(SHORTEST, PEAK * way / speed), available)


def driven(scenario: Scenario, change: Array, available: float, times: Array) -> Array:
    """Part of a change of pose that wheels have made after times (n,) in s, (n,), 0 to 1.

    As the costs ask for it: they begin at once, drive as fast as they can, and near the goal ever slower.
    What minimises ∫ w_goal d² + n w_speed ḋ² dt over the distance d to the goal falls by e in
    √(n w_speed / w_goal). Where the time is short it is the even path that `driving_time` means.
    """
    way, speed = _way_and_speed(scenario, change)
    goal, slow = (float(scenario.value_of("weights", name) or 0.0) for name in ("goal", "speed"))
    count = int(np.ceil(available / STEP))
    if goal > 0.0 and way > 0.0:
        slowing = np.sqrt(len(scenario.body.leg_list) * slow / goal) + STEP
        made = np.zeros(count + 1)
        for k in range(count):
            rate = min(START * (k + 1) * STEP, speed, (way - made[k]) / slowing)
            made[k + 1] = made[k] + rate * STEP
        if made[-1] >= ARRIVED * way:
            return np.asarray(np.interp(times, STEP * np.arange(count + 1), made / made[-1]))
    return minimum_jerk(times / driving_time(scenario, change, available))[0]


def _way_and_speed(scenario: Scenario, change: Array) -> tuple[float, float]:
    """How far a change of pose is, m, and how fast wheels go there, m/s."""
    way = float(np.hypot(change[0], change[1]) + turn_lever(scenario.body.stance) * abs(change[2]))
    return way, CRUISE * min(scenario.speed_max(leg) for leg in range(len(scenario.body.leg_list)))


def poses_of(scenario: Scenario) -> Array:
    """Start and goals, (x, y, yaw), (g + 1, 3), m and rad."""
    start, goal = scenario.start, scenario.goal
    places = [(start.x, start.y, start.yaw_deg), (goal.x, goal.y, goal.yaw_deg)]
    places += [(g.x, g.y, g.yaw_deg) for g in goal.then if g.at < scenario.horizon]
    return np.array([[x, y, np.radians(yaw)] for x, y, yaw in places])


def goal_times(scenario: Scenario) -> list[float]:
    """From when on the robot may go to each of its goals, s."""
    return [0.0, *(g.at for g in scenario.goal.then if g.at < scenario.horizon)]
