"""The controller's laws, and the small functions about it. None of them needs the physics engine."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import rollgait as rg
from rollgait.errors import UnknownNameError
from rollgait.simulation.controller import (
    SMOOTHING_MAX,
    Controller,
    Gains,
    JointReference,
    gains_for,
    interpolated,
    reference_at,
)
from rollgait.simulation.report import rotation_matrices
from tests.hostile import motions

STEPS, JOINTS = 40, 3
seeds = st.integers(0, 10_000)


def setting(seed: int) -> tuple[Gains, JointReference]:
    rng = np.random.default_rng(seed)
    gains = Gains(rng.uniform(1.0, 100.0, JOINTS), rng.uniform(0.1, 10.0, JOINTS))
    return gains, JointReference(*rng.normal(size=(3, STEPS, JOINTS)))


@given(seeds)
def test_on_the_plan_only_the_feed_forward_acts(seed: int) -> None:
    gains, plan = setting(seed)
    controller = Controller(gains, plan)
    for step in range(STEPS):
        control = controller.control(step, plan.position[step])
        drive = control - gains.damping * plan.velocity[step]  # the drive takes its own damping off
        assert np.allclose(drive, plan.torque[step])


@given(seeds)
def test_the_torque_is_linear_in_the_error_and_pulls_back(seed: int) -> None:
    gains, plan = setting(seed)
    error = np.random.default_rng(seed + 1).normal(size=JOINTS)
    there, off = (Controller(gains, plan).control(5, plan.position[5] + e) for e in (0.0 * error, error))
    assert np.allclose(off - there, -gains.stiffness * error)


@given(seeds)
def test_a_shift_moves_the_plan(seed: int) -> None:
    gains, plan = setting(seed)
    shift = np.random.default_rng(seed + 2).normal(size=JOINTS)
    one, other = Controller(gains, plan), Controller(gains, plan)
    other.shift = shift
    q = plan.position[3]
    assert np.allclose(other.control(3, q + shift), one.control(3, q))


@given(seeds, st.integers(0, 10))
def test_latency_delays_the_whole_signal(seed: int, delay: int) -> None:
    gains, plan = setting(seed)
    positions = np.random.default_rng(seed + 3).normal(size=(STEPS, JOINTS))
    now, late = Controller(gains, plan), Controller(gains, plan, delay)
    fresh = np.array([now.control(k, q) for k, q in enumerate(positions)])
    old = np.array([late.control(k, q) for k, q in enumerate(positions)])
    assert np.array_equal(old[delay:], fresh[: STEPS - delay])
    assert np.all(old[:delay] == fresh[0])


@given(seeds)
def test_interpolation_is_exact_at_samples_and_constant_outside(seed: int) -> None:
    rng = np.random.default_rng(seed)
    known = np.cumsum(rng.uniform(0.01, 1.0, 8))
    values = rng.normal(size=(8, 2, 3))
    assert np.allclose(interpolated(known, known, values), values)
    outside = interpolated(np.array([known[0] - 1.0, known[-1] + 1.0]), known, values)
    assert np.allclose(outside, values[[0, -1]])
    middle = interpolated(0.5 * (known[1:] + known[:-1]), known, values)
    assert np.allclose(middle, 0.5 * (values[1:] + values[:-1]))


def test_gains_scale_with_the_weight() -> None:
    robot = rg.find_robot("centauro")
    heavy = robot.model_copy(update={"mass": 2.0 * robot.mass})
    one, two = (gains_for(r, 5, [0, 1], [4]) for r in (robot, heavy))
    assert np.allclose(two.stiffness, 2.0 * one.stiffness)
    assert np.allclose(two.damping, 2.0 * one.damping)
    assert one.stiffness[0] == pytest.approx(3000.0, rel=0.01)
    assert one.stiffness[2] == pytest.approx(1000.0, rel=0.01)


def test_wheels_by_velocity_have_no_stiffness() -> None:
    robot = rg.find_robot("centauro")
    gains = gains_for(robot, 5, [0, 1], [4], "velocity")
    assert gains.stiffness[4] == 0.0
    assert np.all(gains.damping > 0.0)
    with pytest.raises(UnknownNameError, match="velocity"):
        gains_for(robot, 5, [0, 1], [4], "speed")


@given(seeds)
def test_rotation_matrices(seed: int) -> None:
    quaternions = np.random.default_rng(seed).normal(size=(5, 4))
    assert np.allclose(rotation_matrices(quaternions), Rotation.from_quat(quaternions).as_matrix())


@pytest.mark.parametrize(("interval", "width"), [(0.05, 0.05), (0.1, 0.1), (0.4, SMOOTHING_MAX)])
def test_a_jump_of_speed_becomes_the_acceleration_over_an_interval(interval: float, width: float) -> None:
    """A joint that begins to turn at once begins to turn evenly, over the width of the average."""
    plan, step, change = motions.joints(), 1e-3, 2.0
    angle = np.maximum(plan.time - 0.5, 0.0)[:, None] * np.array([change, -change])
    planned = replace(plan, joint_position=angle, joint_torque=0.0 * angle, interval=interval)
    velocity = reference_at(planned, np.arange(0.2, 0.8, step)).velocity[100:-100, 0]
    acceleration = np.gradient(velocity, step)
    assert np.allclose(velocity[[0, -1]], [0.0, change])
    assert acceleration.max() == pytest.approx(change / width, rel=0.02)
    assert np.count_nonzero(acceleration > 0.5 * change / width) * step == pytest.approx(width, abs=2 * step)
