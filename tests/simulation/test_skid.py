"""A skid turn in MuJoCo: with feedback the robot ends where it is planned."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="needs the extra whole-body")
pytest.importorskip("pinocchio", reason="needs the extra whole-body")
pytest.importorskip("daqp", reason="needs the extra whole-body")

import rollgait as rg
from rollgait.tracking.skid import SLIPS, spin
from tests.simulation.test_feedback import asked, rolled_and_moved
from tests.skidding import SLIP_MAX, turning


@pytest.fixture(scope="module")
def plan() -> rg.Plan:
    return rg.plan(turning(30.0))


@pytest.fixture(scope="module")
def joints(plan: rg.Plan) -> rg.JointTrajectory:
    return rg.track(plan)


def test_rims_slide_against_their_friction(plan: rg.Plan) -> None:
    samples = plan.sample(np.linspace(0.0, plan.horizon, 61))
    c, s = np.cos(samples.heading), np.sin(samples.heading)
    vx, vy = samples.foot_velocity[..., 0], samples.foot_velocity[..., 1]
    slip, faster = c * vy - s * vx, spin(plan, samples)
    along = c * samples.force[..., 0] + s * samples.force[..., 1]
    left = c * samples.force[..., 1] - s * samples.force[..., 0]
    slides = (np.abs(slip) > SLIPS) & (left * slip < 0.0) & (np.abs(faster) < SLIP_MAX)
    assert slides.any()
    # the contact point moves by (−faster, slip): parallel to the force, and against it
    np.testing.assert_allclose(-faster[slides] * left[slides], slip[slides] * along[slides], atol=1e-9)
    assert np.all(-faster[slides] * along[slides] + slip[slides] * left[slides] < 0.0)
    np.testing.assert_array_equal(faster[np.abs(slip) <= SLIPS], 0.0)


def test_it_ends_where_it_is_planned(joints: rg.JointTrajectory) -> None:
    report = rg.simulate(joints, feedback=True).report()
    assert not report.fallen
    assert report.final_distance < 0.01
    assert abs(report.final_yaw) < np.radians(1.0)


def test_a_yaw_error_is_for_the_wheels(joints: rg.JointTrajectory) -> None:
    """To turn the base to the right the wheels on the left roll ahead, those on the right back."""
    world, shift = asked(joints, (0.0, 0.0), np.radians(2.0), 0.2)
    rolled, _ = rolled_and_moved(joints, world, shift)
    left = joints.reference.foot_position[0, :, 1] > 0.0
    assert np.all(rolled[left] > 0.0)
    assert np.all(rolled[~left] < 0.0)
