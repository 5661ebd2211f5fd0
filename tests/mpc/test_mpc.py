"""The controller on the rigid body: it stands, moves, mirrors, and takes other figures at any time."""

import gc
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from rollgait.errors import InputError, UnknownNameError
from rollgait.mpc.command import PoseCommand, VelocityCommand
from rollgait.mpc.loop import ClosedLoop
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.mpc.setup import make_loop
from rollgait.plant.control import Control
from rollgait.plant.stance import standing_control, standing_state
from rollgait.plant.state import RobotState
from rollgait.simulation import Disturbances

STANDING = VelocityCommand()


def run(
    mpc: Mpc, command: VelocityCommand | PoseCommand, duration: float
) -> tuple[RobotState, list[Control]]:
    """The state at the end on the rigid body, and all controls."""
    loop = ClosedLoop(mpc, RigidPlant(mpc.robot))
    controls = [loop.step(command)[0] for _ in range(round(duration / mpc.settings.period))]
    assert not loop.plant.fallen
    return loop.plant.state, controls


def test_it_stands_still(mpc: Mpc) -> None:
    start = standing_state(mpc.robot)
    end, controls = run(mpc, STANDING, 2.0)
    assert np.abs(end.com_position - start.com_position).max() < 2e-3
    assert np.abs(end.foot_position - start.foot_position).max() < 2e-3
    assert np.abs(end.euler).max() < 1e-3
    weight = controls[-1].force[:, 2].sum()
    assert weight == pytest.approx(mpc.robot.weight, rel=1e-3)
    assert not mpc.events


@pytest.mark.parametrize("gait", ["drive", "crawl", "trot"])
def test_it_reaches_a_speed_in_each_gait(mpc: Mpc, gait: str) -> None:
    mpc.reset(gait)
    end, controls = run(mpc, VelocityCommand(forward=0.3), 4.0)
    assert end.com_position[0] > 0.8
    sway = 0.03 if gait == "drive" else 0.06  # the base goes back and forth between the feet that carry it
    assert np.mean([c.begin.com_velocity[0] for c in controls[-100:]]) == pytest.approx(0.3, abs=sway)
    assert abs(end.com_position[1]) < 0.05
    in_the_air = ~np.array([c.contact for c in controls])
    assert in_the_air.any() == (gait != "drive")
    assert np.all(np.array([c.force for c in controls])[in_the_air] == 0.0)


def test_walking_moves_without_rolling(mpc: Mpc) -> None:
    mpc.reset("walk")
    end, controls = run(mpc, VelocityCommand(forward=0.05), 7.0)
    assert end.com_position[0] > 0.05
    for control in controls:
        assert np.all(control.motion[control.contact] == 0.0)


def test_it_reaches_a_pose(mpc: Mpc) -> None:
    end, _ = run(mpc, PoseCommand(x=0.4, y=0.2, yaw_deg=30.0), 7.0)
    np.testing.assert_allclose(end.com_position[:2], [0.4, 0.2], atol=0.02)
    assert np.degrees(end.euler[0]) == pytest.approx(30.0, abs=1.5)


def test_a_mirrored_command_gives_a_mirrored_motion(mpc: Mpc) -> None:
    ends = []
    for sign in (1.0, -1.0):
        mpc.reset("drive")
        command = VelocityCommand(forward=0.2, lateral=0.1 * sign, turn_rate=0.3 * sign)
        ends.append(run(mpc, command, 2.5)[0])
    a, b = ends
    np.testing.assert_allclose(a.com_position * [1.0, -1.0, 1.0], b.com_position, atol=5e-3)
    np.testing.assert_allclose(a.euler * [-1.0, 1.0, -1.0], b.euler, atol=1e-2)
    assert a.euler[0] > 0.2


def test_inputs_keep_their_bounds(mpc: Mpc) -> None:
    _, controls = run(mpc, VelocityCommand(forward=0.4, turn_rate=-0.4), 2.0)
    bounds, period = mpc.settings.bounds, mpc.settings.period
    force = np.array([c.force for c in controls])
    speed = np.array([c.motion[:, 0] for c in controls])
    rate = np.array([c.motion[:, 1] for c in controls])
    slack = 0.05 * mpc.robot.weight  # one iteration in each period
    assert np.all(np.hypot(force[..., 0], force[..., 1]) <= bounds.friction * force[..., 2] * 1.42 + slack)
    assert force[..., 2].min() > 0.0
    assert np.abs(np.diff(speed, axis=0)).max() <= bounds.acceleration_max * period + 1e-9
    assert np.abs(rate).max() <= bounds.steering_rate_max * 1.05


def test_the_prediction_begins_with_the_state_and_the_control_leads_on(mpc: Mpc) -> None:
    plant = RigidPlant(mpc.robot)
    for _ in range(30):
        control, prediction = mpc.step(plant.state, VelocityCommand(forward=0.3))
        assert control.begin is plant.state
        np.testing.assert_allclose(prediction.com_position[0], plant.state.com_position)
        np.testing.assert_allclose(prediction.foot_position[0], plant.state.foot_position, atol=1e-9)
        assert prediction.time[0] == plant.state.time
        plant.step(control)
        np.testing.assert_allclose(plant.state.com_position, control.end.com_position, atol=1e-6)
        np.testing.assert_allclose(plant.state.euler, control.end.euler, atol=1e-5)


def test_feet_cannot_press_more_than_the_robot_weighs(mpc: Mpc) -> None:
    fair = mpc.robot.weight / 4.0
    with pytest.raises(InputError, match="what each foot carries"):
        mpc.set_bounds(force_min=1.001 * fair)
    _, controls = run(mpc, STANDING, 0.1)
    assert controls[-1].force[:, 2].min() < fair  # nothing has changed


def test_memory_stays_flat(mpc: Mpc) -> None:
    loop, command = ClosedLoop(mpc, RigidPlant(mpc.robot)), VelocityCommand(forward=0.2, gait="trot")
    count = 300
    for _ in range(80):
        loop.step(command)
    tracemalloc.start()
    try:
        for _ in range(20):
            loop.step(command)
        gc.collect()
        before, _ = tracemalloc.get_traced_memory()
        for _ in range(count):
            loop.step(command)
        gc.collect()
        after, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert after - before < 200 * count  # bytes: one state that is kept has two thousand


def test_another_mass_takes_effect_at_once(mpc: Mpc) -> None:
    light, problem = mpc.robot.mass, mpc._problem
    run(mpc, STANDING, 0.3)
    mpc.set_mass(1.2 * light)
    heavy = mpc.robot.model_copy(update={"mass": 1.2 * light})
    plant = RigidPlant(heavy)
    mpc.reset()
    for _ in range(100):
        control, _ = mpc.step(plant.state, STANDING)
        plant.step(control)
    assert control.force[:, 2].sum() == pytest.approx(heavy.weight, rel=2e-3)
    assert abs(plant.state.com_position[2] - heavy.height) < 5e-3
    assert mpc._problem is problem


def test_with_another_mass_a_robot_that_turns_is_predicted_to_turn_on_as_fast(mpc: Mpc) -> None:
    turning = replace(standing_state(mpc.robot), euler_rate=np.array([0.3, 0.0, 0.0]))
    turned = []
    for share in (1.0, 1.5):
        mpc.set_mass(share * mpc.robot.mass)
        mpc.reset("drive")
        _, prediction = mpc.step(turning, STANDING)
        turned.append(prediction.euler[1, 0] - prediction.euler[0, 0])
    assert turned[1] == pytest.approx(turned[0], rel=0.2)


def test_another_mass_is_carried_by_a_stand_without_a_solver(mpc: Mpc) -> None:
    mpc.set_mass(1.2 * mpc.robot.mass)
    mpc.stop("a test")
    control, _ = mpc.step(standing_state(mpc.robot), STANDING)
    assert control.force[:, 2].sum() == pytest.approx(1.2 * mpc.robot.weight)


@pytest.mark.parametrize("height", [np.nan, [0.0, 0.1], "high"])
def test_ground_that_is_no_height_is_refused(mpc: Mpc, height: object) -> None:
    with pytest.raises(InputError, match="ground"):
        mpc.set_ground(height)  # type: ignore[arg-type]
    control, _ = mpc.step(standing_state(mpc.robot), STANDING)
    assert control.end.is_finite()


def test_who_is_stopped_before_the_first_step_lifts_no_foot(mpc: Mpc) -> None:
    mpc.reset("trot")
    mpc.stop("a test")
    _, controls = run(mpc, VelocityCommand(forward=0.3), 1.5)
    assert all(control.contact.all() for control in controls)


def test_who_stands_for_good_expects_to_stay(mpc: Mpc) -> None:
    loop = ClosedLoop(mpc, RigidPlant(mpc.robot))
    for _ in range(30):
        loop.step(VelocityCommand(forward=0.3))
    mpc.stop("a test")
    _, prediction = loop.step(STANDING)
    assert np.ptp(prediction.com_position, axis=0).max() < 0.01


def test_after_a_reset_everything_is_noted_again(mpc: Mpc) -> None:
    plant, fast = RigidPlant(mpc.robot), VelocityCommand(forward=5.0)
    for _ in range(2):
        mpc.reset("drive")
        mpc.step(plant.state, fast)
        assert len(mpc.events) == 1


def test_other_weights_take_effect_at_once(mpc: Mpc) -> None:
    def sway() -> float:
        mpc.reset("drive")
        loop = ClosedLoop(mpc, RigidPlant(mpc.robot))
        loop.plant.push(np.array([0.0, 150.0, 0.0]), 0.1)
        ways = [loop.step(STANDING)[0].begin.com_position[1] for _ in range(120)]
        return float(np.abs(ways).max())

    stiff = sway()
    mpc.set_weights(goal=1.0, velocity=0.5)
    assert sway() > 1.05 * stiff
    with pytest.raises(InputError, match="valid: goal"):
        mpc.set_weights(gaol=1.0)


def test_a_higher_ground_lifts_the_robot(mpc: Mpc) -> None:
    mpc.set_ground(0.1)
    start = standing_state(mpc.robot)
    lift = np.array([0.0, 0.0, 0.1])
    raised = RobotState(
        **(
            vars(start)
            | {"com_position": start.com_position + lift, "foot_position": start.foot_position + lift}
        )
    )
    plant = RigidPlant(mpc.robot, raised)
    for _ in range(100):
        control, prediction = mpc.step(plant.state, STANDING)
        plant.step(control)
    assert plant.state.com_position[2] == pytest.approx(mpc.robot.height + 0.1, abs=3e-3)
    np.testing.assert_allclose(plant.state.foot_position[:, 2], 0.1)
    assert prediction.reference[0, 2] == pytest.approx(mpc.robot.height)


def test_a_gait_is_taken_up_without_a_foot_in_mid_swing(mpc: Mpc) -> None:
    mpc.reset("trot")
    loop = ClosedLoop(mpc, RigidPlant(mpc.robot))
    heights = []
    for step in range(200):
        gait = "crawl" if step > 75 else "trot"
        control, _ = loop.step(VelocityCommand(forward=0.1, gait=gait))
        heights.append(control.begin.foot_position[:, 2])
        assert np.all(control.begin.foot_position[control.contact, 2] < 1e-3)
    assert np.abs(np.diff(heights, axis=0)).max() < 0.02
    assert mpc.clock.gait.name == "crawl"


@pytest.mark.parametrize("command", [None, "forward", VelocityCommand(gait="gallop")])
def test_what_is_no_command_is_refused_and_the_controller_goes_on(mpc: Mpc, command: object) -> None:
    state = standing_state(mpc.robot)
    mpc.step(state, STANDING)
    with pytest.raises(InputError):
        mpc.step(state.at(0.01), command)  # type: ignore[arg-type]
    control, _ = mpc.step(state.at(0.01), STANDING)
    assert control.end.is_finite()


def test_the_first_step_needs_a_state(mpc: Mpc) -> None:
    with pytest.raises(InputError, match="state"):
        mpc.step(None, STANDING)


def test_standing_without_a_solver_carries_the_weight(mpc: Mpc) -> None:
    plant = RigidPlant(mpc.robot)
    plant.step(mpc.step(plant.state, STANDING)[0])
    mpc.stop("a test")
    for _ in range(100):
        control, prediction = mpc.step(plant.state, VelocityCommand(forward=0.5))
        plant.step(control)
    assert prediction.status.mode == "standing"
    assert not plant.fallen
    assert np.abs(plant.state.com_position - standing_state(mpc.robot).com_position).max() < 0.02
    held = standing_control(mpc.robot, plant.state, mpc.settings.period)
    np.testing.assert_allclose(control.force.sum(axis=0), held.force.sum(axis=0), atol=1e-3)
    assert "a test" in mpc.events[-1].text


@pytest.mark.parametrize(
    ("what", "says"),
    [
        ({"plant": "mujocco"}, "valid: mujoco"),
        ({"estimator": "exact"}, "valid: "),
        ({"gait": "trott"}, "valid: trot"),
        ({"robot": "centaur"}, "valid: centauro"),
    ],
)
def test_unknown_names_are_answered_by_the_known_ones(what: dict, says: str) -> None:
    with pytest.raises(UnknownNameError, match=says):
        make_loop(**({"robot": "centauro"} | what))


def test_a_rigid_body_has_no_friction_to_set() -> None:
    with pytest.raises(InputError, match="disturbances"):
        make_loop("centauro", "rigid", disturbances=Disturbances())


@pytest.mark.parametrize("estimator", ["noisy", "delayed"])
def test_it_moves_with_less_than_the_truth(built: Mpc, estimator: str) -> None:
    loop = make_loop(built.robot, "rigid", built.settings, estimator=estimator, kernels=False, seed=3)
    for _ in range(200):
        loop.step(VelocityCommand(forward=0.3))
    assert not loop.plant.fallen
    assert loop.plant.state.com_position[0] > 0.3
    assert not loop.mpc.events
