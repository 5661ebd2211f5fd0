"""The whole robot in MuJoCo as a plant: it is where it is told to be, and says truly where it is."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("mujoco", reason="needs the extra whole-body")
pytest.importorskip("pinocchio", reason="needs the extra whole-body")
pytest.importorskip("daqp", reason="needs the extra whole-body")

from scipy.spatial.transform import Rotation

import rollgait as rg
from rollgait.angles import euler_angles, euler_rates
from rollgait.errors import InputError
from rollgait.plan.certificate.physics import angular_velocity_world
from rollgait.plant.control import Control
from rollgait.plant.protocol import Plant
from rollgait.plant.stance import standing_control, standing_state
from rollgait.plant.state import RobotState
from rollgait.robot.robot import GRAVITY
from rollgait.robot.urdf import import_robot
from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.robot.whole_body import library_whole_body, load_whole_body
from rollgait.simulation import Disturbances, Push
from rollgait.simulation.controller import MovingAverage
from rollgait.simulation.plant import MujocoPlant
from tests.tracking.builders import controls

PERIOD = 0.01
ROBOT = rg.find_robot("centauro")
BODY = library_whole_body("centauro")
START = standing_state(ROBOT)
angles = st.floats(-1.4, 1.4)
numbers = st.floats(-5.0, 5.0)


def plant_at(start: RobotState = START, **options) -> MujocoPlant:
    return MujocoPlant(BODY, ROBOT, start, **options)


def stand(plant: MujocoPlant, duration: float, at: RobotState = START) -> list[RobotState]:
    """The states while it stands."""
    states = []
    for _ in range(round(duration / PERIOD)):
        plant.step(standing_control(ROBOT, at.at(plant.time), PERIOD))
        states.append(plant.state)
    return states


def driving(speed: float, duration: float) -> list[Control]:
    """Straight ahead: from rest to a speed within half a second, then on."""
    controls, x, v = [], 0.0, 0.0
    state = START
    for k in range(round(duration / PERIOD)):
        following = min(speed, v + speed * PERIOD / 0.5)
        mean, x_end = 0.5 * (v + following), x + 0.5 * (v + following) * PERIOD
        ahead = np.array([x_end, 0.0, 0.0])
        end = replace(
            START,
            time=(k + 1) * PERIOD,
            com_position=START.com_position + ahead,
            foot_position=START.foot_position + ahead,
            com_velocity=np.array([following, 0.0, 0.0]),
            speed=np.full(4, following),
        )
        still = standing_control(ROBOT, START, PERIOD)
        motion = np.stack([np.full(4, mean), np.zeros(4)], axis=1)
        controls.append(Control(state, end, still.force, motion, still.contact))
        state, x, v = end, x_end, following
    return controls


def test_it_is_a_plant() -> None:
    plant: Plant = plant_at()
    assert plant.name == "mujoco"
    assert plant.state.time == START.time
    assert not plant.fallen


@pytest.mark.parametrize("yaw", [0.0, 2.5, -2.0 * np.pi - 1.0])
def test_it_starts_where_it_is_told(yaw: float) -> None:
    start = standing_state(ROBOT, x=2.0, y=-1.0, yaw=yaw, time=3.0)
    state = plant_at(start).state
    assert state.time == start.time
    assert np.allclose(state.com_position, start.com_position, atol=2e-3)
    assert np.allclose(state.foot_position, start.foot_position, atol=2e-3)
    assert np.allclose(state.euler, start.euler, atol=np.radians(0.2))
    assert np.allclose(state.heading, start.heading, atol=np.radians(0.2))
    for velocity in (state.com_velocity, state.euler_rate, state.speed):
        assert np.allclose(velocity, 0.0, atol=2e-3)


def test_who_is_told_to_stand_stays_and_is_carried() -> None:
    plant = plant_at()
    states = stand(plant, 1.0)
    assert states[-1].time == pytest.approx(1.0)
    assert np.allclose(states[-1].com_position, START.com_position, atol=2e-3)
    assert np.allclose(states[-1].foot_position, START.foot_position, atol=2e-3)
    assert np.allclose(plant.contact_force.sum(axis=0), [0.0, 0.0, ROBOT.mass * GRAVITY], atol=10.0)
    assert 0.0 < plant.torque_share < 1.0
    assert plant.torque.shape == (len(plant.joint_names),)


@pytest.mark.parametrize("name", ["roller", "hyq"])
def test_fixed_wheels_and_point_feet_stand_as_well(name: str) -> None:
    file = Path(__file__).parent.parent / "fixtures" / f"{name}.yaml"
    body = load_whole_body(file)
    robot = import_robot(body, str(file)).robot
    start = standing_state(robot, yaw=0.5)
    plant = MujocoPlant(body, robot, start)
    for _ in range(50):
        plant.step(standing_control(robot, start.at(plant.time), PERIOD))
    state = plant.state
    assert np.allclose(state.com_position, start.com_position, atol=2e-3)
    assert np.allclose(state.foot_position, start.foot_position, atol=2e-3)
    assert np.allclose(state.heading, start.heading, atol=1e-3)
    assert plant.contact_force[:, 2].sum() == pytest.approx(robot.weight, rel=0.01)


def test_a_drive_arrives_and_speeds_are_those_of_the_wheels() -> None:
    plant = plant_at()
    for control in driving(0.4, 2.0):
        plant.step(control)
    state, end = plant.state, control.end
    lag = 0.4 * plant.delay
    assert np.allclose(state.com_position[0], end.com_position[0] - lag, atol=0.01)
    assert np.allclose(state.com_position[1:], end.com_position[1:], atol=0.01)
    assert np.allclose(state.speed, 0.4, atol=0.02)
    assert np.allclose(state.com_velocity, [0.4, 0.0, 0.0], atol=0.02)
    assert not plant.fallen


def test_velocities_are_those_of_the_positions() -> None:
    plant = plant_at()
    states = [plant.state]
    for control in driving(0.4, 1.0):
        plant.step(control)
        states.append(plant.state)
    mean = {f.name: np.array([getattr(s, f.name) for s in states]) for f in fields(RobotState)}
    for position, velocity, tolerance in (
        ("com_position", "com_velocity", 3e-3),
        ("euler", "euler_rate", 3e-3),
    ):
        difference = np.diff(mean[position], axis=0) / PERIOD
        between = 0.5 * (mean[velocity][1:] + mean[velocity][:-1])
        assert np.sqrt(np.mean((difference - between) ** 2)) < tolerance
    along = np.diff(mean["foot_position"][:, :, 0], axis=0) / PERIOD
    assert np.sqrt(np.mean((along - 0.5 * (mean["speed"][1:] + mean["speed"][:-1])) ** 2)) < 0.01


def test_turning_round_does_not_reduce_angles() -> None:
    """Turned with its world by hand, past half a turn, yaw and headings go on."""
    start = standing_state(ROBOT, yaw=np.pi - 1e-3)
    plant = plant_at(start)
    states = stand(plant, 0.1, start)
    assert np.allclose(states[-1].euler[0], start.euler[0], atol=0.01)
    assert np.allclose(states[-1].heading, start.heading, atol=0.01)


def test_a_push_moves_it_as_long_as_it_says() -> None:
    plant, alone = plant_at(), plant_at()
    plant.push(np.array([0.0, 200.0, 0.0]), 0.1)
    pushed, other = stand(plant, 1.0), stand(alone, 1.0)
    # while it lasts the ground gives way to it; when it is over, the ground's forces are as before
    moved = np.array([a.com_velocity[1] - b.com_velocity[1] for a, b in zip(pushed, other, strict=True)])
    assert moved[:10].max() > 5e-3
    assert np.abs(moved[-20:]).max() < 0.2 * moved[:10].max()
    assert not plant.fallen


def test_the_ground_takes_up_a_push_while_it_lasts() -> None:
    """By Newton's law the mean of the ground's forces is opposite to it, once the robot has given way."""

    def mean_force(plant: MujocoPlant, duration: float) -> np.ndarray:
        forces = []
        for _ in range(round(duration / PERIOD)):
            plant.step(standing_control(ROBOT, START.at(plant.time), PERIOD))
            forces.append(plant.contact_force.sum(axis=0))
        return np.mean(forces, axis=0)

    plant = plant_at()
    plant.push(np.array([60.0, 0.0, 0.0]), 1.0)
    mean_force(plant, 0.5)
    assert mean_force(plant, 0.5)[0] == pytest.approx(-60.0, abs=6.0)
    mean_force(plant, 0.3)
    assert mean_force(plant, 0.5)[0] == pytest.approx(0.0, abs=6.0)  # it still sways


def test_pushes_that_are_given_beforehand_are_the_same() -> None:
    later = plant_at()
    stand(later, 0.1)
    later.push(np.array([0.0, 100.0, 0.0]), 0.2)
    given = plant_at(disturbances=Disturbances(pushes=(Push(force=100.0, start=0.1, duration=0.2),)))
    stand(given, 0.1)
    one, other = stand(later, 0.3)[-1], stand(given, 0.3)[-1]
    assert np.allclose(one.com_position, other.com_position, atol=1e-9)


def test_a_huge_push_fells_it_and_it_stays_fallen() -> None:
    plant = plant_at()
    plant.push(np.array([0.0, 8000.0, 0.0]), 0.5)
    states = stand(plant, 2.0)
    assert plant.fallen
    assert all(state.is_finite() for state in states)


def test_what_is_no_number_never_passes() -> None:
    plant = plant_at()
    good = standing_control(ROBOT, START, PERIOD)
    broken = replace(good, end=replace(good.end, com_position=np.full(3, np.nan)))
    for _ in range(20):
        plant.step(broken)
        assert plant.follower.failed
        assert plant.state.is_finite()
    assert np.allclose(plant.state.com_position, START.com_position, atol=2e-3)
    plant.step(good)
    assert not plant.follower.failed


def test_wrong_input() -> None:
    plant = plant_at()
    with pytest.raises(InputError, match="force"):
        plant.push(np.array([np.nan, 0.0, 0.0]), 0.1)
    with pytest.raises(InputError, match="duration"):
        plant.push(np.zeros(3), 0.0)
    with pytest.raises(InputError, match="start"):
        plant_at(replace(START, com_position=np.full(3, np.nan)))
    with pytest.raises(InputError, match="smoothing"):
        plant_at(smoothing=-1.0)
    still = standing_control(ROBOT, START, PERIOD)
    with pytest.raises(InputError, match="period"):
        plant.step(replace(still, end=still.end.at(still.begin.time)))


def test_a_long_period_is_one_step_as_well() -> None:
    plant = plant_at()
    plant.step(standing_control(ROBOT, START, 0.05))
    assert plant.state.time == pytest.approx(0.05)
    assert np.allclose(plant.state.com_position, START.com_position, atol=2e-3)


def test_latency_and_a_payload_are_borne() -> None:
    plant = plant_at(disturbances=Disturbances(latency=5e-3, payload={"mass": 5.0}))
    stand(plant, 0.5)
    assert not plant.fallen
    assert plant.contact_force[:, 2].sum() == pytest.approx((ROBOT.mass + 5.0) * GRAVITY, rel=0.01)


def test_the_pose_is_that_of_the_whole_body() -> None:
    plant = plant_at()
    pose = plant.pose
    q = np.concatenate([pose.base_position, pose.base_quaternion, pose.joint_position])
    state = plant.follower.model.state(q)
    assert np.allclose(state.p_com, plant.state.com_position, atol=1e-6)
    assert np.allclose(state.p_foot, plant.state.foot_position, atol=1e-6)
    assert np.allclose(state.heading, plant.state.heading, atol=1e-6)


@given(st.tuples(angles, angles, angles), st.tuples(numbers, numbers, numbers))
def test_euler_angles_and_rates_read_back(theta, rates) -> None:
    euler, euler_rate = np.array(theta), np.array(rates)
    R = Rotation.from_euler("ZYX", euler).as_matrix()
    assert np.allclose(euler_angles(R), euler)
    assert np.allclose(euler_rates(euler, angular_velocity_world(euler, euler_rate)), euler_rate)


@given(st.integers(1, 30), st.lists(st.integers(1, 12), min_size=1, max_size=5), st.integers(0, 1000))
def test_a_moving_average_of_a_stream_in_parts_is_that_of_the_whole(width, parts, seed) -> None:
    rows = np.random.default_rng(seed).normal(size=(sum(parts), 3))
    whole, piecewise = MovingAverage(width, 3), MovingAverage(width, 3)
    for average in (whole, piecewise):
        average.fill(rows[0])
    expected = whole.update(rows)
    found = np.concatenate([piecewise.update(part) for part in np.split(rows, np.cumsum(parts)[:-1])])
    assert np.allclose(found, expected)
    padded = np.concatenate([np.repeat(rows[:1], width, axis=0), rows])
    means = [padded[k + 1 : k + 1 + width].mean(axis=0) for k in range(len(rows))]
    assert np.allclose(found, means)


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["wheeled", "hybrid-forward", "legged-forward", "hybrid-goback"])
def test_the_four_motions_open_loop(motion: str) -> None:
    """Controls from a plan, with nothing fed back, lead to its end."""
    plan = rg.plan(motion)
    model = WholeBodyModel(BODY)
    given = controls(plan, model, PERIOD)
    plant = MujocoPlant(BODY, plan.robot, given[0].begin)
    for control in given:
        plant.step(control)
        assert not plant.follower.failed
    end = given[-1].end
    stand(plant, 0.5, end)
    assert not plant.fallen
    assert np.linalg.norm(plant.state.com_position - end.com_position) < 0.03
    assert np.linalg.norm(plant.state.euler - end.euler) < np.radians(2.0)
    assert np.linalg.norm(plant.state.foot_position - end.foot_position, axis=1).max() < 0.03


def test_physics_that_become_unstable_end_as_a_fall(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its warnings into a file here
    plant = plant_at()
    plant.push(np.array([1e13, 0.0, 1e13]), 0.1)
    assert all(state.is_finite() for state in stand(plant, 0.5))
    assert plant.fallen
    assert plant.time == pytest.approx(0.5)
    for shown in (*plant.pose, plant.torque, plant.contact_force, plant.torque_share):
        assert np.isfinite(shown).all()
