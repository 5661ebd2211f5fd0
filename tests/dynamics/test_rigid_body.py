"""Laws of the single rigid body."""

import numpy as np
from hypothesis import given
from numpy.typing import NDArray

from rollgait.dynamics.rigid_body import (
    acceleration,
    angular_momentum,
    inertia_world,
    momentum_rate,
    torque_about_com,
)
from rollgait.dynamics.rotations import R_world_base, euler_axes
from rollgait.robot.library import find_robot
from rollgait.robot.robot import GRAVITY
from tests.expressions import value, vectors

Array = NDArray[np.float64]

I_B = find_robot("centauro-2020").inertia_matrix
STEP = 1e-5
"""s; of central differences."""

angles = vectors(3, 1.5)
rates = vectors(3, 2.0)


def test_without_forces_it_falls() -> None:
    np.testing.assert_array_equal(value(acceleration(80.0, [])), [0.0, 0.0, -GRAVITY])


@given(vectors(3, 100.0))
def test_forces_accelerate_the_centre_of_mass(force: Array) -> None:
    weight = np.array([0.0, 0.0, 80.0 * GRAVITY])
    np.testing.assert_allclose(value(acceleration(80.0, [force, weight])), force / 80.0, atol=1e-12)


@given(vectors(3, 1.0), vectors(12, 1.0), vectors(12, 500.0), vectors(3, 2.0))
def test_torque_is_about_the_centre_of_mass(r: Array, feet: Array, forces: Array, shift: Array) -> None:
    p, f = feet.reshape(4, 3), forces.reshape(4, 3)
    torque = value(torque_about_com(r, list(p), list(f)))
    np.testing.assert_allclose(torque, np.cross(p - r, f).sum(axis=0), atol=1e-9)
    np.testing.assert_allclose(
        value(torque_about_com(r + shift, list(p + shift), list(f))), torque, atol=1e-8
    )
    np.testing.assert_allclose(
        value(torque_about_com(r, list(p + 0.01 * f), list(f))), torque, atol=1e-8, err_msg="along its line"
    )


@given(angles)
def test_inertia_keeps_its_principal_moments(theta: Array) -> None:
    I_W = value(inertia_world(I_B, theta))
    np.testing.assert_allclose(I_W, I_W.T, atol=1e-12)
    np.testing.assert_allclose(np.linalg.eigvalsh(I_W), np.linalg.eigvalsh(I_B), atol=1e-10)


def test_a_quarter_turn_exchanges_the_moments_about_x_and_y() -> None:
    """Inertia is constant in the base frame, not in the world."""
    I_W = value(inertia_world(np.diag([1.0, 2.0, 3.0]), np.array([np.pi / 2, 0.0, 0.0])))
    np.testing.assert_allclose(I_W, np.diag([2.0, 1.0, 3.0]), atol=1e-12)


@given(angles, rates)
def test_angular_momentum_is_inertia_times_angular_velocity(theta: Array, dtheta: Array) -> None:
    omega = value(euler_axes(theta)) @ dtheta
    np.testing.assert_allclose(
        value(angular_momentum(I_B, theta, dtheta)), value(inertia_world(I_B, theta)) @ omega, atol=1e-10
    )


@given(angles, rates, rates)
def test_momentum_rate_is_the_derivative_of_angular_momentum(
    theta: Array, dtheta: Array, ddtheta: Array
) -> None:
    def momentum(t: float) -> Array:
        return value(angular_momentum(I_B, theta + t * dtheta + 0.5 * t**2 * ddtheta, dtheta + t * ddtheta))

    difference = (momentum(STEP) - momentum(-STEP)) / (2 * STEP)
    np.testing.assert_allclose(
        value(momentum_rate(I_B, theta, dtheta, ddtheta)), difference, rtol=1e-6, atol=1e-6
    )


@given(angles, rates, rates, vectors(3, 3.0))
def test_a_turned_world_turns_the_momentum_rate(
    theta: Array, dtheta: Array, ddtheta: Array, yaw: Array
) -> None:
    turn = np.array([yaw[0], 0.0, 0.0])
    np.testing.assert_allclose(
        value(momentum_rate(I_B, theta + turn, dtheta, ddtheta)),
        value(R_world_base(turn)) @ value(momentum_rate(I_B, theta, dtheta, ddtheta)),
        atol=1e-9,
    )
