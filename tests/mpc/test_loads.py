"""What pulls at the base, in the controller's model, its plant and its problem."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rollgait as rg
from rollgait.mpc.execution import execute, loop_for
from rollgait.mpc.loop import ClosedLoop
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.mpc.setup import make_loop
from rollgait.plant.control import Control
from rollgait.plant.stance import standing_state
from rollgait.plant.state import RobotState
from rollgait.robot.loads import Wrench
from tests.expressions import vectors
from tests.mpc.builders import states
from tests.mpc.conftest import PATIENT

ROBOT = rg.find_robot("centauro").with_payload(20.0, (0.1, 0.15, 0.3))
PERIOD = 0.01
PULL = Wrench(force=(-100.0, 0.0, 0.0), at=(-0.3, 0.0, 0.0))


def falling(state: RobotState) -> Control:
    """No foot does anything."""
    zero = np.zeros((4, 2))
    return Control(state, state.at(state.time + PERIOD), np.zeros((4, 3)), zero, np.ones(4, dtype=bool))


@given(states, vectors(3, 200.0), st.sampled_from([0.0, 0.013, 0.05]))
def test_a_wrench_changes_momentum_by_force_times_time(
    start: RobotState, force: np.ndarray, begins: float
) -> None:
    wrench = Wrench(force=tuple(force + np.array([0.0, 0.0, 1.0])), at=(0.2, 0.1, 0.0), start=begins)
    pulled, free = RigidPlant(ROBOT, start, wrenches=(wrench,)), RigidPlant(ROBOT, start)
    for _ in range(3):
        pulled.step(falling(pulled.state))
        free.step(falling(free.state))
    change = ROBOT.mass * (pulled.state.com_velocity - free.state.com_velocity)
    np.testing.assert_allclose(change, np.array(wrench.force) * max(0.0, 0.03 - begins), atol=1e-6)


@given(states)
@settings(max_examples=20)
def test_a_pull_as_strong_as_a_push_at_the_com_is_one(start: RobotState) -> None:
    at = tuple(ROBOT.com_offset.tolist())
    pulled = RigidPlant(ROBOT, start, wrenches=(Wrench(force=(50.0, -20.0, 10.0), at=at),))
    pushed = RigidPlant(ROBOT, start)
    pushed.push(np.array([50.0, -20.0, 10.0]), PERIOD)
    for plant in (pulled, pushed):
        plant.step(falling(plant.state))
    np.testing.assert_allclose(pulled.state.com_velocity, pushed.state.com_velocity, atol=1e-9)
    np.testing.assert_allclose(pulled.state.euler_rate, pushed.state.euler_rate, atol=1e-7)


@pytest.fixture(scope="module")
def aware() -> Mpc:
    return Mpc(ROBOT, PATIENT, kernels=False, wrenches=(PULL,))


def held(mpc: Mpc, seconds: float = 1.0) -> tuple[ClosedLoop, float]:
    """A loop in which the robot stands under the pull, and how far the CoM was from its place, m."""
    loop = ClosedLoop(mpc, RigidPlant(ROBOT, standing_state(ROBOT), wrenches=(PULL,)))
    begin, away = loop.plant.state.com_position[:2], 0.0
    for _ in range(round(seconds / PERIOD)):
        loop.step(rg.VelocityCommand())
        away = max(away, float(np.linalg.norm(loop.plant.state.com_position[:2] - begin)))
    return loop, away


def test_a_controller_that_knows_of_a_pull_gives_way_less(aware: Mpc) -> None:
    aware.reset()
    loop, away = held(aware)
    assert not aware.events
    assert loop.prediction is not None
    _, surprised = held(Mpc(ROBOT, PATIENT, kernels=False))
    assert away < 0.5 * surprised
    # it is held by what the feet push
    assert loop.prediction.force[0].sum(axis=0)[0] == pytest.approx(100.0, rel=0.1)


def test_what_it_expects_comes_true(aware: Mpc) -> None:
    """The model of one period and the plant, which SciPy integrates, agree under a pull."""
    aware.reset()
    plant = RigidPlant(ROBOT, standing_state(ROBOT), wrenches=(PULL,))
    for _ in range(10):
        control, _ = aware.step(plant.state, rg.VelocityCommand(forward=0.2))
        plant.step(control)
        for name in ("com_position", "com_velocity", "euler"):
            np.testing.assert_allclose(getattr(plant.state, name), getattr(control.end, name), atol=1e-5)
        np.testing.assert_allclose(plant.state.euler_rate, control.end.euler_rate, atol=1e-4)


def test_standing_after_a_fault_leans_against_the_pull(aware: Mpc) -> None:
    aware.reset()
    state = standing_state(ROBOT)
    aware.step(state, rg.VelocityCommand())
    aware.stop("for this test")
    control, _ = aware.step(state.at(PERIOD), rg.VelocityCommand())
    assert control.force.sum(axis=0)[0] == pytest.approx(100.0, rel=1e-6)
    assert control.force.sum(axis=0)[2] == pytest.approx(ROBOT.weight, rel=1e-6)


def test_loads_by_keys_are_those_of_robot_and_controller() -> None:
    loads = rg.Loads.model_validate(
        {"payload": {"mass": 20.0, "at": [0.1, 0.15, 0.3]}, "wrench": PULL.model_dump()}
    )
    loop = make_loop("centauro", settings=PATIENT, kernels=False, loads=loads)
    assert loop.mpc.robot == ROBOT
    for _ in range(20):
        control, _ = loop.step(rg.VelocityCommand())
    assert control.force.sum(axis=0)[0] == pytest.approx(100.0, abs=15.0)


def test_plans_in_turn_bring_their_pulls_in_turn() -> None:
    short = {"robot": "centauro", "goal": {"x": 0.0}, "horizon": 1.0}
    planner = rg.Planner(kernels=False)
    pulls = [{"force": [-60.0, 0.0, 0.0]}, {"force": [40.0, 0.0, 0.0], "start": 0.3, "end": 0.7}]
    first, last = (planner.plan(rg.Scenario.from_dict(short | {"loads": {"wrench": p}})) for p in pulls)
    loop = loop_for(first, "rigid", last, kernels=False, settings=PATIENT)
    plant = loop.plant
    assert isinstance(plant, RigidPlant)
    times = [(w.start, w.end or np.inf, w.force[0]) for w in plant._wrenches]
    np.testing.assert_allclose(times, [(0.0, 1.0, -60.0), (1.3, 1.7, 40.0)])
    report = execute([first, last], loop).report
    assert report.passed
    assert report.final_distance < 2e-3
