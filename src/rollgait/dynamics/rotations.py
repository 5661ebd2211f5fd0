"""Rotations by Euler angles θ = (yaw, pitch, roll), R(θ) = Rz(yaw) Ry(pitch) Rx(roll), base to world.

All functions take and return CasADi expressions (SX, MX or DM).
"""

from __future__ import annotations

import casadi as ca


def R_z(angle: ca.SX) -> ca.SX:
    """Rotation about z, 3 × 3; angle in rad."""
    c, s = ca.cos(angle), ca.sin(angle)
    return _rows((c, -s, 0), (s, c, 0), (0, 0, 1))


def R_y(angle: ca.SX) -> ca.SX:
    """Rotation about y, 3 × 3; angle in rad."""
    c, s = ca.cos(angle), ca.sin(angle)
    return _rows((c, 0, s), (0, 1, 0), (-s, 0, c))


def R_x(angle: ca.SX) -> ca.SX:
    """Rotation about x, 3 × 3; angle in rad."""
    c, s = ca.cos(angle), ca.sin(angle)
    return _rows((1, 0, 0), (0, c, -s), (0, s, c))


def R_world_base(theta: ca.SX) -> ca.SX:
    """R(θ) = Rz(θz) Ry(θy) Rx(θx), base to world, 3 × 3; θ = (yaw, pitch, roll) in rad."""
    return R_z(theta[0]) @ R_y(theta[1]) @ R_x(theta[2])


def euler_axes(theta: ca.SX) -> ca.SX:
    """E(θ) in ω = E θ̇, ω in world axes, 3 × 3.

    Its columns are the axes about which yaw, pitch and roll turn: e_z, Rz e_y, Rz Ry e_x.
    """
    c_z, s_z, c_y, s_y = ca.cos(theta[0]), ca.sin(theta[0]), ca.cos(theta[1]), ca.sin(theta[1])
    return _rows((0, -s_z, c_z * c_y), (0, c_z, s_z * c_y), (1, 0, -s_y))


def euler_axes_rate(theta: ca.SX, dtheta: ca.SX) -> ca.SX:
    """Ė(θ, θ̇), 3 × 3: each axis turns with the rotations that come before it."""
    E = euler_axes(theta)
    e_z, axis_pitch, axis_roll = E[:, 0], E[:, 1], E[:, 2]
    omega_yaw = e_z * dtheta[0]
    omega_yaw_pitch = omega_yaw + axis_pitch * dtheta[1]
    return ca.horzcat(ca.DM.zeros(3), ca.cross(omega_yaw, axis_pitch), ca.cross(omega_yaw_pitch, axis_roll))


def _rows(*rows: tuple[ca.SX | int, ca.SX | int, ca.SX | int]) -> ca.SX:
    return ca.vertcat(*(ca.horzcat(*row) for row in rows))
