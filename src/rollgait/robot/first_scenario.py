"""The first scenario of an imported robot: a short way forward, scaled to the robot.

It crawls, that every leg is seen to move. Legs that cannot shift the body sideways keep all feet down:
wheels roll, and over point feet the body leans forward.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from rollgait.robot.robot import GRAVITY, Robot

STEPS: Final = 8
"""Of all feet together: two each."""

INTERVALS: Final = 100

INTERVAL: Final = 0.36
"""Of the mesh, as a share of the time √(height / g): 0.1 s for CENTAURO."""

PAUSE: Final = 10
"""Intervals at the beginning and at the end with all feet on the ground."""

DISTANCE: Final = 0.5
"""How far it goes, as a share of the length between the axles."""

STRIDE: Final = 0.6
"""Longest step of a foot that cannot roll, as a share of the box's half-length."""

LEAN: Final = 0.3
"""How far the body leans over feet that neither roll nor step, as a share of the box's half-length."""

CLEARANCE: Final = 0.1
"""How high the feet are lifted, as a share of the height of the CoM."""

LIFT: Final = 0.5
"""The same as a share of the box's half-height."""

PRESSED: Final = 0.03
"""Smallest force on a foot, as a share of the weight: the profile's own is that of CENTAURO."""

SIDEWAYS: Final = 0.03
"""Half-width of the box, as a share of its half-length, below which legs cannot shift the body sideways."""


def first_scenario(robot: Robot, file: str) -> dict[str, Any]:
    """The scenario as plain data.

    Args:
        robot: the robot.
        file: where it is written.
    """
    stance = robot.stance
    low, high = robot.foot_boxes().swapaxes(0, 1)
    half = (0.5 * (high - low)).min(axis=0)
    length = float(np.mean(stance[:2, 0]) - np.mean(stance[2:, 0]))
    interval = round(INTERVAL * float(np.sqrt(robot.height / GRAVITY)), 3)
    distance = DISTANCE * length
    crawl = {
        "kind": "crawl",
        "steps": STEPS,
        "clearance": round(float(min(CLEARANCE * robot.height, LIFT * high[:, 2].min())), 3),
        "pause_start": round(PAUSE * interval, 6),
        "pause_end": round(PAUSE * interval, 6),
    }
    stays = half[1] < SIDEWAYS * half[0]
    if any(leg.foot == "point" for leg in robot.leg_list):
        stride = STRIDE * half[0]
        distance = min(distance, LEAN * half[0] if stays else stride * STEPS / len(stance))
    return {
        "description": f"the first steps of {robot.name}",
        "robot": file,
        "goal": {"x": round(float(distance), 3)},
        "horizon": round(INTERVALS * interval, 6),
        "interval": interval,
        "gait": {"kind": "drive"} if stays else crawl,
        "bounds": {"force_min": round(PRESSED * robot.weight, 1)},
    }
