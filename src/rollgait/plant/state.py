"""The robot at one moment.

World frame, SI units, legs in the order FL, FR, HL, HR. Angles are not reduced: a robot that has turned once
has a yaw of 2π.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from rollgait.angles import near

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RobotState:
    """The state of the robot at one time.

    Attributes:
        time: s.
        com_position: r, (3,), m.
        euler: θ = (yaw, pitch, roll), (3,), rad.
        com_velocity: ṙ, (3,), m/s.
        euler_rate: θ̇, (3,), rad/s.
        foot_position: contact points p_i, (4, 3), m.
        heading: σ_i, (4,), rad.
        speed: v_i of the wheels along their headings, (4,), m/s.
    """

    time: float
    com_position: Array
    euler: Array
    com_velocity: Array
    euler_rate: Array
    foot_position: Array
    heading: Array
    speed: Array

    def is_finite(self) -> bool:
        """Whether all of it are numbers."""
        return all(bool(np.isfinite(getattr(self, f.name)).all()) for f in fields(self))

    def at(self, time: float) -> RobotState:
        """The same state, said to be that of another time."""
        return replace(self, time=time)


SHAPES = {
    "com_position": (3,),
    "euler": (3,),
    "com_velocity": (3,),
    "euler_rate": (3,),
    "foot_position": (4, 3),
    "heading": (4,),
    "speed": (4,),
}
"""Shapes of the parts of a state."""


def unwrapped(state: RobotState, other: RobotState) -> RobotState:
    """The same state with yaw and headings in the turn that is nearest to another state's."""
    yaw, heading = near(state.euler[0], other.euler[0]), near(state.heading, other.heading)
    if yaw == state.euler[0] and np.array_equal(heading, state.heading):
        return state
    return replace(state, euler=np.array([yaw, *state.euler[1:]]), heading=heading)


def largest_gap(state: RobotState, other: RobotState) -> float:
    """How far the CoM or a foot of one state is from where it is in another, along any axis, m."""
    gaps = (state.com_position - other.com_position, state.foot_position - other.foot_position)
    return max(float(np.abs(gap).max()) for gap in gaps)
