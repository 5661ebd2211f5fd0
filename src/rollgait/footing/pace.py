"""Where a scenario goes, how far a change of pose is, and how long wheels take for it. Needs no SciPy."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.robot.robot import turn_lever
from rollgait.scenario.scenario import Scenario

Array = NDArray[np.float64]

CRUISE: Final = 0.9
"""Part of its top speed that the fastest wheel reaches."""
PEAK: Final = 1.875
"""Largest speed of a minimum-jerk path, in mean speeds."""
SHORTEST: Final = 1.5
"""s that wheels take for a change of pose, however small."""


def driving_time(scenario: Scenario, change: Array, available: float) -> float:
    """Time that wheels take for a change of pose (x, y, yaw), m and rad, at most what there is, s."""
    way = float(np.hypot(change[0], change[1]) + turn_lever(scenario.body.stance) * abs(change[2]))
    speed = CRUISE * min(scenario.speed_max(leg) for leg in range(len(scenario.body.leg_list)))
    return min(max(SHORTEST, PEAK * way / speed), available)


def poses_of(scenario: Scenario) -> Array:
    """Start and goals, (x, y, yaw), (g + 1, 3), m and rad."""
    start, goal = scenario.start, scenario.goal
    places = [(start.x, start.y, start.yaw_deg), (goal.x, goal.y, goal.yaw_deg)]
    places += [(g.x, g.y, g.yaw_deg) for g in goal.then if g.at < scenario.horizon]
    return np.array([[x, y, np.radians(yaw)] for x, y, yaw in places])


def goal_times(scenario: Scenario) -> list[float]:
    """From when on the robot may go to each of its goals, s."""
    return [0.0, *(g.at for g in scenario.goal.then if g.at < scenario.horizon)]
