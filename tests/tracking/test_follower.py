"""The follower: kinematics and statics of what it emits, and what it does with what it cannot follow."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("pinocchio", reason="needs the extra whole-body")
pytest.importorskip("daqp", reason="needs the extra whole-body")

import rollgait as rg
from rollgait.plant.control import Control
from rollgait.plant.stance import standing_control, standing_state
from rollgait.plant.state import RobotState
from rollgait.robot.robot import GRAVITY
from rollgait.robot.urdf_model import BASE_V
from rollgait.robot.whole_body import library_whole_body
from rollgait.tracking.follower import Follower
from tests.tracking.builders import controls

PERIOD = 0.01
ROBOT = rg.find_robot("centauro")
STANDING = standing_state(ROBOT)
DRIVE = {"kind": "drive"}


@pytest.fixture(scope="module")
def shared() -> Follower:
    return Follower(library_whole_body("centauro"))


@pytest.fixture
def follower(shared: Follower) -> Follower:
    shared.reset(STANDING)
    return shared


@pytest.fixture(scope="module")
def drive(shared: Follower) -> list[Control]:
    """A short drive to the front and the side, with a turn, as controls."""
    goal = {"x": 0.4, "y": 0.2, "yaw_deg": 20.0}
    plan = rg.plan(rg.Scenario(robot="centauro", goal=goal, horizon=4.0, gait=DRIVE))
    return controls(plan, shared.model, PERIOD)


def turned(state: RobotState, yaw: float, shift: np.ndarray) -> RobotState:
    """The same state in another world."""
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return replace(
        state,
        com_position=R @ state.com_position + shift,
        euler=state.euler + np.array([yaw, 0.0, 0.0]),
        com_velocity=R @ state.com_velocity,
        foot_position=state.foot_position @ R.T + shift,
        heading=state.heading + yaw,
    )


def moved(control: Control, yaw: float, shift: np.ndarray) -> Control:
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    begin, end = (turned(state, yaw, shift) for state in (control.begin, control.end))
    return replace(control, begin=begin, end=end, force=control.force @ R.T)


def test_reset_stands_at_the_state(follower: Follower) -> None:
    start = turned(STANDING, 2.0 * np.pi + 0.7, np.array([3.0, -2.0, 0.0]))
    follower.reset(start)
    assert np.allclose(follower.state.p_com, start.com_position, atol=1e-6)
    assert np.allclose(follower.state.p_foot, start.foot_position, atol=1e-6)
    assert np.allclose(np.sin(follower.state.heading - start.heading), 0.0, atol=1e-6)


def test_standing_moves_nothing_and_balances_gravity(follower: Follower) -> None:
    control = standing_control(ROBOT, STANDING, PERIOD)
    before = follower.state.q
    for _ in range(20):
        target = follower.follow(control)
    assert np.allclose(target.position, before[BASE_V + 1 :], atol=1e-6)
    assert np.allclose(target.velocity, 0.0, atol=1e-6)
    state, nothing = follower.state, np.zeros(follower.model.nv)
    gravity = follower.model.inverse_dynamics(state.q, nothing, nothing)
    carried = np.einsum("lij,li->j", state.J_contact, control.force)
    assert np.allclose(target.torque, (gravity - carried)[BASE_V:], atol=1e-3)
    assert control.force[:, 2].sum() == pytest.approx(ROBOT.mass * GRAVITY)


def test_a_drive_is_followed(follower: Follower, drive: list[Control]) -> None:
    follower.reset(drive[0].begin)
    for control in drive:
        before = follower.state.q[BASE_V + 1 :]
        target = follower.follow(control)
        state, end = follower.state, control.end
        assert np.allclose(state.p_foot, end.foot_position, atol=1e-3)
        assert np.allclose(state.p_com, end.com_position, atol=1e-3)
        assert np.allclose(np.sin(state.heading - end.heading), 0.0, atol=np.radians(0.5))
        assert np.allclose(target.position - before, target.velocity * PERIOD, atol=1e-9)
    assert follower.failures == 0


def test_wheels_turn_as_they_roll(follower: Follower, drive: list[Control]) -> None:
    """Along its heading each wheel rolls the way the control says, over the whole drive."""
    follower.reset(drive[0].begin)
    wheels = [leg.wheel for leg in follower.model.legs]
    start = follower.state.q.copy()
    for control in drive:
        follower.follow(control)
    sign = follower.model.state(start).J_roll[range(4), wheels]
    radius = np.array([leg.radius for leg in follower.model.legs])
    rolled = sign * (follower.state.q - start)[[v + 1 for v in wheels]] * radius
    way = sum(control.motion[:, 0] * control.period for control in drive)
    assert np.allclose(rolled, way, rtol=0.05, atol=0.01)  # camber and tilt of the ankle turn it too


def test_torques_balance_what_the_planned_forces_move(follower: Follower, drive: list[Control]) -> None:
    """Newton's law of the whole: forces and gravity give the planned acceleration, so torques are modest."""
    follower.reset(drive[0].begin)
    torques = np.array([follower.follow(control).torque for control in drive])
    assert np.all(np.abs(torques) <= follower.model.effort_max)
    assert np.abs(np.diff(torques, axis=0)).max() < 40.0


def test_another_world_moves_no_joint(shared: Follower, drive: list[Control]) -> None:
    """Base and feet shifted and turned together from control to control: joints and torques stay the same."""
    rng = np.random.default_rng(0)
    results = []
    for scale in (0.0, 1.0):
        shared.reset(drive[0].begin)
        shift, yaw, targets = np.zeros(3), 0.0, []
        for control in drive[:150]:
            shift = shift + scale * 2e-3 * np.append(rng.normal(size=2), 0.0)
            yaw += scale * 2e-3 * rng.normal()
            targets.append(shared.follow(moved(control, yaw, shift)))
        results.append(targets)
    for one, other in zip(*results, strict=True):
        assert np.allclose(one.position, other.position, atol=1e-3)
        assert np.allclose(one.torque, other.torque, atol=2.0)


@pytest.mark.parametrize("field", ["com_position", "euler", "foot_position", "heading", "com_velocity"])
def test_what_is_no_number_is_held(follower: Follower, field: str) -> None:
    good = standing_control(ROBOT, STANDING, PERIOD)
    last = follower.follow(good)
    broken = replace(good.end, **{field: np.full_like(getattr(good.end, field), np.nan)})
    for number in (1, 2):
        held = follower.follow(replace(good, end=broken))
        assert follower.failed
        assert follower.failures == number
        assert np.array_equal(held.position, last.position)
        assert np.array_equal(held.torque, last.torque)
        assert np.all(held.velocity == 0.0)
    again = follower.follow(good)
    assert not follower.failed
    assert np.allclose(again.position, last.position, atol=1e-6)


@pytest.mark.parametrize("broken", [{"force": np.full((4, 3), np.inf)}, {"motion": np.full((4, 2), np.nan)}])
def test_forces_and_motions_that_are_no_numbers_are_held(follower: Follower, broken: dict) -> None:
    follower.follow(replace(standing_control(ROBOT, STANDING, PERIOD), **broken))
    assert follower.failed


def test_out_of_reach_is_approached_within_the_limits(follower: Follower) -> None:
    """Told to jump by a metre, the joints keep their limits, and all numbers stay numbers."""
    far = replace(STANDING, com_position=STANDING.com_position + np.array([0.3, 0.0, 1.0]))
    control = standing_control(ROBOT, far, PERIOD)
    before = follower.state.q[BASE_V + 1 :]
    for _ in range(100):
        target = follower.follow(control)
        assert np.isfinite(target.torque).all()
        assert np.all(target.position >= follower.model.position_lower - 1e-6)
        assert np.all(target.position <= follower.model.position_upper + 1e-6)
        assert np.all(np.abs(target.position - before) <= follower.model.velocity_max * PERIOD + 1e-6)
        before = target.position


def test_a_wheel_turns_by_its_way_along_the_ground(follower: Follower) -> None:
    control = standing_control(ROBOT, STANDING, PERIOD)
    wheels = [leg.wheel - BASE_V for leg in follower.model.legs if leg.wheel is not None]
    turned_by = []
    for factor in (None, np.ones(4), np.array([1.0, 1.5, 2.0, 1.1])):
        follower.reset(STANDING)
        rolling = replace(control, motion=np.tile([0.3, 0.0], (4, 1)), way_factor=factor)
        before = follower.state.q[BASE_V + 1 :][wheels].copy()
        turned_by.append(follower.follow(rolling).position[wheels] - before)
    np.testing.assert_allclose(turned_by[1], turned_by[0], atol=1e-12)
    np.testing.assert_allclose(turned_by[2], turned_by[0] * [1.0, 1.5, 2.0, 1.1], atol=1e-6)


def test_forces_beside_the_lowest_point_turn_the_wheel(follower: Follower) -> None:
    """A force that acts ahead of the axle by d turns the wheel by d · f more."""
    control = standing_control(ROBOT, STANDING, PERIOD)
    wheels = [leg.wheel - BASE_V for leg in follower.model.legs if leg.wheel is not None]
    torques = []
    for offset in (None, np.zeros((4, 3)), np.tile([0.02, 0.0, 0.0], (4, 1))):
        follower.reset(STANDING)
        torques.append(follower.follow(replace(control, contact_offset=offset)).torque[wheels])
    np.testing.assert_allclose(torques[1], torques[0], atol=1e-9)
    np.testing.assert_allclose(np.abs(torques[2] - torques[0]), 0.02 * control.force[:, 2], rtol=1e-3)
