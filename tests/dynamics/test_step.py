"""The step of the condensed transcription against the differential equation, and its exact laws."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from rollgait.dynamics.step import (
    POINTS,
    Figures,
    FootInput,
    FootState,
    State,
    angular_momentum,
    euler_rate,
    rotation,
    step,
)
from rollgait.robot.library import find_robot
from rollgait.robot.robot import GRAVITY, FootKind
from tests.expressions import vectors

Array = NDArray[np.float64]

ROBOT = find_robot("centauro-2020")
I_B = ROBOT.inertia_matrix
KINDS: tuple[FootKind, ...] = ("steerable", "fixed", "point")
OFFSET = 0.3
"""rad; of the fixed wheels from the base's yaw."""

angles, rates = vectors(3, 1.2), vectors(3, 2.0)


def figures(kind: FootKind) -> Figures:
    return Figures(ROBOT.mass, list(np.linalg.inv(I_B)), [kind] * 4, [OFFSET] * 4)


def random_state(seed: int) -> State:
    rng = np.random.default_rng(seed)
    feet = ROBOT.stance + rng.uniform(-0.1, 0.1, (4, 3))
    sigma = rng.uniform(-2.0, 2.0, 4)
    return State(
        r=rng.uniform(-0.2, 0.2, 3),
        theta=rng.uniform(-0.5, 0.5, 3),
        dr=rng.uniform(-0.5, 0.5, 3),
        L=rng.uniform(-5.0, 5.0, 3),
        feet=tuple(FootState(p, s) for p, s in zip(feet, sigma, strict=True)),
    )


def random_inputs(seed: int) -> list[FootInput]:
    """Forces that nearly carry the robot, feet that roll, turn and lift."""
    rng = np.random.default_rng(seed + 1000)
    upward = [0.0, 0.0, ROBOT.mass * GRAVITY / 4.0]
    return [
        FootInput(upward + rng.uniform(-60.0, 60.0, 3), rng.uniform(-1.0, 1.0, 2), rng.uniform(-0.5, 0.5, 2))
        for _ in range(4)
    ]


def as_array(x: State) -> Array:
    """r, θ, ṙ, L, then p and σ foot after foot: (28,)."""
    feet = [[*foot.p, foot.sigma] for foot in x.feet]
    return np.concatenate([x.r, x.theta, x.dr, x.L, *feet]).astype(float)


def exact(x: State, u: list[FootInput], h: float, kind: FootKind) -> Array:
    """The state after h by the equations of motion, integrated to the last digits."""
    force, motion = np.array([foot.force for foot in u]), np.array([foot.motion for foot in u])
    lift = np.array([foot.lift_rate for foot in u])

    def slope(t: float, y: Array) -> Array:
        r, theta, dr, L = y[:12].reshape(4, 3)
        feet = y[12:].reshape(4, 4)
        turn = Rotation.from_euler("ZYX", theta)
        R_z, R_zy = Rotation.from_euler("Z", theta[0]), Rotation.from_euler("ZY", theta[:2])
        axes = np.column_stack([[0.0, 0.0, 1.0], R_z.apply([0.0, 1.0, 0.0]), R_zy.apply([1.0, 0.0, 0.0])])
        omega = turn.apply(np.linalg.solve(I_B, turn.inv().apply(L)))
        heading = feet[:, 3] if kind == "steerable" else np.full(4, theta[0] + OFFSET)
        along = np.column_stack([np.cos(heading), np.sin(heading)])
        across = np.column_stack([-np.sin(heading), np.cos(heading)])
        velocity = {
            "steerable": along * motion[:, :1],
            "fixed": along * motion[:, :1] + across * motion[:, 1:],
            "point": motion,
        }[kind]
        # the lift rate is linear through its values at the two points
        first, second = POINTS
        height_rate = lift[:, 0] + (lift[:, 1] - lift[:, 0]) * (t / h - first) / (second - first)
        turning = motion[:, 1] if kind == "steerable" else np.zeros(4)
        return np.concatenate(
            [
                dr,
                np.linalg.solve(axes, omega),
                force.sum(axis=0) / ROBOT.mass - [0.0, 0.0, GRAVITY],
                np.cross(feet[:, :3] - r, force).sum(axis=0),
                np.column_stack([velocity, height_rate, turning]).ravel(),
            ]
        )

    done = solve_ivp(slope, (0.0, h), as_array(x), method="DOP853", rtol=1e-13, atol=1e-14)
    return np.asarray(done.y[:, -1])


# -- accuracy ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("kind", KINDS)
def test_the_step_follows_the_equations_of_motion(kind: FootKind, seed: int) -> None:
    """θ with a local error of order 3, so that a motion is of order 2; the rest is better or exact."""
    x, u = random_state(seed), random_inputs(seed)
    errors = []
    for h in (0.1, 0.05, 0.025):
        end, _ = step(np, x, u, h, figures(kind))
        errors.append(as_array(end) - exact(x, u, h, kind))
    for error in errors:
        np.testing.assert_allclose(error[[0, 1, 2, 6, 7, 8]], 0.0, atol=1e-11, err_msg="CoM")
        np.testing.assert_allclose(error[14::4], 0.0, atol=1e-11, err_msg="heights of the feet")
        np.testing.assert_allclose(error[15::4], 0.0, atol=1e-11, err_msg="headings")
    theta, momentum = [np.linalg.norm(e[3:6]) for e in errors], [np.linalg.norm(e[9:12]) for e in errors]
    feet = [np.linalg.norm(np.concatenate([e[12::4], e[13::4]])) for e in errors]
    assert theta[0] < 5e-3
    assert_falls(theta, order=3.0)
    assert_falls(momentum, order=4.0)
    assert_falls(feet, order=4.0)


def assert_falls(errors: list[Any], order: float) -> None:
    """Each half step has an error smaller by 2 to the order, until rounding is all that is left."""
    for coarse, fine in pairwise(errors):
        assert fine < 1e-10 or np.log2(coarse / fine) > order - 0.5


@pytest.mark.parametrize("kind", KINDS)
def test_the_middle_is_where_half_a_step_leads(kind: FootKind) -> None:
    x, u, h = random_state(0), random_inputs(0), 1e-3
    _, middle = step(np, x, u, h, figures(kind))
    half, _ = step(np, x, halved(u), 0.5 * h, figures(kind))
    found, wanted = as_array(middle), as_array(half)
    np.testing.assert_allclose(found, wanted, atol=2e-5)  # h², but for L: its mean stands for its middle
    exact_parts = [0, 1, 2, 6, 7, 8, *range(14, 28, 4), *range(15, 28, 4)]
    np.testing.assert_allclose(found[exact_parts], wanted[exact_parts], atol=1e-12)


def halved(u: list[FootInput]) -> list[FootInput]:
    """The inputs of the first half of a step: the same lift, seen from the points of the half."""
    first, second = POINTS

    def lift(w: Any) -> Array:
        return np.array([w[0] + (w[1] - w[0]) * (0.5 * c - first) / (second - first) for c in POINTS])

    return [replace(foot, lift_rate=lift(foot.lift_rate)) for foot in u]


# -- laws ----------------------------------------------------------------------------------------------------


@given(angles, rates)
def test_euler_rates_and_angular_momentum_are_inverse(theta: Array, dtheta: Array) -> None:
    L = angular_momentum(np, theta, dtheta, list(I_B))
    np.testing.assert_allclose(euler_rate(np, theta, L, figures("point")), dtheta, atol=1e-10)


@given(angles)
def test_rotation_is_that_of_yaw_pitch_and_roll(theta: Array) -> None:
    wanted = Rotation.from_euler("ZYX", theta).as_matrix()
    np.testing.assert_allclose(np.array(rotation(np, theta)), wanted, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("h", [0.02, 0.1, 0.5])
def test_forces_do_work_on_the_centre_of_mass(kind: FootKind, h: float) -> None:
    """Momentum and energy of the CoM, exactly."""
    x, u = random_state(3), random_inputs(3)
    end, _ = step(np, x, u, h, figures(kind))
    force = np.sum([foot.force for foot in u], axis=0)
    weight = np.array([0.0, 0.0, ROBOT.mass * GRAVITY])
    impulse = ROBOT.mass * (np.array(end.dr) - x.dr)
    np.testing.assert_allclose(impulse, h * (force - weight), atol=1e-10)
    energy = [0.5 * ROBOT.mass * np.dot(s.dr, s.dr) + np.dot(weight, s.r) for s in (x, end)]
    assert energy[1] - energy[0] == pytest.approx(force @ (np.array(end.r) - x.r))


def standing_inputs(seed: int) -> list[FootInput]:
    return [replace(foot, motion=np.zeros(2), lift_rate=np.zeros(2)) for foot in random_inputs(seed)]


@pytest.mark.parametrize("h", [0.02, 0.1, 0.5])
def test_angular_momentum_about_the_origin(h: float) -> None:
    """With feet that stand still: Σ p × f, and the weight at the mean place of the CoM, exactly."""
    x, u = random_state(4), standing_inputs(4)
    end, _ = step(np, x, u, h, figures("point"))
    total = [np.array(s.L) + ROBOT.mass * np.cross(s.r, s.dr) for s in (x, end)]
    ddr = np.sum([foot.force for foot in u], axis=0) / ROBOT.mass - [0.0, 0.0, GRAVITY]
    r_mean = np.array(x.r) + h * np.array(x.dr) / 2 + h**2 * ddr / 6
    torque = np.sum([np.cross(foot.p, given.force) for foot, given in zip(x.feet, u, strict=True)], axis=0)
    torque += np.cross(r_mean, [0.0, 0.0, -ROBOT.mass * GRAVITY])
    np.testing.assert_allclose(total[1] - total[0], h * torque, atol=1e-9)


def test_free_flight_keeps_angular_momentum_and_nearly_the_energy() -> None:
    x = random_state(5)
    u = [replace(foot, force=np.zeros(3)) for foot in standing_inputs(5)]
    turning, errors = [figures("point")], []
    for h in (0.1, 0.05):
        end, _ = step(np, x, u, h, turning[0])
        np.testing.assert_array_equal(end.L, x.L)
        errors.append(abs(rotational_energy(end) - rotational_energy(x)))
    assert errors[0] < 1e-3
    assert np.log2(errors[0] / errors[1]) > 2.5


def rotational_energy(x: State) -> float:
    L_base = np.array(rotation(np, x.theta)).T @ np.array(x.L)
    return float(0.5 * L_base @ np.linalg.solve(I_B, L_base))


@pytest.mark.parametrize("kind", KINDS)
def test_a_turned_world_turns_the_step(kind: FootKind) -> None:
    x, u, a = random_state(6), random_inputs(6), 0.7
    end, _ = step(np, x, u, 0.1, figures(kind))
    turned_end, _ = step(np, turned(x, a), [turned_input(foot, a, kind) for foot in u], 0.1, figures(kind))
    np.testing.assert_allclose(as_array(turned_end), as_array(turned(end, a)), atol=1e-11)


def turn(a: float, v: Any) -> Array:
    return np.asarray(Rotation.from_euler("Z", a).apply(np.asarray(v, dtype=float)))


def turned(x: State, a: float) -> State:
    feet = tuple(FootState(turn(a, foot.p), foot.sigma + a) for foot in x.feet)
    return State(turn(a, x.r), np.array([x.theta[0] + a, *x.theta[1:]]), turn(a, x.dr), turn(a, x.L), feet)


def turned_input(foot: FootInput, a: float, kind: FootKind) -> FootInput:
    motion = turn(a, [*foot.motion, 0.0])[:2] if kind == "point" else foot.motion
    return FootInput(turn(a, foot.force), motion, foot.lift_rate)


# -- arithmetic ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_expressions_and_numbers_agree(kind: FootKind) -> None:
    x, u = random_state(7), random_inputs(7)
    as_expression = State(
        *(list(ca.SX(ca.DM(v)).nz) for v in (x.r, x.theta, x.dr, x.L)),
        tuple(FootState([ca.SX(c) for c in foot.p], ca.SX(foot.sigma)) for foot in x.feet),
    )
    for found, wanted in zip(
        step(ca, as_expression, u, 0.1, figures(kind)), step(np, x, u, 0.1, figures(kind)), strict=True
    ):
        parts = [*found.r, *found.theta, *found.dr, *found.L]
        parts += [c for foot in found.feet for c in (*foot.p, foot.sigma)]
        np.testing.assert_allclose([float(c) for c in parts], as_array(wanted), atol=1e-13)


@pytest.mark.parametrize("kind", KINDS)
def test_many_steps_at_once_are_the_single_steps(kind: FootKind) -> None:
    states, inputs = [random_state(s) for s in range(3)], [random_inputs(s) for s in range(3)]
    many = State(
        *(np.transpose([getattr(x, name) for x in states]) for name in ("r", "theta", "dr", "L")),
        tuple(
            FootState(
                np.transpose([x.feet[i].p for x in states]), np.array([x.feet[i].sigma for x in states])
            )
            for i in range(4)
        ),
    )
    together = [
        FootInput(
            *(np.transpose([getattr(u[i], name) for u in inputs]) for name in FootInput.__annotations__)
        )
        for i in range(4)
    ]
    lengths = np.array([0.1, 0.05, 0.2])
    end, _ = step(np, many, together, lengths, figures(kind))
    for k, (x, u, h) in enumerate(zip(states, inputs, lengths, strict=True)):
        single, _ = step(np, x, u, h, figures(kind))
        np.testing.assert_allclose(np.transpose(end.theta)[k], single.theta, atol=1e-13)
        np.testing.assert_allclose(np.transpose(end.L)[k], single.L, atol=1e-12)
        np.testing.assert_allclose(np.transpose(end.feet[1].p)[k], single.feet[1].p, atol=1e-13)
