"""Laws of angles in numbers."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from rollgait.angles import angular_velocity, euler_angles, euler_rates, near, turned
from rollgait.dynamics.step import rotation
from tests.expressions import numbers, vectors

Array = np.ndarray
orientations = st.tuples(numbers(3.0), numbers(1.5), numbers(3.0)).map(np.array)


@given(orientations)
def test_angles_are_found_again_from_the_rotation(euler: Array) -> None:
    R = np.array(rotation(np, list(euler)))
    np.testing.assert_allclose(R, Rotation.from_euler("ZYX", euler).as_matrix(), atol=1e-12)
    np.testing.assert_allclose(euler_angles(R), euler, atol=1e-9)


@given(orientations, vectors(3, 5.0))
def test_rates_are_found_again_from_the_angular_velocity(euler: Array, rates: Array) -> None:
    np.testing.assert_allclose(euler_rates(euler, angular_velocity(euler, rates)), rates, atol=1e-9)


@given(orientations, vectors(3, 1.0))
def test_angular_velocity_is_how_the_rotation_turns(euler: Array, rates: Array) -> None:
    """[ω]× = Ṙ Rᵀ."""
    h = 1e-4
    before, after = (Rotation.from_euler("ZYX", euler + sign * h * rates) for sign in (-0.5, 0.5))
    turn = (after * before.inv()).as_rotvec() / h
    np.testing.assert_allclose(angular_velocity(euler, rates), turn, atol=1e-6)


@given(vectors(3, 5.0), numbers(10.0))
def test_turned_is_a_rotation_about_the_vertical(vector: Array, yaw: float) -> None:
    np.testing.assert_allclose(turned(vector, yaw), Rotation.from_euler("z", yaw).apply(vector), atol=1e-12)


@given(numbers(100.0), numbers(100.0))
def test_near_is_the_same_angle_within_half_a_turn(angle: float, reference: float) -> None:
    found = near(angle, reference)
    assert abs(found - reference) <= np.pi + 1e-9
    np.testing.assert_allclose([np.cos(found), np.sin(found)], [np.cos(angle), np.sin(angle)], atol=1e-9)
