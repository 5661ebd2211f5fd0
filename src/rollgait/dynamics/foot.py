"""Planar motion of a foot from its inputs: equation 4, and its like for the other kinds of foot.

Every foot has two planar inputs, called its motion:

    steerable   (v, σ̇)     ṗ = v (cos σ, sin σ), in stance and in swing: rolling without lateral slip
    fixed       (v, v⊥)    ṗ = Rz(σ) (v, v⊥), σ = θz + constant; v⊥ in swing, or where it may slip
    point       (ẋ, ẏ)     ṗ = (ẋ, ẏ), only in swing

This is their only home: problem, step, trajectories and plants take them from here. The certificate does not.
All functions take the module that does the arithmetic, `xp`: casadi for expressions, numpy or math for
numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rollgait.robot.robot import FootKind

Scalar = Any
"""A CasADi expression, a number, or a NumPy array over many feet or times at once."""


@dataclass(frozen=True)
class PlanarMotion:
    """What a foot's motion means in the world: headings in rad, speeds in m/s, rates in rad/s.

    Attributes:
        velocity: ṗ, (x, y).
        heading, heading_rate: σ and σ̇; 0 for a point foot, which has none.
        speed, lateral_speed: along the heading and to its left; 0 for a point foot.
    """

    velocity: tuple[Scalar, Scalar]
    heading: Scalar
    heading_rate: Scalar
    speed: Scalar
    lateral_speed: Scalar


def planar_motion(
    xp: Any,
    kind: FootKind,
    motion: Sequence[Scalar] | Scalar,
    sigma: Scalar,
    yaw: Scalar,
    yaw_rate: Scalar,
    offset: Scalar,
) -> PlanarMotion:
    """Velocity, heading and speed of a foot.

    Args:
        xp: does the arithmetic.
        kind: of the foot.
        motion: its two planar inputs.
        sigma: σ, the heading of a steerable wheel; not used otherwise.
        yaw: θz.
        yaw_rate: θ̇z.
        offset: σ − θz of a fixed wheel.
    """
    first, second = motion[0], motion[1]
    if kind == "point":
        return PlanarMotion((first, second), 0.0, 0.0, 0.0, 0.0)
    steers = kind == "steerable"
    heading = sigma if steers else yaw + offset
    c, s = xp.cos(heading), xp.sin(heading)
    if steers:
        return PlanarMotion((c * first, s * first), heading, second, first, 0.0)
    return PlanarMotion((c * first - s * second, s * first + c * second), heading, yaw_rate, first, second)


def planar_inputs(
    xp: Any,
    kind: FootKind,
    velocity: Sequence[Scalar] | Scalar,
    heading: Scalar,
    heading_rate: Scalar,
    speed: Scalar,
) -> tuple[Scalar, Scalar]:
    """The inverse of `planar_motion`: the two inputs that move a foot so.

    Args:
        xp: does the arithmetic.
        kind: of the foot.
        velocity: ṗ, (x, y), m/s; a steerable wheel has only that along its heading, which `speed` says.
        heading, heading_rate: σ and σ̇, rad and rad/s; not used for a point foot.
        speed: along the heading, m/s; used for a steerable wheel only.
    """
    vx, vy = velocity[0], velocity[1]
    if kind == "point":
        return vx, vy
    if kind == "steerable":
        return speed, heading_rate
    c, s = xp.cos(heading), xp.sin(heading)
    return c * vx + s * vy, c * vy - s * vx
