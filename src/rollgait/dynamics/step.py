"""One step of the robot under constant inputs: the map behind the condensed transcription.

State (r, θ, ṙ, L, feet), L the angular momentum about the CoM: θ̇ and L are one-to-one, and L is the better
coordinate, as its rate needs no inertia. Over a step of length h with constant forces and motions

    r, ṙ      exact (r̈ is constant)
    p_i       2-point Gauss quadrature of the foot's velocity; its height over the ground exactly (a parabola)
    L         exact in the mean lever arm of each foot, ∫ (r − p_i) dt / h × f_i, by the same quadrature
    wrench    constant, with the base as it is in the middle, if there is one
    θ         midpoint rule with the mean of L(t) over the step; the middle itself by L in its first half

All functions take the module that does the arithmetic, `xp`: casadi for expressions, numpy for numbers. A
vector is a list of its components, each an expression or an array over many steps at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.foot import Scalar, planar_motion
from rollgait.dynamics.ground import FootGround
from rollgait.dynamics.wrench import external
from rollgait.polynomials import HEIGHT_POINTS, gauss_points
from rollgait.robot.robot import GRAVITY, FootKind

Vector = Sequence[Scalar]

POINTS = tuple(float(c) for c in gauss_points(HEIGHT_POINTS))
"""Points of the 2-point Gauss rule on [0, 1]; both have weight 1/2. The lift rates are given at them."""


@dataclass(frozen=True)
class FootState:
    """Lowest point of the rim (3) in m and heading σ of a steerable wheel in rad."""

    p: Vector
    sigma: Scalar


@dataclass(frozen=True)
class State:
    """r (3, m), θ (3, rad), ṙ (3, m/s), L (3, N·m·s), the feet."""

    r: Vector
    theta: Vector
    dr: Vector
    L: Vector
    feet: tuple[FootState, ...]


@dataclass(frozen=True)
class FootInput:
    """Force (3, N), planar motion (2, see `dynamics.foot`), lift rates at the two points (2, m/s).

    A lift rate is how fast the height above the ground changes.
    """

    force: Vector
    motion: Vector
    lift_rate: Vector


@dataclass(frozen=True)
class Figures:
    """What a step knows of the robot: mass, I_B⁻¹ (rows of 3), foot kinds, headings of fixed wheels."""

    mass: Scalar
    inertia_inverse: Sequence[Vector]
    kinds: Sequence[FootKind]
    heading_offset: Vector


def step(
    xp: Any,
    x: State,
    u: Sequence[FootInput],
    h: Scalar,
    robot: Figures,
    grounds: Sequence[FootGround] | None = None,
    wrench: Vector | None = None,
) -> tuple[State, State]:
    """The state after a step of length h (s), and that in its middle (there L is its mean over the step).

    Args:
        xp: does the arithmetic.
        x: the state before.
        u: inputs of the four feet.
        h: length of the step, s.
        robot: its figures.
        grounds: under the four feet; None where it is level, which costs less.
        wrench: from outside, see `dynamics.wrench`; None where there is none, likewise.
    """
    ddr = [sum(foot.force[i] for foot in u) / robot.mass for i in range(3)]
    ddr[2] = ddr[2] - GRAVITY
    rate = euler_rate(xp, x.theta, x.L, robot)
    offsets = [None] * len(x.feet) if grounds is None else [g.contact_offset(xp) for g in grounds]
    torque = [0.0, 0.0, 0.0]
    for foot, inputs, offset in zip(x.feet, u, offsets, strict=True):
        torque = _add(torque, 1.0, _cross(inputs.force, _minus(x.r, _beside(foot.p, 1.0, offset))))
    if wrench is not None:
        torque = _add(torque, 1.0, external(wrench, rotation(xp, x.theta))[1])
    # L in the middle of the first half: its change within the step counts where forces have just changed
    theta_middle = _add(x.theta, 0.5 * h, euler_rate(xp, x.theta, _add(x.L, 0.25 * h, torque), robot))
    L_from_outside = list(x.L), list(x.L)  # at the end, and in the mean, but for the feet
    if wrench is not None:
        push, turning = external(wrench, rotation(xp, theta_middle))
        ddr = _add(ddr, 1.0 / robot.mass, push)
        L_from_outside = _add(x.L, h, turning), _add(x.L, 0.5 * h, turning)
    yaw_at = _yaw_path(xp, x, torque, h, robot, rate, theta_middle)

    # moments of r over the step: ∫ r ds and ∫ (1 − s) r ds, s in [0, 1]
    r_mean = [a + h * b / 2 + h**2 * c / 6 for a, b, c in zip(x.r, x.dr, ddr, strict=True)]
    r_second = [a / 2 + h * b / 6 + h**2 * c / 24 for a, b, c in zip(x.r, x.dr, ddr, strict=True)]
    L_end, L_mean = L_from_outside
    feet_end, feet_middle = [], []
    for i, (foot, inputs) in enumerate(zip(x.feet, u, strict=True)):
        ground, offset = None if grounds is None else grounds[i], offsets[i]
        velocities = [_velocity(xp, robot, i, foot, inputs, h, c, yaw_at) for c in POINTS]
        rates = [[*v, w] for v, w in zip(velocities, inputs.lift_rate, strict=True)]
        if ground is not None:
            for c, rate_there in zip(POINTS, rates, strict=True):
                rate_there[2] = rate_there[2] + _climb(ground, foot.p, rate_there, c * h)
        p_end = _moment(foot.p, rates, h, 1.0, (0.5, 0.5))
        p_mean = _beside(_moment(foot.p, rates, h, 1.0, [0.5 * (1 - c) for c in POINTS]), 1.0, offset)
        second = _moment(foot.p, rates, h, 0.5, [0.25 * (1 - c) ** 2 for c in POINTS])
        p_second = _beside(second, 0.5, offset)
        L_end = _add(L_end, h, _cross(inputs.force, _minus(r_mean, p_mean)))
        L_mean = _add(L_mean, h, _cross(inputs.force, _minus(r_second, p_second)))
        turn = h * inputs.motion[1] if robot.kinds[i] == "steerable" else 0.0
        middle = _velocity(xp, robot, i, foot, inputs, h, 0.25, yaw_at)
        p_middle = _middle(foot.p, middle, inputs.lift_rate, h)
        if ground is not None:  # on the surface exactly, whatever the quadrature of its slope says
            above = foot.p[2] - ground.height(foot.p)
            lifts = inputs.lift_rate
            p_end[2] = ground.height(p_end) + above + 0.5 * h * (lifts[0] + lifts[1])
            p_middle[2] = ground.height(p_middle) + above + (p_middle[2] - foot.p[2])
        feet_end.append(FootState(p_end, foot.sigma + turn))
        feet_middle.append(FootState(p_middle, foot.sigma + 0.5 * turn))

    theta_end = _add(x.theta, h, euler_rate(xp, theta_middle, L_mean, robot))
    end = State(
        r=[a + h * b + h**2 * c / 2 for a, b, c in zip(x.r, x.dr, ddr, strict=True)],
        theta=theta_end,
        dr=_add(x.dr, h, ddr),
        L=L_end,
        feet=tuple(feet_end),
    )
    middle_state = State(
        r=[a + h * b / 2 + h**2 * c / 8 for a, b, c in zip(x.r, x.dr, ddr, strict=True)],
        theta=theta_middle,
        dr=_add(x.dr, 0.5 * h, ddr),
        L=L_mean,
        feet=tuple(feet_middle),
    )
    return end, middle_state


def euler_rate(xp: Any, theta: Vector, L: Vector, robot: Figures) -> list[Scalar]:
    """θ̇ from L: ω in the base frame is I_B⁻¹ Rᵀ L, and that turns into (yaw, pitch, roll) rates, rad/s."""
    R = rotation(xp, theta)
    L_base = [sum(R[j][i] * L[j] for j in range(3)) for i in range(3)]
    w_x, w_y, w_z = (sum(row[j] * L_base[j] for j in range(3)) for row in robot.inertia_inverse)
    s_roll, c_roll = xp.sin(theta[2]), xp.cos(theta[2])
    yaw_rate = (s_roll * w_y + c_roll * w_z) / xp.cos(theta[1])
    return [yaw_rate, c_roll * w_y - s_roll * w_z, w_x + yaw_rate * xp.sin(theta[1])]


def angular_momentum(xp: Any, theta: Vector, dtheta: Vector, inertia: Sequence[Vector]) -> list[Scalar]:
    """L = R I_B ω_base from θ and θ̇: the inverse of `euler_rate`, N·m·s, world."""
    s_pitch, c_pitch = xp.sin(theta[1]), xp.cos(theta[1])
    s_roll, c_roll = xp.sin(theta[2]), xp.cos(theta[2])
    omega = [
        dtheta[2] - dtheta[0] * s_pitch,
        dtheta[1] * c_roll + dtheta[0] * c_pitch * s_roll,
        -dtheta[1] * s_roll + dtheta[0] * c_pitch * c_roll,
    ]
    L_base = [sum(row[j] * omega[j] for j in range(3)) for row in inertia]
    R = rotation(xp, theta)
    return [sum(R[i][j] * L_base[j] for j in range(3)) for i in range(3)]


def rotation(xp: Any, theta: Vector) -> list[list[Scalar]]:
    """R(θ) = Rz Ry Rx, base to world, as rows."""
    (c_z, s_z), (c_y, s_y), (c_x, s_x) = ((xp.cos(a), xp.sin(a)) for a in theta)
    return [
        [c_z * c_y, c_z * s_y * s_x - s_z * c_x, c_z * s_y * c_x + s_z * s_x],
        [s_z * c_y, s_z * s_y * s_x + c_z * c_x, s_z * s_y * c_x - c_z * s_x],
        [-s_y, c_y * s_x, c_y * c_x],
    ]


def rotations(euler: NDArray[np.float64]) -> NDArray[np.float64]:
    """R(θ), base to world, (n, 3, 3), of Euler angles (n, 3)."""
    return np.moveaxis(np.array(rotation(np, list(euler.T))), -1, 0)


def _yaw_path(
    xp: Any, x: State, torque: Vector, h: Scalar, robot: Figures, rate: Vector, theta_middle: Vector
) -> Any:
    """Yaw at a fraction of the step, for fixed wheels: quadratic, from the rates at begin and middle."""
    if "fixed" not in robot.kinds:
        return lambda c: x.theta[0]
    rate_middle = euler_rate(xp, theta_middle, _add(x.L, 0.5 * h, torque), robot)
    return lambda c: x.theta[0] + c * h * rate[0] + c**2 * h * (rate_middle[0] - rate[0])


def _velocity(
    xp: Any, robot: Figures, i: int, foot: FootState, u: FootInput, h: Scalar, c: float, yaw_at: Any
) -> list[Scalar]:
    """Planar velocity of a foot at the fraction c of the step."""
    kind = robot.kinds[i]
    sigma = foot.sigma + c * h * u.motion[1] if kind == "steerable" else foot.sigma
    yaw = yaw_at(c) if kind == "fixed" else 0.0
    return list(planar_motion(xp, kind, u.motion, sigma, yaw, 0.0, robot.heading_offset[i]).velocity)


def _moment(
    p: Vector, rates: Sequence[Vector], h: Scalar, of_p: float, weights: Sequence[float]
) -> list[Scalar]:
    """of_p · p + h Σ weight_j ṗ_j."""
    weighted = list(zip(weights, rates, strict=True))
    return [of_p * p[a] + h * sum(w * rate[a] for w, rate in weighted) for a in range(3)]


def _middle(p: Vector, velocity: Vector, lift_rate: Vector, h: Scalar) -> list[Scalar]:
    """The contact point in the middle of the step; the height's parabola exactly."""
    c1, c2 = POINTS
    # ∫₀^½ of the lines with value 1 at one point and 0 at the other
    first, second = (0.125 - 0.5 * c2) / (c1 - c2), (0.125 - 0.5 * c1) / (c2 - c1)
    z = p[2] + h * (first * lift_rate[0] + second * lift_rate[1])
    return [p[0] + 0.5 * h * velocity[0], p[1] + 0.5 * h * velocity[1], z]


def _climb(ground: FootGround, p: Vector, rate: Vector, passed: Scalar) -> Scalar:
    """How fast the surface rises under a foot that has moved for some time at a rate."""
    slope = ground.slope([p[0] + passed * rate[0], p[1] + passed * rate[1]])
    return slope[0] * rate[0] + slope[1] * rate[1]


def _beside(p: Vector, factor: float, offset: Vector | None) -> Vector:
    """The contact of a foot whose lowest point is p."""
    return p if offset is None else _add(p, factor, offset)


def _cross(a: Vector, b: Vector) -> list[Scalar]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _minus(a: Vector, b: Vector) -> list[Scalar]:
    return [p - q for p, q in zip(a, b, strict=True)]


def _add(a: Vector, factor: Scalar, b: Vector) -> list[Scalar]:
    return [p + factor * q for p, q in zip(a, b, strict=True)]
