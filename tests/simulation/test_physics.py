"""The physics under `simulate` and the controller's plant: steps, pushes and loads."""

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="needs the extra whole-body")
pytest.importorskip("pinocchio", reason="needs the extra whole-body")

import rollgait as rg
from rollgait.robot.robot import GRAVITY
from rollgait.robot.urdf_model import BASE_V, WholeBodyModel
from rollgait.robot.whole_body import library_whole_body
from rollgait.simulation import Disturbances, Push
from rollgait.simulation.controller import JointReference
from rollgait.simulation.drives import gains_of
from rollgait.simulation.physics import Physics, Pose
from rollgait.simulation.world import TIME_STEP

BODY = library_whole_body("centauro")
MODEL = WholeBodyModel(BODY)
ROBOT = rg.find_robot("centauro")
POSTURE = MODEL.posture[BASE_V + 1 :]
STILL = JointReference(POSTURE[None], np.zeros((1, len(POSTURE))), np.zeros((1, len(POSTURE))))


def physics_at(height: float = 0.0, begins: float = 0.0, **disturbances) -> Physics:
    """CENTAURO in its posture, the feet at a height above the ground, m."""
    ground = float(MODEL.state(MODEL.posture).p_foot[:, 2].mean()) - height
    pose = Pose(MODEL.posture[:3], MODEL.posture[3:7], POSTURE)
    return Physics(
        BODY,
        MODEL.joint_names,
        gains_of(ROBOT, BODY, MODEL.joint_names),
        Disturbances(**disturbances),
        pose,
        STILL,
        ground=ground,
        begins=begins,
    )


def test_two_halves_are_a_step() -> None:
    one, other = physics_at(), physics_at()
    for _ in range(20):
        one.step(0)
        other.begin_step(0)
        other.end_step()
    assert np.array_equal(one.data.qpos, other.data.qpos)
    for load, same in zip(one.take_load(), other.take_load(), strict=True):
        assert np.array_equal(load, same)


def test_the_load_is_the_mean_since_it_was_asked_last() -> None:
    physics = physics_at()
    total, peaks = np.zeros((4, 3)), np.zeros(len(POSTURE))
    again = physics_at()
    for _ in range(30):
        physics.step(0)
        again.step(0)
        load = again.take_load()
        total, peaks = total + load.force, np.maximum(peaks, load.torque_peak)
    load = physics.take_load()
    assert np.allclose(load.force, total / 30)
    assert np.array_equal(load.torque_peak, peaks)


def test_pushes_act_for_whole_steps_and_add_up() -> None:
    """In the air the momentum that two pushes leave is force times time, whenever time began."""
    pushes = (Push(force=50.0, start=0.004, duration=0.01), Push(force=30.0, start=0.009, duration=0.003))
    physics = physics_at(height=1.0, begins=0.005, pushes=pushes)
    for _ in range(5 + 20):
        physics.step(0)
    physics.push((0.0, -20.0, 0.0), 0.002)
    for _ in range(10):
        physics.step(0)
    assert physics.time == pytest.approx(0.03)
    mass = physics.world.model.body_mass.sum()
    momentum = mass * _com_velocity(physics)
    impulse = 50.0 * 0.01 + 30.0 * 0.003 - 20.0 * 0.002
    fallen = 35 * TIME_STEP * GRAVITY
    assert np.allclose(momentum, [0.0, impulse, -mass * fallen], atol=0.02)


def _com_velocity(physics: Physics) -> np.ndarray:
    import mujoco

    mujoco.mj_forward(physics.world.model, physics.data)
    mujoco.mj_subtreeVel(physics.world.model, physics.data)
    return physics.data.subtree_linvel[physics.world.base]
