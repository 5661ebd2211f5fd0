"""Laws of the judge's own rigid body, feet and dense sampling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import tests.plan.builders as b
from rollgait.plan.certificate import motion as dense
from rollgait.plan.certificate.limits import joint_angles, reach
from rollgait.plan.certificate.physics import (
    BodyState,
    Inputs,
    angular_velocity_world,
    derivative,
    in_yaw_frame,
    rotation_angle,
    rotation_world_base,
)
from rollgait.robot.robot import Inertia, Limb

angles = st.floats(-np.pi, np.pi)
rates = st.floats(-3.0, 3.0)
eulers = st.tuples(angles, angles, angles).map(np.array)
vectors = st.tuples(rates, rates, rates).map(np.array)


def rot_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@given(eulers)
def test_rotation_is_one(euler: np.ndarray) -> None:
    R = rotation_world_base(euler)
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)


@given(eulers)
def test_rotation_is_that_of_the_convention(euler: np.ndarray) -> None:
    """R = Rz Ry Rx: base z shows the order of the angles."""
    yaw, pitch, roll = euler
    y_axis = np.array([[np.cos(pitch), 0, np.sin(pitch)], [0, 1, 0], [-np.sin(pitch), 0, np.cos(pitch)]])
    x_axis = np.array([[1, 0, 0], [0, np.cos(roll), -np.sin(roll)], [0, np.sin(roll), np.cos(roll)]])
    np.testing.assert_allclose(rotation_world_base(euler), rot_z(yaw) @ y_axis @ x_axis, atol=1e-12)


@given(eulers, vectors)
def test_angular_velocity_is_the_rotations_rate(euler: np.ndarray, rate: np.ndarray) -> None:
    step = 1e-6
    R_dot = (rotation_world_base(euler + step * rate) - rotation_world_base(euler - step * rate)) / (2 * step)
    x, y, z = angular_velocity_world(euler, rate)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    np.testing.assert_allclose(cross, R_dot @ rotation_world_base(euler).T, atol=1e-8)


@given(eulers, st.floats(-np.pi, np.pi))
def test_angle_between_rotations(euler: np.ndarray, turn: float) -> None:
    R = rotation_world_base(euler)
    assert rotation_angle(rot_z(turn) @ R, R) == pytest.approx(abs(turn), abs=1e-6)


@given(vectors, angles)
def test_yaw_frame_is_the_transpose_of_the_rotation(vector: np.ndarray, yaw: float) -> None:
    np.testing.assert_allclose(in_yaw_frame(vector, np.asarray(yaw)), rot_z(yaw).T @ vector, atol=1e-12)


def tumbling() -> tuple[np.ndarray, BodyState, Inputs]:
    state = BodyState(
        position=np.array([0.1, -0.2, 0.7]),
        velocity=np.array([0.3, 0.1, 2.0]),
        rotation=rotation_world_base(np.array([0.5, -0.4, 0.3])),
        angular_velocity=np.array([2.0, -3.0, 1.0]),
        foot=np.zeros((4, 3)),
        heading=np.zeros(4),
    )
    return state.flat(), state, Inputs(np.zeros((4, 3)), *np.zeros((4, 4)))


def test_states_and_inputs_survive_flattening() -> None:
    y, state, _ = tumbling()
    assert y.shape == (BodyState.SIZE,)
    np.testing.assert_array_equal(BodyState.from_flat(y).flat(), state.flat())
    u = np.arange(28.0)
    np.testing.assert_array_equal(Inputs.from_flat(u).flat(), u)


def test_free_body_keeps_angular_momentum_and_energy_and_falls() -> None:
    """Without forces: R I_B Rᵀ ω and the rotational energy are constant, and the CoM falls with g."""
    inertia = Inertia(xx=16.0, yy=18.0, zz=14.0, xz=-3.0, xy=1.0)
    body = b.robot().model_copy(update={"inertia": inertia})
    y, state, inputs = tumbling()

    def right_side(_: float, y: np.ndarray) -> np.ndarray:
        return derivative(body, BodyState.from_flat(y), inputs).flat()

    end = BodyState.from_flat(solve_ivp(right_side, (0.0, 1.0), y, "DOP853", rtol=1e-10, atol=1e-12).y[:, -1])

    def momentum(s: BodyState) -> np.ndarray:
        return s.rotation @ inertia.matrix() @ s.rotation.T @ s.angular_velocity

    np.testing.assert_allclose(momentum(end), momentum(state), rtol=1e-8)
    assert momentum(end) @ end.angular_velocity == pytest.approx(momentum(state) @ state.angular_velocity)
    assert rotation_angle(end.rotation, state.rotation) > 0.5
    np.testing.assert_allclose(end.rotation.T @ end.rotation, np.eye(3), atol=1e-8)
    fall = state.position + state.velocity - np.array([0.0, 0.0, 0.5 * b.GRAVITY])
    np.testing.assert_allclose(end.position, fall, atol=1e-9)


def test_torque_is_lever_times_force() -> None:
    """A force up at a foot ahead of the CoM lifts the nose: pitch rate is negative about y."""
    _, state, inputs = tumbling()
    state = replace(state, rotation=np.eye(3), angular_velocity=np.zeros(3), position=np.zeros(3))
    foot, force = np.zeros((4, 3)), np.zeros((4, 3))
    foot[0], force[0] = [1.0, 0.0, 0.0], [0.0, 0.0, 18.0]
    rate = derivative(b.robot(), replace(state, foot=foot), replace(inputs, force=force))
    np.testing.assert_allclose(rate.angular_velocity, [0.0, -1.0, 0.0], atol=1e-12)


@given(angles, rates, rates)
def test_a_wheel_rolls_along_its_heading(heading: float, along: float, across: float) -> None:
    _, state, inputs = tumbling()
    state = replace(state, heading=np.full(4, heading))
    ones = np.ones(4)
    moved = derivative(b.robot(), state, replace(inputs, along=along * ones, across=across * ones)).foot[2]
    np.testing.assert_allclose(in_yaw_frame(moved, np.asarray(heading)), [along, across, 0.0], atol=1e-12)


def test_dense_points_reach_both_ends_and_are_many() -> None:
    points = dense.chebyshev_points()
    assert points.size >= 10
    assert points[0] == pytest.approx(0.0, abs=2e-6)
    assert points[-1] == pytest.approx(1.0, abs=2e-6)
    assert np.all(np.diff(points) > 0.0)


@given(st.lists(rates, min_size=1, max_size=dense.SAMPLES), st.floats(0.0, 1.0))
def test_dense_interpolation_is_exact_for_polynomials(coefficients: list[float], tau: float) -> None:
    polynomial = np.polynomial.Polynomial(coefficients)
    points = dense.chebyshev_points()
    assert dense.interpolation(tau) @ polynomial(points) == pytest.approx(polynomial(tau), abs=1e-9)
    np.testing.assert_allclose(
        dense.differentiation() @ polynomial(points), polynomial.deriv()(points), atol=1e-7
    )


def test_interpolation_at_a_point_is_its_value() -> None:
    np.testing.assert_array_equal(dense.interpolation(dense.chebyshev_points()[3]), np.eye(dense.SAMPLES)[3])


LIMB = b.robot().legs.FL.limb


@given(angles, st.floats(0.1, 0.6), st.floats(-1.0, 1.0), st.sampled_from([-1, 1]))
def test_joints_put_the_wheel_where_it_is(
    hip_yaw: float, forward: float, steering: float, direction: int
) -> None:
    """Forward kinematics of the leg's plane, and back."""
    assert LIMB is not None
    limb = Limb.model_validate(LIMB.model_dump() | {"direction": direction})
    in_plane = np.array([direction * forward, limb.plane_offset, 0.0])
    foot = np.asarray(limb.hip) + rot_z(-hip_yaw) @ in_plane + np.array([0.0, 0.0, -0.6])
    hip, ankle = joint_angles(limb, foot, np.asarray(steering))
    assert np.cos(hip - hip_yaw) == pytest.approx(1.0)
    assert -(hip + ankle) == pytest.approx(steering)
    extension, radius = reach(limb, foot)
    assert extension == pytest.approx(np.hypot(forward, 0.6 - limb.ankle_height))
    assert radius == pytest.approx(np.hypot(forward, limb.plane_offset))
