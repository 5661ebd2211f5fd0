"""Tracking on a slope: rolling along it, forces where it is touched, and a world that turns."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pinocchio", reason="needs the extra whole-body")
pytest.importorskip("daqp", reason="needs the extra whole-body")

from scipy.spatial.transform import Rotation

import rollgait as rg
from rollgait.robot.robot import GRAVITY
from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.robot.whole_body import library_whole_body
from rollgait.tracking import tasks
from rollgait.tracking.kinematics import InverseKinematics, carried
from tests.tracking.turning import turned

SLOPE = np.tan(np.radians(10.0))
RAMP = {"kind": "ramp", "x": -3.0, "length": 6.0, "width": 6.0, "rise": float(6.0 * SLOPE)}


@pytest.fixture(scope="module")
def plan() -> rg.Plan:
    """A short drive up a ramp of 10°, a little across it."""
    return rg.plan(
        rg.Scenario.from_dict(
            {
                "robot": "centauro",
                "goal": {"x": 0.4, "y": 0.1},
                "horizon": 3.0,
                "gait": {"kind": "drive"},
                "ground": {"parts": [RAMP]},
            }
        )
    )


@pytest.fixture(scope="module")
def joints(plan: rg.Plan) -> rg.JointTrajectory:
    return rg.track(plan, rate=100.0, force=True)


@pytest.fixture(scope="module")
def model() -> WholeBodyModel:
    return WholeBodyModel(library_whole_body("centauro"))


def configuration(joints: rg.JointTrajectory, k: int) -> np.ndarray:
    return np.concatenate([joints.base_position[k], joints.base_quaternion[k], joints.joint_position[k]])


def test_the_plan_climbs(plan: rg.Plan, joints: rg.JointTrajectory) -> None:
    rise = np.ptp(plan.sample([0.0, plan.horizon]).foot_position[..., 2], axis=0)
    assert np.all(rise > 0.9 * 0.4 * SLOPE)
    assert joints.report.passed


def test_wheels_turn_by_the_way_along_the_ground(joints: rg.JointTrajectory, model: WholeBodyModel) -> None:
    """About their axles in the world, by the length of their paths in space over R."""
    foot, dt = joints.reference.foot_position, np.diff(joints.time)
    turned_by = np.zeros(4)
    for k, step in enumerate(dt):
        v = model.difference(configuration(joints, k), configuration(joints, k + 1)) / step
        turned_by += model.state(configuration(joints, k)).J_roll @ v * step
    moved, heading = np.diff(foot, axis=0), joints.reference.heading[:-1]
    ahead = np.sign(moved[..., 0] * np.cos(heading) + moved[..., 1] * np.sin(heading))
    way = (ahead * np.linalg.norm(moved, axis=-1)).sum(axis=0)
    flat = (ahead * np.linalg.norm(moved[..., :2], axis=-1)).sum(axis=0)
    radius = np.array([leg.radius for leg in model.legs])
    assert np.allclose(turned_by, way / radius, rtol=1e-3)
    assert np.all(turned_by - flat / radius > 0.01 * way / radius)


def test_what_touches_the_ground_stands_still(joints: rg.JointTrajectory, model: WholeBodyModel) -> None:
    """The material point at the true contact, not that at the lowest point of the rim."""
    offset = joints.reference.contact_position - joints.reference.foot_position
    for k in range(50, len(joints.time) - 1, 49):
        v = np.concatenate([joints.base_velocity[k], joints.joint_velocity[k]])
        state = model.state(configuration(joints, k))
        lowest, spin = (np.einsum("lij,j->li", J, v) for J in (state.J_contact, state.J_angular))
        assert np.abs(lowest + np.cross(spin, offset[k])).max() < 0.02


def test_wheels_are_driven_by_what_pushes_along_the_ground(
    joints: rg.JointTrajectory, model: WholeBodyModel
) -> None:
    """At a constant rate a wheel asks its drive for R times the force along its path."""
    plan, k = joints.reference, len(joints.time) - 1
    way = plan.foot_position[-2] - plan.foot_position[20]
    along = way / np.linalg.norm(way, axis=-1, keepdims=True)
    push = (plan.force[k] * along).sum(axis=-1)
    state = model.state(configuration(joints, k))
    radius = np.array([leg.radius for leg in model.legs])
    for i, leg in enumerate(model.legs):
        assert leg.wheel is not None
        about_axle = joints.joint_torque[k, leg.wheel - 6] * state.J_roll[i, leg.wheel]
        assert about_axle == pytest.approx(push[i] * radius[i], abs=0.5)
    assert push.sum() > 0.5 * model.mass * GRAVITY * SLOPE


def test_standing_on_the_ramp_forces_and_torques_balance_gravity(
    plan: rg.Plan, model: WholeBodyModel
) -> None:
    """The floating base lacks nothing, if forces act at true contacts."""
    start = plan.sample([0.0]).at(0)
    R = Rotation.from_euler("ZYX", start.euler).as_matrix()
    target = tasks.Target(start.com_position, R, start.foot_position, start.heading, np.zeros(4))
    state = InverseKinematics(model).stand(target)
    arms = start.contact_position - state.p_com
    moments = [[[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]] for x, y, z in arms]
    wrench = np.vstack([np.tile(np.eye(3), 4), np.concatenate(moments, axis=1)])
    weight = [0.0, 0.0, model.mass * GRAVITY, 0.0, 0.0, 0.0]
    force = np.linalg.lstsq(wrench, weight, rcond=None)[0].reshape(4, 3)
    offset = start.contact_position - start.foot_position
    assert np.all(np.linalg.norm(offset, axis=1) > 0.02)
    still = np.zeros(model.nv)
    gravity = model.inverse_dynamics(state.q, still, still)
    assert np.allclose((gravity - carried(state, force, offset))[:6], 0.0, atol=1e-3)
    assert np.linalg.norm((gravity - carried(state, force))[3:6]) > 10.0


def test_a_turned_world_turns_the_base_and_nothing_else(plan: rg.Plan, joints: rg.JointTrajectory) -> None:
    yaw = 0.7
    other = rg.track(turned(plan, yaw), rate=100.0, force=True)
    R = Rotation.from_euler("z", yaw)
    assert np.allclose(other.joint_position, joints.joint_position, atol=1e-5)
    assert np.allclose(other.joint_torque, joints.joint_torque, atol=1e-2)
    assert np.allclose(other.base_position, R.apply(joints.base_position), atol=1e-5)
    turned_base = R * Rotation.from_quat(joints.base_quaternion)
    assert np.max((Rotation.from_quat(other.base_quaternion).inv() * turned_base).magnitude()) < 1e-5
    for name in ("ground clearance", "leg clearance"):
        assert other.report.row(name).worst == pytest.approx(joints.report.row(name).worst, abs=1e-4)


def test_a_file_keeps_where_the_ground_is_touched(joints: rg.JointTrajectory, tmp_path: Path) -> None:
    again = rg.JointTrajectory.load(joints.save(tmp_path / "joints"))
    assert np.array_equal(again.reference.contact_normal, joints.reference.contact_normal)
    assert np.allclose(again.reference.contact_normal[..., 2], np.cos(np.radians(10.0)))
