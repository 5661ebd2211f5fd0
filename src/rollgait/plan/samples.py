"""What a plan says at given times."""

from __future__ import annotations

from collections.abc import Sequence
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
        foot_position: p, lowest points of the wheels' rims, (n, 4, 3), m; on level ground the contact points.
        foot_velocity: ṗ, (n, 4, 3), m/s.
        heading: σ, (n, 4), rad; 0 for point feet.
        heading_rate: σ̇, (n, 4), rad/s; 0 for point feet.
        speed: v along the heading, (n, 4), m/s; 0 for point feet.
        force: f, contact force on the robot, (n, 4, 3), N.
        contact: whether the foot is in stance, (n, 4), bool.
        contact_position: where a foot that stands touches the ground, p + R (e_z − n), (n, 4, 3), m; p in
            swing.
        contact_normal: n, unit normal of the ground there, upwards, (n, 4, 3); e_z in swing.
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
    contact_position: Array
    contact_normal: Array

    def at(self, index: Any) -> Samples:
        """The samples at an index or slice of the first axis."""
        return Samples(**{f.name: getattr(self, f.name)[index] for f in fields(self)})


def level_contact(foot_position: Array) -> dict[str, Array]:
    """The fields of contacts on level ground: at the lowest points of the feet, (n, 4, 3), m."""
    up = np.broadcast_to([0.0, 0.0, 1.0], foot_position.shape)
    return {"contact_position": foot_position, "contact_normal": up}


def way_factor(samples: Samples) -> Array:
    """Way of each foot along the ground over its way in the plane, in its heading's direction, (n, 4)."""
    slope = -samples.contact_normal[..., :2] / samples.contact_normal[..., 2:]
    climb = slope[..., 0] * np.cos(samples.heading) + slope[..., 1] * np.sin(samples.heading)
    return np.hypot(1.0, climb)


def wheel_angle(samples: Samples, wheel_radius: Sequence[float | None]) -> Array:
    """Angle by which each wheel has turned since the first sample, (n, 4), rad: v along the ground over R.

    Args:
        samples: of n times.
        wheel_radius: R of each, m; None of a foot without a wheel, whose angle is 0.
    """
    rate = samples.speed * way_factor(samples) / [radius or np.inf for radius in wheel_radius]
    turned = 0.5 * (rate[1:] + rate[:-1]) * np.diff(samples.time)[:, None]
    return np.concatenate([np.zeros((1, len(wheel_radius))), np.cumsum(turned, axis=0)])


def rate_of(values: Array, time: Array) -> Array:
    """Difference quotients of values (n, …) over time (n,); 0 of a single one."""
    return np.asarray(np.gradient(values, time, axis=0) if len(time) > 1 else np.zeros_like(values))


SAMPLES_LAYOUT: Final[Layout] = {
    "time": ("f", ("n",)),
    **dict.fromkeys(("com_position", "euler", "com_velocity", "euler_rate"), ("f", ("n", 3))),
    **dict.fromkeys(("foot_position", "foot_velocity"), ("f", ("n", 4, 3))),
    **dict.fromkeys(("heading", "heading_rate", "speed"), ("f", ("n", 4))),
    "force": ("f", ("n", 4, 3)),
    "contact": ("b", ("n", 4)),
    **dict.fromkeys(("contact_position", "contact_normal"), ("f", ("n", 4, 3))),
}
"""Samples as arrays in a file."""
