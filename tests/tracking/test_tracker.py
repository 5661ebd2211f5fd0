"""Whole plans on the whole body: the acceptance of tracking, and what a joint trajectory promises."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pinocchio", reason="needs the extra whole-body")
pytest.importorskip("daqp", reason="needs the extra whole-body")

import rollgait as rg
from rollgait.errors import FileError, InputError, NotCertifiedError, UnknownNameError
from rollgait.robot.urdf_model import BASE_V, WholeBodyModel
from rollgait.robot.whole_body import library_whole_body
from rollgait.tracking import tasks
from rollgait.tracking.kinematics import build_stack, levels_of, step_bounds
from rollgait.tracking.stack import solve
from tests.stepping import solved, stepping

MOTIONS = ("legged-forward", "wheeled", "hybrid-forward", "hybrid-goback")


@pytest.fixture(scope="module")
def hybrid() -> rg.Plan:
    return rg.plan("hybrid-forward")


@pytest.fixture(scope="module")
def joints(hybrid: rg.Plan) -> rg.JointTrajectory:
    return rg.track(hybrid)


@pytest.fixture(scope="module")
def model() -> WholeBodyModel:
    return WholeBodyModel(library_whole_body("centauro"))


@pytest.mark.slow
@pytest.mark.parametrize("motion", MOTIONS)
def test_the_four_motions_are_followed(motion: str) -> None:
    report = rg.track(rg.plan(motion)).report
    assert report.passed
    assert report.row("foot").worst < 1e-3
    assert report.row("com").worst < 1e-3
    assert report.row("heading").worst < np.radians(0.5)
    assert report.failed_steps == 0


def test_limits_hold(joints: rg.JointTrajectory, model: WholeBodyModel) -> None:
    q, speed = joints.joint_position, np.abs(np.diff(joints.joint_position, axis=0)) * 200.0
    assert np.all(q >= model.position_lower - 1e-6)
    assert np.all(q <= model.position_upper + 1e-6)
    assert np.all(speed <= model.velocity_max + 1e-6)


def test_the_joints_lead_to_the_plan(joints: rg.JointTrajectory, model: WholeBodyModel) -> None:
    """By forward kinematics of what is stored, not by the tracker's own account."""
    plan = joints.reference
    for k in range(0, len(joints.time), 97):
        q = np.concatenate([joints.base_position[k], joints.base_quaternion[k], joints.joint_position[k]])
        state = model.state(q)
        assert np.allclose(state.p_foot, plan.foot_position[k], atol=1e-3)
        assert np.allclose(state.p_com, plan.com_position[k], atol=1e-3)


def test_wheels_roll_without_slip(joints: rg.JointTrajectory, model: WholeBodyModel) -> None:
    """The material point at a contact stands still while the foot is in stance."""
    contact = joints.reference.contact
    for k in range(100, len(joints.time) - 1, 97):
        q = np.concatenate([joints.base_position[k], joints.base_quaternion[k], joints.joint_position[k]])
        v = np.concatenate([joints.base_velocity[k], joints.joint_velocity[k]])
        slip = model.state(q).J_contact @ v
        steady = contact[k - 1 : k + 2].all(axis=0)
        assert np.linalg.norm(slip[steady][:, :2], axis=1).max() < 0.02


def test_velocities_are_those_of_the_positions(joints: rg.JointTrajectory) -> None:
    difference = (joints.joint_position[2:] - joints.joint_position[:-2]) * 100.0
    assert np.allclose(joints.joint_velocity[1:-1], difference, atol=1e-9)


def test_standing_torques_carry_the_robot(joints: rg.JointTrajectory, model: WholeBodyModel) -> None:
    """At rest at the end torques and contact forces balance gravity."""
    k = len(joints.time) - 1
    q = np.concatenate([joints.base_position[k], joints.base_quaternion[k], joints.joint_position[k]])
    gravity = model.inverse_dynamics(q, np.zeros(model.nv), np.zeros(model.nv))
    force = np.einsum("lij,li->j", model.state(q).J_contact, joints.reference.force[k])
    assert np.allclose(gravity[:3], force[:3], atol=0.05 * 117.0 * 9.81)
    assert np.allclose(joints.joint_torque[k], (gravity - force)[BASE_V:], atol=5.0)


def test_a_waist_at_a_constant_offset_is_worse_for_the_centre_of_mass(
    hybrid: rg.Plan, joints: rg.JointTrajectory
) -> None:
    waist = rg.track(hybrid, waist="base")
    assert waist.report.row("foot").worst < 1e-3
    assert waist.report.row("com").worst > 10.0 * joints.report.row("com").worst


def test_a_conflict_is_paid_by_the_lower_level(model: WholeBodyModel) -> None:
    """Told to be 1 m higher than its legs reach, the body stays below, and the feet stay on the ground."""
    stack, state = build_stack(model), model.state(model.posture)
    p_foot, p_com = state.p_foot, state.p_com + np.array([0.0, 0.0, 1.0])
    target = tasks.Target(p_com, np.eye(3), p_foot, state.heading, np.zeros(4))
    for _ in range(100):
        lower, upper = step_bounds(model, state.q, 0.005)
        step = solve(levels_of(stack, state, target), lower, upper)
        state = model.state(model.integrate(state.q, step.x))
    assert np.allclose(state.p_foot, p_foot, atol=1e-3)
    assert state.p_com[2] < p_com[2] - 0.5


def test_saving_and_loading_is_the_identity(joints: rg.JointTrajectory, tmp_path: Path) -> None:
    again = rg.JointTrajectory.load(joints.save(tmp_path / "joints"))
    assert again.report == joints.report
    assert again.robot == joints.robot
    assert again.joint_names == joints.joint_names
    for name in ("time", "base_quaternion", "joint_position", "joint_velocity", "joint_torque"):
        assert np.array_equal(getattr(again, name), getattr(joints, name))
    assert np.array_equal(again.reference.force, joints.reference.force)


def test_the_mesh_of_a_plan_does_not_matter_to_the_joints() -> None:
    """Wheels turn in a slightly different way, as speeds are constant for a shorter time."""
    asked = stepping(robot="centauro")
    schedules = asked.schedule, asked.schedule.refined([1, 2, 4, 5, 8, 11, 12, 18])
    even, uneven = (rg.track(solved(asked, schedule), rate=100.0) for schedule in schedules)
    assert uneven.report.passed
    assert np.abs(uneven.joint_position - even.joint_position).max() < 0.1
    apart = uneven.joint_torque - even.joint_torque
    assert np.sqrt(np.mean(apart**2)) < 0.02 * np.abs(even.joint_torque).max()


def test_a_plan_is_no_joint_trajectory(hybrid: rg.Plan, tmp_path: Path) -> None:
    for file in (hybrid.save(tmp_path / "plan.npz"), tmp_path / "none.npz", tmp_path):
        with pytest.raises(FileError):
            rg.JointTrajectory.load(file)


def test_a_plan_that_is_not_certified_is_refused(hybrid: rg.Plan) -> None:
    unsolved = replace(hybrid, statistics=replace(hybrid.statistics, solved=False))
    with pytest.raises(NotCertifiedError, match="not certified"):
        rg.track(unsolved)
    assert rg.track(unsolved, rate=50.0, force=True).report.steps == 500


def test_wrong_input(hybrid: rg.Plan) -> None:
    with pytest.raises(UnknownNameError, match="valid: base"):
        rg.track(hybrid, waist="bass")
    with pytest.raises(InputError, match="whole-body model"):
        rg.track(replace(hybrid, robot=rg.find_robot("centauro-2020")), force=True)
    with pytest.raises(InputError, match="rate"):
        rg.track(hybrid, rate=-1.0)


def test_locked_wheels_neither_turn_nor_scrub() -> None:
    joints = rg.track(rg.plan("legged-forward"), rate=100.0)
    stance, heading = joints.reference.contact, joints.reference.heading
    turning = np.abs(np.diff(heading, axis=0)) > 1e-12
    assert not np.any(turning & stance[1:] & stance[:-1])


def test_another_robot_with_fixed_wheels_is_followed() -> None:
    from rollgait.robot.urdf import import_robot
    from rollgait.robot.whole_body import load_whole_body

    file = Path(__file__).parent.parent / "fixtures" / "roller.yaml"
    robot = import_robot(load_whole_body(file), str(file)).robot
    scenario = rg.find_scenario("hybrid-forward").with_values(
        {"robot": robot.model_dump(mode="json"), "goal.x": 1.0}
    )
    report = rg.track(rg.plan(scenario)).report
    assert report.passed
