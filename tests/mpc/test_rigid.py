"""The rigid body as a plant: laws of mechanics, and agreement with the planner's step."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rollgait as rg
from rollgait.dynamics.step import Figures, FootInput, FootState, State, angular_momentum, euler_rate, step
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.plant.control import Control
from rollgait.plant.protocol import Plant
from rollgait.plant.stance import standing_control, standing_state
from rollgait.plant.state import RobotState
from rollgait.robot.robot import GRAVITY, FootKind, Robot
from tests.mpc.builders import assert_equal, random_state, states

ROBOT = rg.find_robot("centauro")
PERIOD = 0.01
FREE = np.zeros((4, 3))


def control(state: RobotState, force: np.ndarray, motion: np.ndarray | None = None, period: float = PERIOD):
    """Some forces for a period; the feet stay at their heights."""
    moves = np.zeros((4, 2)) if motion is None else motion
    return Control(state, state.at(state.time + period), force, moves, np.ones(4, dtype=bool))


def momentum(state: RobotState) -> np.ndarray:
    """About the CoM, in world axes, kg m²/s."""
    return np.array(
        angular_momentum(np, state.euler.tolist(), state.euler_rate.tolist(), ROBOT.inertia_matrix.tolist())
    )


@given(states)
def test_without_forces_it_flies_a_parabola_and_keeps_its_angular_momentum(start: RobotState) -> None:
    plant: Plant = RigidPlant(ROBOT, start)
    for _ in range(5):
        plant.step(control(plant.state, FREE))
    t = plant.state.time - start.time
    fall = 0.5 * GRAVITY * t**2 * np.array([0.0, 0.0, -1.0])
    np.testing.assert_allclose(plant.state.com_position, start.com_position + t * start.com_velocity + fall)
    np.testing.assert_allclose(momentum(plant.state), momentum(start), atol=1e-6)


@given(states, st.tuples(*[st.floats(-200.0, 200.0)] * 3), st.floats(0.02, 0.08))
def test_a_push_changes_the_momentum_by_force_times_time(
    start: RobotState, force: tuple[float, float, float], duration: float
) -> None:
    pushed, free = RigidPlant(ROBOT, start), RigidPlant(ROBOT, start)
    periods = int(np.ceil(duration / PERIOD - 1e-6))
    pushed.push(np.array(force), periods * PERIOD)
    for _ in range(periods + 3):
        for plant in (pushed, free):
            plant.step(control(plant.state, FREE))
    change = ROBOT.mass * (pushed.state.com_velocity - free.state.com_velocity)
    np.testing.assert_allclose(change, np.array(force) * periods * PERIOD, atol=1e-6)
    np.testing.assert_allclose(pushed.state.euler, free.state.euler, atol=1e-9)


def test_pushes_add_up() -> None:
    both, one = RigidPlant(ROBOT), RigidPlant(ROBOT)
    for force in ([30.0, 0.0, 0.0], [0.0, 40.0, 0.0]):
        both.push(np.array(force), 0.05)
    one.push(np.array([30.0, 40.0, 0.0]), 0.05)
    for plant in (both, one):
        for _ in range(8):
            plant.step(standing_control(ROBOT, plant.state, PERIOD))
    assert_equal(both.state, one.state)


ALLOWED: dict[FootKind, list[float]] = {"steerable": [1.0, 1.0], "fixed": [1.0, 0.0], "point": [0.0, 0.0]}
"""Which of its two motions a foot of a kind has while it stands."""


@pytest.mark.parametrize("kind", ["steerable", "fixed", "point"])
def test_feet_that_stand_do_only_what_their_kind_can(kind: FootKind) -> None:
    """Whatever they are told: wheels go nowhere but along their heading, points stand still."""
    robot, start = ROBOT.with_feet(kind), standing_state(ROBOT)
    told = np.random.default_rng(0).normal(size=(4, 2))
    force = np.tile([0.0, 0.0, ROBOT.weight / 4.0], (4, 1))
    plants = [RigidPlant(robot, start) for _ in range(2)]
    for plant, motion in zip(plants, (told, told * ALLOWED[kind]), strict=True):
        plant.step(control(start, force, motion))
    assert_equal(plants[0].state, plants[1].state)
    moved = plants[0].state.foot_position - start.foot_position
    across = moved[:, 1] * np.cos(start.heading) - moved[:, 0] * np.sin(start.heading)
    if kind == "fixed":
        np.testing.assert_allclose(across, 0.0, atol=1e-4)
    if kind == "point":
        np.testing.assert_allclose(moved, 0.0, atol=1e-12)


@pytest.mark.parametrize("kind", ["steerable", "fixed", "point"])
def test_it_agrees_with_the_planners_step_to_its_order(kind: FootKind) -> None:
    robot = ROBOT.with_feet(kind)
    offsets = [leg.heading for leg in robot.leg_list]
    gaps = {0.08: 0.0, 0.04: 0.0}
    for seed in range(10):
        start, random = random_state(seed), np.random.default_rng(seed)
        if kind == "fixed":
            start = replace(start, heading=start.euler[0] + np.array(offsets))
        force = np.array([0.0, 0.0, ROBOT.weight / 4.0]) + 30.0 * random.normal(size=(4, 3))
        motion = random.normal(size=(4, 2)) * ALLOWED[kind]
        for period in gaps:
            plant = RigidPlant(robot, start)
            plant.step(control(start, force, motion, period))
            if kind == "fixed":
                np.testing.assert_allclose(plant.state.heading, plant.state.euler[0] + offsets, atol=1e-6)
            gaps[period] += gap(plant.state, planned(robot, start, force, motion, period))
    assert gaps[0.08] < 1e-2
    assert gaps[0.04] < gaps[0.08] / 6.0  # a local error of third order falls by 8


def planned(
    robot: Robot, start: RobotState, force: np.ndarray, motion: np.ndarray, period: float
) -> RobotState:
    """Where the planner's step says that it will be."""
    legs = robot.leg_list
    figures = Figures(
        ROBOT.mass,
        np.linalg.inv(ROBOT.inertia_matrix).tolist(),
        [leg.foot for leg in legs],
        [leg.heading for leg in legs],
    )
    feet = tuple(FootState(start.foot_position[i].tolist(), float(start.heading[i])) for i in range(4))
    x = State(
        start.com_position.tolist(),
        start.euler.tolist(),
        start.com_velocity.tolist(),
        momentum(start).tolist(),
        feet,
    )
    inputs = [FootInput(force[i].tolist(), motion[i].tolist(), [0.0, 0.0]) for i in range(4)]
    end, _ = step(np, x, inputs, period, figures)
    return replace(
        start,
        time=start.time + period,
        com_position=np.array(end.r),
        euler=np.array(end.theta),
        com_velocity=np.array(end.dr),
        euler_rate=np.array(euler_rate(np, end.theta, end.L, figures)),
        foot_position=np.array([foot.p for foot in end.feet]),
        heading=np.array(
            [
                end.theta[0] + leg.heading if leg.foot == "fixed" else foot.sigma
                for foot, leg in zip(end.feet, legs, strict=True)
            ]
        ),
    )


def gap(a: RobotState, b: RobotState) -> float:
    """Largest difference in place and angle, m and rad."""
    names = ("com_position", "euler", "foot_position", "heading")
    return max(float(np.abs(getattr(a, name) - getattr(b, name)).max()) for name in names)


def test_a_wheel_rolls_along_its_heading() -> None:
    start = standing_state(ROBOT, yaw=0.4)
    plant, motion = RigidPlant(ROBOT, start), np.tile([0.5, 0.0], (4, 1))
    for _ in range(20):
        plant.step(replace(standing_control(ROBOT, plant.state, PERIOD), motion=motion))
    way = plant.state.foot_position - start.foot_position
    direction = np.column_stack([np.cos(start.heading), np.sin(start.heading), np.zeros(4)])
    np.testing.assert_allclose(way, 0.1 * direction, atol=1e-6)
    np.testing.assert_allclose(plant.state.speed, 0.5)


def test_it_stands_and_it_falls() -> None:
    plant = RigidPlant(ROBOT)
    for _ in range(50):
        plant.step(standing_control(ROBOT, plant.state, PERIOD))
    assert_equal(plant.state, standing_state(ROBOT, time=0.5), atol=1e-9)
    assert not plant.fallen
    for _ in range(60):
        plant.step(control(plant.state, FREE))
    assert plant.fallen
    for _ in range(5):
        plant.step(control(plant.state, np.tile([0.0, 0.0, ROBOT.weight], (4, 1))))
    assert plant.fallen


def test_a_tilt_is_a_fall_and_so_is_what_is_not_a_number() -> None:
    for euler in ([0.0, 0.8, 0.0], [0.0, 0.0, -0.8], [0.0, 0.6, 0.6]):
        plant = RigidPlant(ROBOT, replace(standing_state(ROBOT), euler=np.array(euler)))
        plant.step(standing_control(ROBOT, plant.state, PERIOD))
        assert plant.fallen
    plant = RigidPlant(ROBOT, replace(standing_state(ROBOT), euler=np.array([3.0, 0.5, 0.5])))
    plant.step(standing_control(ROBOT, plant.state, PERIOD))
    assert not plant.fallen


def test_noise_repeats_by_seed() -> None:
    plants = [RigidPlant(ROBOT, noise=0.01, seed=seed) for seed in (1, 1, 2)]
    for plant in plants:
        for _ in range(10):
            plant.step(standing_control(ROBOT, plant.state, PERIOD))
    assert_equal(plants[0].state, plants[1].state)
    with pytest.raises(AssertionError):
        assert_equal(plants[0].state, plants[2].state)
