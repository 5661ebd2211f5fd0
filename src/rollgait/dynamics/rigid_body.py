"""The single rigid body under contact forces.

Equations 1 to 3 of the problem: m r̈ = m g + Σ f_i and I_W ω̇ + ω × I_W ω = Σ f_i × (r − p_i), I_W = R I_B Rᵀ,
ω̇ = E θ̈ + Ė θ̇. (The paper calls I constant; it is constant in the base frame.) CasADi expressions throughout.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from rollgait.dynamics.rotations import R_world_base, euler_axes, euler_axes_rate
from rollgait.robot.robot import GRAVITY

GRAVITY_VECTOR = ca.DM([0.0, 0.0, -GRAVITY])
"""g, m/s², world."""


def acceleration(mass: ca.SX, forces: Sequence[ca.SX]) -> ca.SX:
    """r̈ = g + Σ f_i / m, shape 3, m/s²; all forces from outside but the weight, N, world."""
    return GRAVITY_VECTOR + sum(forces, start=ca.SX.zeros(3)) / mass


def torque_about_com(r: ca.SX, p_feet: Sequence[ca.SX], forces: Sequence[ca.SX]) -> ca.SX:
    """Σ f_i × (r − p_i), shape 3, N·m, world."""
    torques = (ca.cross(f, r - p) for p, f in zip(p_feet, forces, strict=True))
    return sum(torques, start=ca.SX.zeros(3))


def inertia_world(I_B: ca.SX, theta: ca.SX) -> ca.SX:
    """I_W = R I_B Rᵀ, 3 × 3, kg·m²."""
    R = R_world_base(theta)
    return R @ I_B @ R.T


def angular_momentum(I_B: ca.SX, theta: ca.SX, dtheta: ca.SX) -> ca.SX:
    """L = I_W E θ̇ about the CoM, shape 3, N·m·s, world."""
    R = R_world_base(theta)
    return R @ (I_B @ (R.T @ (euler_axes(theta) @ dtheta)))


def momentum_rate(I_B: ca.SX, theta: ca.SX, dtheta: ca.SX, ddtheta: ca.SX) -> ca.SX:
    """L̇ = I_W ω̇ + ω × I_W ω, shape 3, N·m, world: equals the torque about the CoM."""
    E = euler_axes(theta)
    omega = E @ dtheta
    omega_rate = E @ ddtheta + euler_axes_rate(theta, dtheta) @ dtheta
    R = R_world_base(theta)
    # R (I_B (Rᵀ ·)) twice is cheaper than forming I_W, in its derivatives above all
    return R @ (I_B @ (R.T @ omega_rate)) + ca.cross(omega, R @ (I_B @ (R.T @ omega)))
