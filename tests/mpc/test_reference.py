"""What the horizon shall look like: it gets where it is told to, within what a robot can follow."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rollgait as rg
from rollgait.mpc.clock import GaitClock
from rollgait.mpc.command import PoseCommand, VelocityCommand
from rollgait.mpc.gaits import GAITS
from rollgait.mpc.reference import LEASH, TURN_LEASH, Reference, ReferenceMaker
from rollgait.mpc.settings import CommandLimits
from rollgait.plant.stance import standing_state
from rollgait.plant.state import RobotState
from tests.mpc.builders import mirrored

ROBOT = rg.find_robot("centauro")
LIMITS = CommandLimits()


def symmetric(robot: rg.Robot) -> rg.Robot:
    """The same robot with the steering ranges of its left legs, mirrored, on the right: its own differ."""
    data = robot.model_dump(mode="json")
    for left, right in (("FL", "FR"), ("HL", "HR")):
        low, high = data["legs"][left]["steering"]
        data["legs"][right]["steering"] = [-high, -low]
    return rg.Robot.model_validate(data)


SYMMETRIC = symmetric(ROBOT)
STEP, COUNT, INTERVAL = 0.02, 10, 0.1
STEERING_RATE = 2.0
few = settings(max_examples=15)


class Follower:
    """A robot that is always where the reference was, its wheels turned as fast as they can."""

    def __init__(self, gait: str = "drive", start: RobotState | None = None, robot: rg.Robot = ROBOT) -> None:
        self.maker = ReferenceMaker(robot, LIMITS, STEERING_RATE, ROBOT.height)
        self.state = standing_state(ROBOT) if start is None else start
        self.maker.reset(self.state)
        self.clock = GaitClock(gait)
        self.poses, self.twists = [self.maker.pose], [self.maker.twist]
        self.reference: Reference | None = None

    def go(self, command: VelocityCommand | PoseCommand, duration: float) -> None:
        for _ in range(round(duration / STEP)):
            time = self.state.time + STEP
            self.clock.advance(time)
            self.reference = self.maker.look_ahead(self.state, command, self.clock, STEP, COUNT, INTERVAL)
            x, y, yaw = self.maker.pose
            heading = self.state.heading + yaw - self.state.euler[0]
            turn = np.clip(
                self.reference.heading[:, 0] - heading, -STEERING_RATE * STEP, STEERING_RATE * STEP
            )
            self.state = RobotState(
                time=time,
                com_position=np.array([x, y, ROBOT.height]),
                euler=np.array([yaw, 0.0, 0.0]),
                com_velocity=self.state.com_velocity,
                euler_rate=self.state.euler_rate,
                foot_position=self.state.foot_position,
                heading=heading + turn,
                speed=self.state.speed,
            )
            self.poses.append(self.maker.pose)
            self.twists.append(self.maker.twist)


@few
@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-180.0, 180.0))
def test_it_reaches_a_pose_and_stays_there(x: float, y: float, yaw: float) -> None:
    robot, goal = Follower(), PoseCommand(x=x, y=y, yaw_deg=yaw)
    robot.go(goal, 20.0)
    for duration in (0.0, 2.0):
        robot.go(goal, duration)
        found = robot.maker.pose
        assert math.hypot(found[0] - x, found[1] - y) < 0.01
        assert abs(found[2] - math.radians(yaw)) < math.radians(1.0)


@few
@given(st.floats(-0.8, 0.8), st.floats(-0.8, 0.8), st.floats(-0.8, 0.8), st.sampled_from(sorted(GAITS)))
def test_velocity_and_acceleration_are_limited(
    forward: float, lateral: float, turn: float, gait: str
) -> None:
    robot = Follower(gait)
    asked, _ = VelocityCommand(forward=forward, lateral=lateral, turn_rate=turn).within(LIMITS)
    robot.go(asked, 4.0)
    robot.go(PoseCommand(x=0.5, y=-0.5, yaw_deg=90.0), 2.0)
    robot.go(VelocityCommand(forward=-0.5), 2.0)
    twists = np.array(robot.twists)
    change = np.diff(twists, axis=0) / STEP
    assert np.hypot(twists[:, 0], twists[:, 1]).max() <= min(LIMITS.speed, GAITS[gait].speed_max) + 1e-9
    assert np.abs(twists[:, 2]).max() <= min(LIMITS.turn_rate, GAITS[gait].turn_rate_max) + 1e-9
    assert np.hypot(change[:, 0], change[:, 1]).max() <= LIMITS.acceleration + 1e-9
    assert np.abs(change[:, 2]).max() <= LIMITS.turn_acceleration + 1e-9


@few
@given(st.floats(-0.7, 0.7), st.floats(-0.7, 0.7))
def test_a_velocity_is_reached_and_kept(forward: float, turn: float) -> None:
    robot = Follower()
    robot.go(VelocityCommand(forward=forward, turn_rate=turn), 6.0)
    assert robot.reference is not None
    np.testing.assert_allclose(robot.maker.twist, (forward, 0.0, turn), atol=0.02)
    moves = robot.reference.rate
    np.testing.assert_allclose(np.hypot(moves[0], moves[1]), abs(forward), atol=0.02)
    np.testing.assert_allclose(moves[3], turn, atol=0.02)


@few
@given(st.floats(0.0, 2.0 * math.pi), st.sampled_from([VelocityCommand(forward=0.8), PoseCommand(x=9.0)]))
def test_it_stays_near_a_robot_that_does_not_move(yaw: float, command: VelocityCommand | PoseCommand) -> None:
    state = standing_state(ROBOT, yaw=yaw)
    maker, clock = ReferenceMaker(ROBOT, LIMITS, STEERING_RATE, ROBOT.height), GaitClock("drive")
    maker.reset(state)
    for _ in range(200):
        maker.look_ahead(state, command, clock, 0.05, COUNT, INTERVAL)
        x, y, turned = maker.pose
        assert math.hypot(x, y) <= LEASH + 1e-9
        assert abs(turned - yaw) <= TURN_LEASH + 1e-9


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_a_full_turn_is_a_full_turn(turn: float) -> None:
    robot = Follower()
    robot.go(PoseCommand(x=0.0, yaw_deg=360.0 * turn), 20.0)
    assert robot.maker.pose[2] == pytest.approx(2.0 * math.pi * turn, abs=0.02)
    steering = robot.state.heading - robot.state.euler[0]
    ranges = np.array([leg.steering for leg in ROBOT.leg_list])
    assert np.all((steering > ranges[:, 0]) & (steering < ranges[:, 1]))


@few
@given(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.floats(-0.6, 0.6))
def test_left_is_to_right_as_right_is_to_left(forward: float, lateral: float, turn: float) -> None:
    one, other = (
        Follower(start=start, robot=SYMMETRIC)
        for start in (standing_state(ROBOT), mirrored(standing_state(ROBOT)))
    )
    one.go(VelocityCommand(forward=forward, lateral=lateral, turn_rate=turn), 3.0)
    other.go(VelocityCommand(forward=forward, lateral=-lateral, turn_rate=-turn), 3.0)
    np.testing.assert_allclose(np.array(one.poses) * [1.0, -1.0, -1.0], other.poses, atol=0.02)


def test_wheels_point_along_the_way_of_their_feet_or_against_it() -> None:
    robot, asked = Follower(), VelocityCommand(forward=0.3, lateral=0.1, turn_rate=0.3)
    robot.go(asked, 5.0)
    assert robot.reference is not None
    p = ROBOT.stance
    way = np.arctan2(0.1 + 0.3 * p[:, 0], 0.3 - 0.3 * p[:, 1])
    steering = robot.reference.heading[:, 0] - robot.reference.pose[3, 0]
    np.testing.assert_allclose(np.sin(steering - way), 0.0, atol=0.05)
    size = np.hypot(0.1 + 0.3 * p[:, 0], 0.3 - 0.3 * p[:, 1])
    np.testing.assert_allclose(robot.reference.speed[:, 0], size * np.cos(steering - way), atol=0.03)


@pytest.mark.parametrize("gait", ["stand", "walk"])
def test_wheels_that_do_not_roll_have_no_speed(gait: str) -> None:
    robot = Follower(gait)
    robot.go(VelocityCommand(forward=0.3), 3.0)
    assert robot.reference is not None
    assert np.all(robot.reference.speed == 0.0)
    assert (robot.maker.pose[0] > 0.01) == (gait == "walk")


def test_the_height_changes_slowly() -> None:
    robot, heights = Follower(), [ROBOT.height]
    for _ in range(60):
        robot.go(VelocityCommand(height_change=-0.05), STEP)
        assert robot.reference is not None
        heights.append(robot.reference.pose[2, 0])
    assert heights[-1] == pytest.approx(ROBOT.height - 0.05)
    assert np.abs(np.diff(heights)).max() <= 0.1 * STEP + 1e-12
