"""What a plan says at given times."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.npz import Layout

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Samples:
    """The planned motion at n times (without the first axis for a single time).

    World frame unless said otherwise, SI units, legs in the order FL, FR, HL, HR. At the border of two
    intervals the inputs (force, speed, rates, contact) are those of the later one.

    Attributes:
        time: (n,), s.
        com_position: r, (n, 3), m.
        euler: θ = (yaw, pitch, roll), (n, 3), rad, R = Rz(yaw) Ry(pitch) Rx(roll).
        com_velocity: ṙ, (n, 3), m/s.
        euler_rate: θ̇, (n, 3), rad/s.
        foot_position: p, contact points, (n, 4, 3), m.
        foot_velocity: ṗ, (n, 4, 3), m/s.
        heading: σ, (n, 4), rad; 0 for point feet.
        heading_rate: σ̇, (n, 4), rad/s; 0 for point feet.
        speed: v along the heading, (n, 4), m/s; 0 for point feet.
        force: f, contact force on the robot, (n, 4, 3), N.
        contact: whether the foot is in stance, (n, 4), bool.
    """

    time: Array
    com_position: Array
    euler: Array
    com_velocity: Array
    euler_rate: Array
    foot_position: Array
    foot_velocity: Array
    heading: Array
    heading_rate: Array
    speed: Array
    force: Array
    contact: NDArray[np.bool_]

    def at(self, index: Any) -> Samples:
        """The samples at an index or slice of the first axis."""
        return Samples(**{f.name: getattr(self, f.name)[index] for f in fields(self)})


SAMPLES_LAYOUT: Final[Layout] = {
    "time": ("f", ("n",)),
    **dict.fromkeys(("com_position", "euler", "com_velocity", "euler_rate"), ("f", ("n", 3))),
    **dict.fromkeys(("foot_position", "foot_velocity"), ("f", ("n", 4, 3))),
    **dict.fromkeys(("heading", "heading_rate", "speed"), ("f", ("n", 4))),
    "force": ("f", ("n", 4, 3)),
    "contact": ("b", ("n", 4)),
}
"""Samples as arrays in a file."""
