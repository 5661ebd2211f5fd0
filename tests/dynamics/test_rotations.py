"""Laws of rotations, over random angles."""

import numpy as np
import pytest
from hypothesis import given
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rollgait.dynamics.rotations import R_world_base, R_x, R_y, R_z, euler_axes, euler_axes_rate
from tests.expressions import numbers, value, vectors

Array = NDArray[np.float64]

STEP = 1e-6
"""s; of central differences."""

angles = vectors(3, np.pi)
rates = vectors(3, 3.0)


def cross_matrix(w: Array) -> Array:
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


@given(angles)
def test_R_is_a_rotation(theta: Array) -> None:
    R = value(R_world_base(theta))
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)


@given(angles)
def test_R_turns_by_yaw_then_pitch_then_roll(theta: Array) -> None:
    np.testing.assert_allclose(
        value(R_world_base(theta)), Rotation.from_euler("ZYX", theta).as_matrix(), atol=1e-12
    )


@given(numbers(np.pi))
def test_elementary_rotations_turn_in_the_right_hand_sense(angle: float) -> None:
    c, s = np.cos(angle), np.sin(angle)
    np.testing.assert_allclose(value(R_z(angle)) @ [1, 0, 0], [c, s, 0], atol=1e-12)
    np.testing.assert_allclose(value(R_y(angle)) @ [0, 0, 1], [s, 0, c], atol=1e-12)
    np.testing.assert_allclose(value(R_x(angle)) @ [0, 1, 0], [0, c, s], atol=1e-12)


@given(angles, rates)
def test_angular_velocity_is_that_of_the_rotation(theta: Array, dtheta: Array) -> None:
    """[ω]× = Ṙ Rᵀ with ω = E θ̇."""
    after, before = (value(R_world_base(theta + sign * STEP * dtheta)) for sign in (1, -1))
    R_rate = (after - before) / (2 * STEP)
    omega = value(euler_axes(theta)) @ dtheta
    np.testing.assert_allclose(R_rate @ value(R_world_base(theta)).T, cross_matrix(omega), atol=1e-7)


@given(angles, rates)
def test_rate_of_the_euler_axes(theta: Array, dtheta: Array) -> None:
    after, before = (value(euler_axes(theta + sign * STEP * dtheta)) for sign in (1, -1))
    np.testing.assert_allclose(
        value(euler_axes_rate(theta, dtheta)), (after - before) / (2 * STEP), atol=1e-7
    )


@given(angles)
def test_euler_axes_fail_only_when_pitch_is_a_right_angle(theta: Array) -> None:
    assert abs(np.linalg.det(value(euler_axes(theta)))) == pytest.approx(abs(np.cos(theta[1])), abs=1e-12)
