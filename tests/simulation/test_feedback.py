"""Feedback of the base pose asks every kind of foot only for what it can do."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="needs the extra whole-body")
pytest.importorskip("pinocchio", reason="needs the extra whole-body")
pytest.importorskip("daqp", reason="needs the extra whole-body")

import mujoco

import rollgait as rg
from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.robot.whole_body import find_whole_body, load_whole_body
from rollgait.simulation.feedback import PERIOD, SWAY_TIME, TILT_SHARE, BaseFeedback
from rollgait.simulation.leg_shift import LegShift
from rollgait.simulation.report import rotation_matrices
from rollgait.simulation.world import World, build_world
from tests.robot.lookalikes import LOOKALIKES

FIXTURES = Path(__file__).parent.parent / "fixtures"
MOTIONS = ("rover-crawl", "strider-crawl")


@pytest.fixture(scope="module", params=MOTIONS)
def stepping(request: pytest.FixtureRequest) -> rg.JointTrajectory:
    """A crawl on fixed wheels, or on point feet."""
    return rg.track(rg.plan(request.param))


def world_of(joints: rg.JointTrajectory) -> World:
    return build_world(find_whole_body(joints.robot), joints.joint_names)


def data_at(
    world: World, joints: rg.JointTrajectory, k: int, away: tuple[float, float] = (0.0, 0.0), yaw: float = 0.0
) -> "mujoco.MjData":
    """The robot as it is planned at a sample, its base as fast as planned, but moved and turned."""
    data = mujoco.MjData(world.model)
    x, y, z, w = joints.base_quaternion[k]
    turn, before, now = (
        np.array([np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)]),
        np.array([w, x, y, z]),
        np.empty(4),
    )
    mujoco.mju_mulQuat(now, turn, before)
    world.put(data, joints.base_position[k] + [*away, 0.0], np.roll(now, -1), joints.joint_position[k])
    R_planned = rotation_matrices(joints.base_quaternion[k : k + 1])[0]
    data.qvel[:3] = R_planned @ joints.base_velocity[k, :3]
    data.qvel[3:6] = joints.base_velocity[k, 3:]
    mujoco.mj_forward(world.model, data)
    return data


def asked(
    joints: rg.JointTrajectory, away: tuple[float, float], yaw: float, seconds: float
) -> tuple[World, np.ndarray]:
    """Δq (n_j,) after the base has been off for some time from the start on."""
    world = world_of(joints)
    feedback = BaseFeedback(world, joints)
    data = data_at(world, joints, 0, away, yaw)
    for _ in range(round(seconds / PERIOD)):
        shift, _ = feedback.update(0.0, data)
    return world, shift


def rolled_and_moved(
    joints: rg.JointTrajectory, world: World, shift: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """By what the wheels roll at the start, (4,), rad, and the feet move from the base, (4, 3), m."""
    before, after = data_at(world, joints, 0), data_at(world, joints, 0)
    after.qpos[world.position] += shift
    mujoco.mj_kinematics(world.model, after)
    feet = list(world.feet)
    rolled = np.zeros(4)
    for leg, foot in enumerate(feet):
        R = after.geom_xmat[foot].reshape(3, 3) @ before.geom_xmat[foot].reshape(3, 3).T
        rolled[leg] = np.arctan2(R[0, 2] - R[2, 0], R[0, 0] + R[2, 2])
    return rolled, after.geom_xpos[feet] - before.geom_xpos[feet]


def test_a_yaw_error_is_for_the_legs(stepping: rg.JointTrajectory) -> None:
    """No wheel rolls; feet turn about the base as a rigid body, the other way than the base shall."""
    world, shift = asked(stepping, (0.0, 0.0), np.radians(-2.0), 0.2)
    rolled, moved = rolled_and_moved(stepping, world, shift)
    np.testing.assert_allclose(rolled[np.array([w is not None for w in world.wheels])], 0.0, atol=1e-4)
    lever = stepping.reference.foot_position[0] - stepping.base_position[0]
    across = lever[:, 0] * moved[:, 1] - lever[:, 1] * moved[:, 0]
    angle = across / np.sum(lever[:, :2] ** 2, axis=1)
    assert np.all(angle < -1e-3)
    assert np.ptp(angle) < 1e-4
    np.testing.assert_allclose(moved[:, 2], 0.0, atol=1e-4)


def test_wheels_that_cannot_steer_roll_alike_and_only_along_their_heading(
    stepping: rg.JointTrajectory,
) -> None:
    world, shift = asked(stepping, (-0.01, -0.005), 0.0, 0.2)
    rolled, moved = rolled_and_moved(stepping, world, shift)
    has_wheels = all(wheel is not None for wheel in world.wheels)
    if has_wheels:
        assert np.all(rolled > 0.01)
        assert np.ptp(rolled) < 1e-4
    expected = -0.2 * np.array([0.0 if has_wheels else 0.01, 0.005])  # what 1/s takes back
    np.testing.assert_allclose(moved[:, :2], np.tile(expected, (4, 1)), atol=1e-4)


@pytest.mark.parametrize("velocity", [(0.1, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.3), (-0.1, 0.05, 0.1)])
def test_feet_that_stand_go_along_with_a_base_that_sways(
    stepping: rg.JointTrajectory, velocity: tuple[float, float, float]
) -> None:
    """The same share of the speed that each foot would have, fixed to the base; no wheel rolls for it."""
    world = world_of(stepping)
    feedback, data = BaseFeedback(world, stepping), data_at(world, stepping, 0)
    data.qvel[[0, 1, 5]] += velocity
    for _ in range(3):  # a Newton step each
        shift, _ = feedback.update(0.0, data)
    rolled, moved = rolled_and_moved(stepping, world, shift)
    lever = stepping.reference.foot_position[0, :, :2] - stepping.base_position[0, :2]
    speed = velocity[:2] + velocity[2] * np.stack([-lever[:, 1], lever[:, 0]], axis=1)
    assert moved[:, :2] == pytest.approx(SWAY_TIME * speed, abs=2e-4)
    assert moved[:, 2] == pytest.approx(np.zeros(4), abs=2e-4)
    if stepping.robot.legs.FL.foot == "fixed":
        assert rolled == pytest.approx(np.zeros(4), abs=2e-3)


@pytest.mark.parametrize("tilt", [(0.02, 0.0, 0.0), (0.0, 0.02, 0.0), (-0.01, 0.015, 0.0)])
def test_legs_level_a_base_that_tilts(stepping: rg.JointTrajectory, tilt: tuple[float, float, float]) -> None:
    """Feet go down from the base where the base is too low, as a rigid body, by a share of the tilt."""
    world = world_of(stepping)
    feedback, data = BaseFeedback(world, stepping), data_at(world, stepping, 0)
    tilted = np.empty(4)
    angle = np.linalg.norm(tilt)
    turn = np.array([np.cos(angle / 2), *(np.sin(angle / 2) * np.array(tilt) / angle)])
    mujoco.mju_mulQuat(tilted, turn, data.qpos[3:7])
    data.qpos[3:7] = tilted
    for _ in range(3):  # a Newton step each
        shift, _ = feedback.update(0.0, data)
    _, moved = rolled_and_moved(stepping, world, shift)
    lever = stepping.reference.foot_position[0] - stepping.base_position[0]
    rises = np.cross(np.array(tilt), lever)[:, 2]
    assert moved[:, 2] == pytest.approx(TILT_SHARE * rises, abs=2e-4)


def test_a_robot_on_soft_legs_tilts_less(
    stepping: rg.JointTrajectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    tilts = []
    for share in (TILT_SHARE, 0.0):
        monkeypatch.setattr("rollgait.simulation.feedback.TILT_SHARE", share)
        tilts.append(rg.simulate(stepping, feedback=True).report().tilt_error)
    assert tilts[0] < 0.95 * tilts[1]


def test_a_base_that_is_pushed_sways_less(
    stepping: rg.JointTrajectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    weight = stepping.robot.weight
    push = rg.Disturbances(pushes=(rg.Push(force=0.1 * weight, direction_deg=90.0, start=1.0),))
    swaying = []
    for share in (1.0, 0.0):
        monkeypatch.setattr("rollgait.simulation.feedback.SWAY_TIME", share * SWAY_TIME)
        swaying.append(rg.simulate(stepping, push, feedback=True).report().com_rms)
    assert swaying[0] < 0.95 * swaying[1]


def test_a_foot_in_the_air_goes_where_it_was_planned_in_the_world(stepping: rg.JointTrajectory) -> None:
    contact = stepping.reference.contact
    begin = int(np.argmin(contact.all(axis=1)))
    leg = int(np.argmin(contact[begin]))
    k = begin + int(np.argmax(contact[begin:, leg])) // 2
    world = world_of(stepping)
    feedback = BaseFeedback(world, stepping)
    yaw = np.radians(1.0)
    data = data_at(world, stepping, k, (0.0, 0.01), yaw)
    for _ in range(200):
        shift, _ = feedback.update(float(stepping.time[k]), data)
    data.qpos[world.position] += shift
    mujoco.mj_kinematics(world.model, data)
    planned = data_at(world, stepping, k)
    missing = (data.geom_xpos[world.feet[leg]] - planned.geom_xpos[world.feet[leg]])[:2]
    assert np.abs(missing).max() < 1e-3  # of 17 mm: the orientation that a leg cannot keep pulls at it


@pytest.mark.parametrize("name", ["roller", "hyq", "centauro"])
def test_joints_shift_the_feet_as_far_as_asked(name: str) -> None:
    body = (
        find_whole_body(rg.find_robot(name))
        if name == "centauro"
        else load_whole_body(FIXTURES / f"{name}.yaml")
    )

    model = WholeBodyModel(body)
    world = build_world(body, model.joint_names)
    q, wanted = model.posture, np.array([[0.02, -0.01, 0.0]] * 4)
    legs = LegShift(world)
    for _ in range(5):
        legs.update(q[:3], q[3:7], q[7:], wanted)
    before, after = (mujoco.MjData(world.model) for _ in range(2))
    for data, shift in ((before, 0.0), (after, legs.joints)):
        world.put(data, q[:3], q[3:7], q[7:] + shift)
        mujoco.mj_kinematics(world.model, data)
    feet = list(world.feet)
    np.testing.assert_allclose(after.geom_xpos[feet] - before.geom_xpos[feet], wanted, atol=1e-4)
    for _ in range(5):
        legs.update(q[:3], q[3:7], q[7:], np.zeros((4, 3)))
    np.testing.assert_allclose(legs.joints, 0.0, atol=1e-3)


@pytest.mark.parametrize(
    ("name", "can"), [("fixed-plain", True), ("fixed-planar", False), ("point-small", True)]
)
def test_legs_without_a_joint_for_it_are_not_asked_to_move_sideways(
    name: str, can: bool, tmp_path: Path
) -> None:
    urdf = tmp_path / f"{name}.urdf"
    urdf.write_text(LOOKALIKES[name].urdf())
    model = WholeBodyModel(rg.import_robot(urdf).body)
    q = model.posture
    world = build_world(model.config, model.joint_names)
    assert LegShift(world).moves_all_ways(q[:3], q[3:7], q[7:]) == can


def test_with_feedback_robots_without_steering_end_on_their_plans(stepping: rg.JointTrajectory) -> None:
    report = rg.simulate(stepping, feedback=True).report()
    assert not report.fallen
    assert report.final_distance < 0.01
    assert report.final_angle < np.radians(1.0)
