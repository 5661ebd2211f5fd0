"""Planar motion of a foot from its inputs: equation 4, and its like for the other kinds of foot.

Every foot has two planar inputs, called its motion:

    steerable   (v, σ̇)     ṗ = v (cos σ, sin σ), in stance and in swing: rolling without lateral slip
    fixed       (v, v⊥)    ṗ = Rz(σ) (v, v⊥), σ = θz + constant; v⊥ only in swing
    point       (ẋ, ẏ)     ṗ = (ẋ, ẏ), only in swing

CasADi expressions throughout.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from rollgait.robot.robot import FootKind


@dataclass(frozen=True)
class PlanarMotion:
    """What a foot's motion means in the world: headings in rad, speeds in m/s, rates in rad/s."""

    velocity: ca.SX
    heading: ca.SX
    heading_rate: ca.SX
    speed: ca.SX
    lateral_speed: ca.SX


def planar_motion(
    kind: FootKind, motion: ca.SX, sigma: ca.SX, yaw: ca.SX, yaw_rate: ca.SX, offset: ca.SX
) -> PlanarMotion:
    """Velocity, heading and speed of a foot.

    Args:
        kind: of the foot.
        motion: its two planar inputs.
        sigma: σ, the heading of a steerable wheel; not used otherwise.
        yaw: θz.
        yaw_rate: θ̇z.
        offset: σ − θz of a fixed wheel.
    """
    zero = ca.SX(0)
    if kind == "point":
        return PlanarMotion(motion, zero, zero, zero, zero)
    steers = kind == "steerable"
    heading = sigma if steers else yaw + offset
    v, lateral = motion[0], zero if steers else motion[1]
    c, s = ca.cos(heading), ca.sin(heading)
    velocity = ca.vertcat(c * v - s * lateral, s * v + c * lateral)
    return PlanarMotion(velocity, heading, motion[1] if steers else yaw_rate, v, lateral)
