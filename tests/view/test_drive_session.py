"""A drive without a page: what is asked for happens, silence stops it, a fall can be got over."""

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.log import MpcLog
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.mpc.settings import MpcSettings
from rollgait.mpc.setup import make_loop
from rollgait.robot.library import find_robot
from rollgait.view.driving.messages import PushRequest, Request, Snapshot
from rollgait.view.driving.session import SILENCE_MAX, Session

FORWARD = Request(VelocityCommand(forward=0.3, gait="drive"))
STILL = Request(VelocityCommand(gait="drive"))
PATIENT = MpcSettings(deadline=60.0)
"""So that the load of the machine changes nothing."""


class Clock:
    """Time that passes when told."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def session(clock: Clock) -> Session:
    return Session(lambda: make_loop("centauro", "rigid", PATIENT), clock)


def after(session: Session, steps: int) -> Snapshot:
    for _ in range(steps):
        session.step()
    return session.snapshot()


def test_it_drives_as_it_is_asked_and_stops_when_nobody_asks(session: Session, clock: Clock) -> None:
    session.handle(FORWARD)
    moving = after(session, 100)
    assert moving.actual[0] == pytest.approx(0.3, abs=0.05)
    assert moving.state.com_position[0] > 0.1
    assert (moving.wheel_angle > 0.5).all()
    assert moving.mode == "tracking"
    clock.now = SILENCE_MAX + 0.01
    silent = after(session, 1)
    assert silent.command.forward == 0.0
    assert silent.command.gait == "drive"
    assert abs(after(session, 120).actual[0]) < 0.03


def test_the_actual_velocity_is_that_of_the_robot_wherever_it_looks(session: Session) -> None:
    session.handle(replace(FORWARD, command=VelocityCommand(turn_rate=0.5)))
    after(session, 150)
    session.handle(replace(FORWARD, command=VelocityCommand(lateral=0.2)))
    turned = after(session, 150)
    assert turned.state.euler[0] > 0.4
    assert turned.actual[1] == pytest.approx(0.2, abs=0.05)
    assert abs(turned.actual[0]) < 0.05


def test_another_gait_comes_with_the_next_request(session: Session) -> None:
    session.handle(Request(VelocityCommand(gait="trot")))
    assert after(session, 1).gait == "trot"
    lifted = [~after(session, 1).contact for _ in range(120)]
    assert np.any(lifted)


def test_a_push_is_felt_and_seen_while_it_lasts(session: Session) -> None:
    session.handle(replace(STILL, pushes=(PushRequest((0.0, 100.0, 0.0), 0.05),)))
    assert after(session, 3).pushed == pytest.approx([0.0, 100.0, 0.0])
    pushed = after(session, 3)
    assert pushed.pushed == pytest.approx(np.zeros(3))
    assert pushed.actual[1] > 0.01


def test_a_pull_lasts_until_it_is_taken_back_or_nobody_asks(session: Session, clock: Clock) -> None:
    session.handle(replace(STILL, pull=(80.0, 0.0, 0.0)))
    pulled = after(session, 10)
    assert pulled.actual[0] > 0.02
    assert pulled.pushed == pytest.approx([80.0, 0.0, 0.0])
    clock.now = SILENCE_MAX + 0.01
    assert after(session, 1).pushed == pytest.approx(np.zeros(3))


def test_a_robot_that_fell_lies_until_the_reset(clock: Clock) -> None:
    robot = find_robot("centauro")
    session = Session(lambda: make_loop(robot, RigidPlant(robot), PATIENT), clock)
    session.handle(replace(STILL, pushes=(PushRequest((0.0, 20_000.0, 0.0), 0.5),)))
    for _ in range(300):
        session.step()
        if session.loop.plant.fallen:
            break
    fallen = session.snapshot()
    assert fallen.mode == "fallen"
    assert not fallen.pushed.any()
    assert after(session, 5).state.time == fallen.state.time
    session.handle(replace(STILL, reset=True))
    stands = after(session, 20)
    assert stands.mode == "tracking"
    assert np.abs(stands.state.com_position[:2]).max() < 0.02


def test_a_robot_that_stands_for_good_drives_again_after_the_reset(session: Session) -> None:
    session.handle(FORWARD)
    after(session, 50)
    session.loop.mpc.stop("a test")
    stood = after(session, 100)
    assert stood.mode == "standing"
    assert "a test" in stood.events[-1][1]
    session.handle(replace(FORWARD, reset=True))
    moving = after(session, 100)
    assert moving.mode == "tracking"
    assert moving.actual[0] == pytest.approx(0.3, abs=0.05)


def test_requests_and_snapshots_travel_between_processes(session: Session) -> None:
    assert pickle.loads(pickle.dumps(FORWARD)) == FORWARD
    snapshot = session.snapshot()
    again: Snapshot = pickle.loads(pickle.dumps(snapshot))
    assert np.array_equal(again.com_path, snapshot.com_path)
    assert again.command == snapshot.command


def test_in_a_pause_time_stands_still_and_goes_on_afterwards(session: Session) -> None:
    session.handle(FORWARD)
    before = after(session, 50)
    session.handle(replace(FORWARD, paused=True))
    paused = after(session, 20)
    assert paused.mode == "paused"
    assert paused.state.time == before.state.time
    session.handle(FORWARD)
    on = after(session, 50)
    assert on.mode == "tracking"
    assert on.state.time == pytest.approx(before.state.time + 50 * session.period)
    assert on.actual[0] == pytest.approx(0.3, abs=0.05)


def test_a_recording_is_the_log_of_what_was_driven(session: Session, tmp_path: Path) -> None:
    file = tmp_path / "drive.npz"
    after(session, 30)
    recorded = replace(FORWARD, record=str(file))
    session.handle(recorded)
    begin = session.snapshot().state
    running = after(session, 60)
    assert running.recorded == pytest.approx(60 * session.period)
    assert running.written == ""
    session.handle(replace(recorded, paused=True))
    assert after(session, 10).recorded == running.recorded  # a pause is no part of it
    session.handle(FORWARD)
    done = session.snapshot()
    assert done.written == str(file)
    assert done.recorded == 0.0
    log = MpcLog.load(file)
    np.testing.assert_allclose(log.time, session.period * np.arange(60), atol=1e-9)
    np.testing.assert_array_equal(log.com_position[0], begin.com_position)
    assert log.wanted[-1, 0] == pytest.approx(0.3, abs=0.01)
    assert log.fallen_at is None
    session.handle(recorded)  # the same file again: it was recorded
    after(session, 5)
    assert session.snapshot().recorded == 0.0


def test_a_recording_ends_where_the_robot_falls(clock: Clock, tmp_path: Path) -> None:
    robot = find_robot("centauro")
    session = Session(lambda: make_loop(robot, RigidPlant(robot), PATIENT), clock)
    push = (PushRequest((0.0, 20_000.0, 0.0), 0.5),)
    session.handle(replace(STILL, pushes=push, record=str(tmp_path / "fall.npz")))
    for _ in range(300):
        session.step()
        if session.loop.plant.fallen:
            break
    assert session.snapshot().written
    log = MpcLog.load(tmp_path / "fall.npz")
    assert log.fallen_at == pytest.approx(log.time[-1] + session.period)
