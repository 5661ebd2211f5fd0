"""What the controller knows of the robot at one moment, and what it asks of it until the next.

World frame, SI units, legs in the order FL, FR, HL, HR. Angles are not reduced: a robot that has turned once
has a yaw of 2π.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

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


def unwrapped(state: RobotState, near: RobotState) -> RobotState:
    """The same state with yaw and headings in the turn that is nearest to another state's."""
    turn = 2.0 * np.pi
    yaw = turn * np.round((near.euler[0] - state.euler[0]) / turn)
    headings = turn * np.round((near.heading - state.heading) / turn)
    if yaw == 0.0 and not headings.any():
        return state
    return replace(state, euler=state.euler + np.array([yaw, 0.0, 0.0]), heading=state.heading + headings)


@dataclass(frozen=True, eq=False)
class Control:
    """What the robot shall do for one period: from one state to another with constant forces and motions.

    Attributes:
        begin, end: where everything shall be at the ends of the period.
        force: f_i on the robot, (4, 3), N; 0 in swing.
        motion: (v_i, σ̇_i), (4, 2), m/s and rad/s.
        contact: which feet stand on the ground, (4,).
    """

    begin: RobotState
    end: RobotState
    force: Array
    motion: Array
    contact: NDArray[np.bool_]

    @property
    def period(self) -> float:
        """Its length, s."""
        return self.end.time - self.begin.time


class Plant(Protocol):
    """What is controlled: a model, a simulated robot, a recording. Time passes only in `step`."""

    name: str

    @property
    def state(self) -> RobotState:
        """The true state now."""

    @property
    def fallen(self) -> bool:
        """Whether the robot has fallen; it stays so."""

    def step(self, control: Control) -> None:
        """Lets one period pass under a control."""

    def push(self, force: Array, duration: float) -> None:
        """From now on a force on the base, (3,), N, world, for a time, s."""
