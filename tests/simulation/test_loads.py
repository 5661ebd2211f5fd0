"""Loads in the whole body and in MuJoCo: where they are, what they weigh, what pulls."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="needs the extra whole-body")
pytest.importorskip("pinocchio", reason="needs the extra whole-body")
pytest.importorskip("daqp", reason="needs the extra whole-body")

import mujoco

import rollgait as rg
from rollgait.errors import InputError, UnknownNameError
from rollgait.plant.stance import standing_control, standing_state
from rollgait.robot.standing_com import com_in_base
from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.robot.urdf_stance import nominal_stance
from rollgait.robot.whole_body import find_whole_body
from rollgait.simulation.plant import MujocoPlant
from rollgait.simulation.pulls import Pulls
from rollgait.simulation.world import build_world

ROBOT = rg.find_robot("centauro")
AT = (0.1, 0.15, 0.3)
SIZE = (0.3, 0.2, 0.1)
LOADED = ROBOT.with_payload(20.0, AT, SIZE).with_payload(3.0, (-0.2, 0.0, 0.1))
BARE_MODEL = WholeBodyModel(find_whole_body(ROBOT))
MODEL = WholeBodyModel(find_whole_body(LOADED))
STANCE = nominal_stance(BARE_MODEL)


def test_the_whole_body_has_the_com_and_inertia_that_the_planner_has() -> None:
    state = MODEL.state(STANCE.q)
    assert MODEL.mass == pytest.approx(BARE_MODEL.mass + 23.0)
    np.testing.assert_allclose(state.p_com - STANCE.state.p_com, LOADED.com_offset, atol=1e-5)
    np.testing.assert_allclose(MODEL.inertia(STANCE.q), LOADED.inertia_matrix, atol=2e-3)


def test_the_world_has_the_same_masses_as_the_whole_body() -> None:
    body = find_whole_body(LOADED)
    world = build_world(body, MODEL.joint_names)
    data = mujoco.MjData(world.model)
    world.put(data, STANCE.q[:3], STANCE.q[3:7], STANCE.q[7:])
    mujoco.mj_forward(world.model, data)
    assert world.model.body_subtreemass[world.base] == pytest.approx(MODEL.mass)
    np.testing.assert_allclose(data.subtree_com[world.base], MODEL.state(STANCE.q).p_com, atol=1e-9)
    for number, load in enumerate(LOADED.loads or ()):
        place = data.body(f"load_{number}").xpos
        np.testing.assert_allclose(place, com_in_base(body) + load.at, atol=1e-12)


@pytest.mark.parametrize("frame", ["world", "base"])
def test_a_pull_does_the_work_of_a_force_at_its_place(frame: str) -> None:
    """For any motion of the base link power is force times the velocity of the place, plus torque times ω."""
    random = np.random.default_rng(3)
    body = find_whole_body(ROBOT)
    world = build_world(body, BARE_MODEL.joint_names)
    data = mujoco.MjData(world.model)
    turn = random.normal(size=4)
    world.put(data, np.array([1.0, 2.0, 0.9]), turn / np.linalg.norm(turn), STANCE.q[7:])
    data.qvel[:6] = random.normal(size=6)
    mujoco.mj_forward(world.model, data)
    wrench = rg.Wrench(force=(-100.0, 30.0, 5.0), torque=(1.0, 2.0, 3.0), at=(-0.3, 0.1, 0.2), frame=frame)
    data.xfrc_applied[world.base] = Pulls(body, [wrench]).at(0.0, data, world.base)
    jac_p, jac_r = np.zeros((2, 3, world.model.nv))
    mujoco.mj_jacBodyCom(world.model, data, jac_p, jac_r, world.base)
    applied = data.xfrc_applied[world.base]
    power = (applied[:3] @ jac_p + applied[3:] @ jac_r) @ data.qvel
    R = data.xmat[world.base].reshape(3, 3)
    force, torque = np.array(wrench.force), np.array(wrench.torque)
    if frame == "base":
        force, torque = R @ force, R @ torque
    omega = R @ data.qvel[3:6]
    velocity = data.qvel[:3] + np.cross(omega, R @ (com_in_base(body) + wrench.at))
    assert power == pytest.approx(force @ velocity + torque @ omega)


def test_a_pull_acts_in_its_time_only() -> None:
    body = find_whole_body(ROBOT)
    world = build_world(body, BARE_MODEL.joint_names)
    data = mujoco.MjData(world.model)
    mujoco.mj_forward(world.model, data)
    pulls = Pulls(body, [rg.Wrench(force=(1.0, 0.0, 0.0), start=1.0, end=2.0)])
    acting = [pulls.at(time, data, world.base)[0] for time in (-0.1, 0.999, 1.0, 1.999, 2.0)]
    assert acting == [0.0, 0.0, 1.0, 1.0, 0.0]


def test_a_loaded_robot_stands_where_it_is_told_to() -> None:
    """The feet carry all of it, and the true CoM is where the planner's robot has it."""
    start = standing_state(LOADED)
    pull = rg.Wrench(force=(0.0, 0.0, 300.0), start=0.5)
    plant = MujocoPlant(find_whole_body(LOADED), LOADED, start, wrenches=(pull,))
    for _ in range(30):
        plant.step(standing_control(LOADED, start.at(plant.time), 0.01))
    assert plant.contact_force[:, 2].sum() == pytest.approx(LOADED.weight, rel=0.01)
    np.testing.assert_allclose(plant.state.com_position, start.com_position, atol=3e-3)
    for _ in range(60):
        plant.step(standing_control(LOADED, start.at(plant.time), 0.01))
    assert plant.contact_force[:, 2].sum() == pytest.approx(LOADED.weight - 300.0, rel=0.02)


# -- arms ------------------------------------------------------------------------------------------------

ARMS = {"j_arm1_2": 1.2, "j_arm2_2": -0.9}


def test_other_arms_are_another_com_in_planner_and_whole_body() -> None:
    other = ROBOT.with_payload(5.0, AT).with_posture(ARMS)
    model = WholeBodyModel(find_whole_body(other))
    q = STANCE.q.copy()
    for name, angle in ARMS.items():
        q[model.place("posture", name) + 1] = angle
        assert model.posture[model.place("posture", name) + 1] == angle
    loaded = ROBOT.with_payload(5.0, AT)
    moved = model.state(q).p_com - WholeBodyModel(find_whole_body(loaded)).state(STANCE.q).p_com
    stance = loaded.stance - other.stance
    assert np.linalg.norm(moved) > 5e-3
    np.testing.assert_allclose(stance, np.broadcast_to(moved, (4, 3)), atol=1e-5)
    np.testing.assert_allclose(model.inertia(q), other.inertia_matrix, atol=2e-3)


def test_arms_and_back_is_nothing() -> None:
    nominal = {name: float(STANCE.q[BARE_MODEL.place("posture", name) + 1]) for name in ARMS}
    back = ROBOT.with_posture(ARMS).with_posture(nominal)
    np.testing.assert_allclose(back.stance, ROBOT.stance, atol=1e-12)
    np.testing.assert_allclose(back.inertia_matrix, ROBOT.inertia_matrix, atol=1e-9)


def test_a_load_stays_on_the_base_link_when_arms_move() -> None:
    one = ROBOT.with_payload(5.0, AT).with_posture(ARMS)
    body, before = find_whole_body(one), find_whole_body(ROBOT)
    (load,) = one.loads or ()
    np.testing.assert_allclose(com_in_base(body) + load.at, com_in_base(before) + AT, atol=1e-12)


def test_legs_are_no_arms() -> None:
    with pytest.raises(InputError, match="no leg"):
        ROBOT.with_posture({"knee_pitch_1": 0.3})
    with pytest.raises(UnknownNameError, match="j_arm1_1"):
        ROBOT.with_posture({"j_arm9_1": 0.3})
    with pytest.raises(InputError, match="range"):
        ROBOT.with_posture({"j_arm1_2": 9.0})


def test_a_scenario_says_how_the_arms_are() -> None:
    loads = {"posture": ARMS, "payload": {"mass": 5.0, "at": AT}}
    scenario = rg.Scenario.from_dict(
        {"robot": "centauro", "goal": {"x": 0.1}, "horizon": 1.0, "loads": loads, "profile": "paper"}
    )
    assert scenario.body == ROBOT.with_posture(ARMS).with_payload(5.0, AT)
    assert rg.Scenario.from_dict(scenario.to_dict()).body == scenario.body
    plan = rg.plan(scenario)
    certificate = plan.certificate()
    of_loads = {"load_mass", "load_place", "load_inertia"}
    assert of_loads <= {row.name for row in certificate.rows}
    assert not of_loads & {row.name for row in certificate.failures}
    without = replace(plan, scenario=scenario.with_values({"loads.posture": {}})).certificate()
    assert {row.name for row in without.failures} & of_loads == {"load_place", "load_inertia"}


# -- the whole way: 20 kg off the centre and a pull of 100 N ---------------------------------------------

LOADS = {
    "payload": {"mass": 20.0, "at": [0.1, 0.15, 0.3]},
    "wrench": {"force": [-100.0, 0.0, 0.0], "at": [-0.3, 0.0, 0.0]},
}
CRAWL = rg.Scenario(robot="centauro", goal=rg.Goal(x=0.8), horizon=8.0, gait=rg.Crawl())


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["wheeled", "hybrid-forward", "crawl"])
def test_a_motion_under_loads_ends_where_it_shall_and_worse_without_them_in_the_problem(motion: str) -> None:
    asked = CRAWL if motion == "crawl" else rg.find_scenario(motion)
    plan, unaware = rg.plan(asked.with_values({"loads": LOADS})), rg.plan(asked)
    assert plan.certificate().passed
    joints = rg.track(plan)
    surprised = replace(rg.track(unaware), robot=joints.robot, wrenches=joints.wrenches)
    assert joints.report.passed
    # of forces that joints cannot give little is left, and nothing near the pull
    assert joints.report.wrench_mismatch < 30.0
    report, other = (rg.simulate(one, feedback=True).report() for one in (joints, surprised))
    assert not report.fallen
    assert report.final_distance < 0.01
    assert other.fallen or other.com_rms > 2.0 * report.com_rms
    assert other.fallen or np.linalg.norm(other.force_rms) > np.linalg.norm(report.force_rms)
