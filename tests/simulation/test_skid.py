"""A skid turn in MuJoCo: with feedback the robot ends where it is planned."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("mujoco", reason="needs the extra whole-body")
pytest.importorskip("pinocchio", reason="needs the extra whole-body")
pytest.importorskip("daqp", reason="needs the extra whole-body")

import rollgait as rg
from rollgait.simulation.skid_feedback import TURN_GAIN, TURN_MAX, leading, turning_rims, unwinding
from rollgait.tracking.skid import SLIPS, spin
from tests.robot.lookalikes import LOOKALIKES
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


LENGTHS = st.floats(0.1, 0.6)
TURNS = st.floats(-1.0, 1.0).filter(lambda turn: abs(turn) > 1e-3)


def rectangle(a: float, b: float) -> np.ndarray:
    return np.array([[a, b], [a, -b], [-a, b], [-a, -b]])


@given(LENGTHS, LENGTHS, TURNS)
def test_friction_of_sliding_wheels_has_no_moment_at_the_rate_asked(a: float, b: float, turn: float) -> None:
    lever = rectangle(a, b)
    rate = float(np.clip(TURN_GAIN * turn, -TURN_MAX, TURN_MAX))
    slip = np.stack([-lever[:, 1] * rate - turning_rims(lever, turn, 0.0), lever[:, 0] * rate], axis=1)
    force = -slip / np.linalg.norm(slip, axis=1, keepdims=True)
    moment = np.sum(lever[:, 0] * force[:, 1] - lever[:, 1] * force[:, 0])
    np.testing.assert_allclose(moment, 0.0, atol=1e-9)
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-9)


@given(LENGTHS, LENGTHS, TURNS, st.floats(-0.1, 0.1))
def test_turning_is_the_same_in_a_mirror(a: float, b: float, turn: float, aside: float) -> None:
    lever = rectangle(a, b)
    right = turning_rims(lever * [1.0, -1.0], -turn, -aside)
    np.testing.assert_allclose(right, turning_rims(lever, turn, aside), rtol=1e-12)


@given(LENGTHS, LENGTHS, TURNS, st.floats(0.001, 0.1))
def test_the_end_that_must_go_aside_slides_more_easily(a: float, b: float, turn: float, aside: float) -> None:
    """Turning to the left moves the front to the left: a base that should be there goes with it."""
    rims = np.abs(turning_rims(rectangle(a, b), turn, aside))
    in_front_more = rims[:2].min() > rims[2:].max()
    assert in_front_more == (turn > 0.0)


@given(st.floats(-0.1, 0.1), st.floats(-0.5, 0.5))
def test_a_base_that_drives_turns_towards_its_way(aside: float, speed: float) -> None:
    """Driving back it turns the other way; at rest not at all."""
    turn = leading(aside, speed)
    assert turn * aside * speed >= 0.0
    assert turn == -leading(-aside, speed) == -leading(aside, -speed)
    assert leading(aside, 0.0) == 0.0


def test_wheels_that_are_where_they_should_be_are_left_there() -> None:
    np.testing.assert_array_equal(unwinding(np.zeros(4)), 0.0)
    wound = np.array([0.1, -0.1, 0.02, 0.0])
    assert np.all(unwinding(wound) * wound <= 0.0)


@pytest.fixture(scope="module")
def planar(tmp_path_factory: pytest.TempPathFactory) -> rg.JointTrajectory:
    """Legs that move in planes only turn the base by skidding."""
    folder: Path = tmp_path_factory.mktemp("planar")
    urdf = folder / "planar.urdf"
    urdf.write_text(LOOKALIKES["fixed-planar"].urdf(), encoding="utf-8")
    files = rg.import_robot(urdf).save(folder / "planar.yaml")
    data = rg.find_robot(str(files.robot)).model_dump()
    for leg in data["legs"].values():
        leg["slip_max"] = 0.05
    return rg.track(rg.plan(turning(8.0, robot=rg.Robot.model_validate(data))))


@pytest.mark.parametrize("friction", [0.5, 0.8])
def test_legs_without_hip_roll_turn_the_base_by_skidding(planar: rg.JointTrajectory, friction: float) -> None:
    log = rg.simulate(planar, rg.Disturbances(friction=friction), feedback=True)
    report = log.report()
    assert report.final_distance < 0.01
    assert report.final_angle < np.radians(1.0)
    assert np.isfinite(log.slip).mean() > 0.98  # what slides stays on the ground
