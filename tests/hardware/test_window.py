"""A window onto a run: what is said is so; who commands from outside has a dead man's switch."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

pytest.importorskip("mujoco", reason="the extra 'whole-body' is not installed")
pytest.importorskip("rosbags", reason="the extra 'ros' is not installed")

from rollgait.hardware.operator import COMMAND_TIMEOUT
from rollgait.hardware.topics import (
    DIAGNOSTICS,
    GOAL,
    JOINT_COMMANDS,
    PLAN,
    SHOWN,
    VELOCITY,
    decoded,
    encoded,
)
from rollgait.hardware.transports.loopback import End, Loopback
from rollgait.hardware.window import Window
from rollgait.mpc.command import PoseCommand, VelocityCommand
from rollgait.mpc.loop import ClosedLoop
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.mpc.setup import make_loop
from rollgait.ros.messages import vector
from rollgait.ros.topics import JOINT_STATES, MARKERS, ODOMETRY, TF
from rollgait.view.driving.messages import Request
from rollgait.view.driving.session import Session

TURN = VelocityCommand(forward=0.3, turn_rate=0.3)


class Clock:
    """Time that passes when told."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


class Spectator:
    """Somebody at the other end, with all that was heard by topic."""

    def __init__(self, loopback: Loopback) -> None:
        self.end = loopback.end()
        self.heard: dict[str, list[dict[str, Any]]] = {topic.name: [] for topic in SHOWN}
        for topic in SHOWN:
            self.end.subscribe(
                topic, lambda data, topic=topic: self.heard[topic.name].append(decoded(topic, data))
            )

    def last(self, topic: Any) -> dict[str, Any]:
        self.end.receive(0.0)
        return self.heard[topic.name][-1]


def numbers(fields: dict[str, Any], axes: str = "xyz") -> np.ndarray:
    return np.array([fields[axis] for axis in axes])


def stamps(messages: list[dict[str, Any]]) -> list[int]:
    headers = [message["header"]["stamp"] for message in messages]
    return [header["sec"] * 10**9 + header["nanosec"] for header in headers]


@pytest.fixture
def loopback() -> Loopback:
    return Loopback()


@pytest.fixture(scope="module", params=["rigid", "mujoco"])
def run(request: pytest.FixtureRequest) -> tuple[ClosedLoop, Spectator]:
    """A loop that has been shown for a second while it drove along a curve."""
    loopback = Loopback()
    window, seen = Window(loopback.end(), "a test"), Spectator(loopback)
    loop = make_loop("centauro", request.param, kernels=False)
    for _ in range(100):
        loop.step(TURN)
        window.after(loop)
    seen.end.receive(0.0)
    return loop, seen


def test_the_robot_is_where_it_is_said_to_be(run: tuple[ClosedLoop, Spectator]) -> None:
    loop, seen = run
    odometry = seen.last(ODOMETRY)
    place = odometry["pose"]["pose"]
    turn = Rotation.from_quat(numbers(place["orientation"], "xyzw"))
    yaw, pitch, roll = turn.as_euler("ZYX")
    np.testing.assert_allclose([yaw, pitch, roll], loop.plant.state.euler, atol=1e-9)
    assert np.linalg.norm(numbers(place["position"])[:2] - loop.plant.state.com_position[:2]) < 0.15
    moved = np.diff([numbers(each["pose"]["pose"]["position"]) for each in seen.heard["/odom"][-3:]], axis=0)
    speed = turn.apply(numbers(odometry["twist"]["twist"]["linear"]))
    np.testing.assert_allclose(moved.mean(axis=0) / 0.01, speed, atol=0.02)  # what it says of its speed is so
    rate = turn.apply(numbers(odometry["twist"]["twist"]["angular"]))
    assert rate[2] == pytest.approx(loop.plant.state.euler_rate[0], abs=0.02)


def test_frames_plan_and_forces_are_those_of_the_loop(run: tuple[ClosedLoop, Spectator]) -> None:
    loop, seen = run
    frames = {each["child_frame_id"]: each["transform"] for each in seen.last(TF)["transforms"]}
    assert set(frames) == {"base_link", "fl_contact", "fr_contact", "hl_contact", "hr_contact"}
    places = [numbers(each["pose"]["position"]) for each in seen.last(PLAN)["poses"]]
    assert loop.prediction is not None
    assert len(places) == len(loop.prediction.com_position)
    assert np.linalg.norm(places[-1] - loop.prediction.com_position[-1]) < 0.03  # of some periods before
    arrows = [[numbers(point) for point in each["points"]] for each in seen.last(MARKERS)["markers"]]
    lifted = 1e3 * sum(end[2] - begin[2] for begin, end in arrows)
    assert lifted == pytest.approx(loop.mpc.robot.weight, rel=0.05)


def test_joints_and_what_they_are_told(run: tuple[ClosedLoop, Spectator]) -> None:
    loop, seen = run
    plant: Any = loop.plant
    if isinstance(plant, RigidPlant):
        assert seen.heard["/joint_states"] == seen.heard["/joint_commands"] == []  # it has none
        return
    state, told = seen.last(JOINT_STATES), seen.last(JOINT_COMMANDS)
    assert state["name"] == told["name"] == list(plant.joint_names)
    np.testing.assert_array_equal(state["position"], plant.pose.joint_position)
    np.testing.assert_array_equal(state["velocity"], plant.velocity.joint_velocity)
    np.testing.assert_array_equal(state["effort"], plant.torque)
    np.testing.assert_array_equal(told["position"], plant.told.position)
    before, after = (np.array(each["position"]) for each in seen.heard["/joint_commands"][-2:])
    np.testing.assert_allclose((after - before) / 0.01, told["velocity"], atol=1e-9)
    np.testing.assert_allclose(state["position"], told["position"], atol=0.1)
    assert len(seen.heard["/joint_states"]) == len(seen.heard["/joint_commands"]) == 100


def test_diagnostics_say_how_it_goes(run: tuple[ClosedLoop, Spectator]) -> None:
    loop, seen = run
    (status,) = seen.last(DIAGNOSTICS)["status"]
    values = {each["key"]: each["value"] for each in status["values"]}
    assert (status["name"], status["hardware_id"], status["level"]) == ("a test", "centauro", 0)
    assert (values["phase"], values["gait"], values["plant"]) == ("tracking", "drive", loop.plant.name)


def test_stamps_go_on_where_a_loop_begins_anew(loopback: Loopback) -> None:
    window, seen = Window(loopback.end(), "a test"), Spectator(loopback)
    for _ in range(2):
        loop = make_loop("centauro", "rigid", kernels=False)
        for _ in range(5):
            loop.step(VelocityCommand())
            window.after(loop)
    seen.end.receive(0.0)
    assert np.diff(stamps(seen.heard["/odom"])) == pytest.approx(10**7, abs=2)


# -- commands from outside ------------------------------------------------------------------------------


class Outside:
    """A page's session with a window, and a hand at the other end."""

    def __init__(self, loopback: Loopback) -> None:
        self.clock = Clock()
        self.window = Window(loopback.end(), "a test", (VELOCITY,), self.clock)
        self.hand: End = loopback.end()
        self.session = Session(
            lambda: make_loop("centauro", "rigid", kernels=False), self.clock, window=self.window
        )

    def say(self, forward: float) -> None:
        self.hand.publish(VELOCITY, encoded(VELOCITY, {"linear": vector([forward, 0.0, 0.0])}))
        self.session.step()

    def page(self, forward: float, stops: int = 0) -> None:
        self.session.handle(Request(VelocityCommand(forward=forward, gait="trot"), stops=stops))

    @property
    def asked(self) -> float:
        return self.session.command.forward


@pytest.fixture
def outside(loopback: Loopback) -> Outside:
    return Outside(loopback)


def test_who_commands_from_outside_drives_while_the_page_rests(outside: Outside) -> None:
    outside.page(0.0)
    outside.say(0.2)
    assert outside.asked == 0.2
    assert outside.session.command.gait == "trot"  # of the page
    outside.page(-0.1)
    assert outside.asked == -0.1  # who sits at the page goes first
    outside.page(0.0)
    assert outside.asked == 0.2


def test_silence_outside_stops_the_robot(outside: Outside) -> None:
    outside.say(0.2)
    outside.clock.now = COMMAND_TIMEOUT
    outside.page(0.0)
    assert outside.asked == 0.2
    outside.clock.now = COMMAND_TIMEOUT + 0.01
    assert outside.asked == 0.0
    outside.say(0.2)
    assert outside.asked == 0.2


def test_stop_on_the_page_stops_until_they_have_let_go(outside: Outside) -> None:
    outside.say(0.2)
    outside.page(0.0, stops=1)
    assert outside.asked == 0.0
    outside.say(0.2)  # still held
    assert outside.asked == 0.0
    outside.clock.now = COMMAND_TIMEOUT + 0.01
    outside.session.step()
    outside.say(0.2)
    assert outside.asked == 0.2


def test_in_a_pause_they_are_heard_and_nothing_moves(outside: Outside) -> None:
    outside.session.handle(Request(VelocityCommand(), paused=True))
    before = outside.session.loop.time
    outside.say(0.2)
    assert outside.session.loop.time == before
    assert outside.asked == 0.2


@pytest.mark.parametrize(
    ("topic", "fields", "command"),
    [
        (VELOCITY, {"linear": vector([0.1, 0.2, 0.0])}, VelocityCommand(forward=0.1, lateral=0.2)),
        (
            GOAL,
            {"pose": {"position": vector([1.0, 2.0, 0.0]), "orientation": {"w": 1.0}}},
            PoseCommand(x=1, y=2),
        ),
    ],
)
def test_a_run_asks_who_is_outside(loopback: Loopback, topic: Any, fields: Any, command: Any) -> None:
    from rollgait.hardware.window import Showing

    clock = Clock()
    window, hand = Window(loopback.end(), "a test", (VELOCITY, GOAL), clock), loopback.end()
    ask: Callable[[], Any] | None = Showing(window, make_loop("centauro", "rigid", kernels=False)).ask
    assert ask is not None
    assert ask() == VelocityCommand(gait="stand")  # nobody is there
    hand.publish(topic, encoded(topic, fields))
    window.listen()
    assert ask() == command.model_copy(update={"gait": "drive"})
    clock.now = COMMAND_TIMEOUT + 0.01
    assert ask() == VelocityCommand(gait="stand")


def test_what_is_no_command_is_an_event_of_the_run(outside: Outside) -> None:
    outside.hand.publish(VELOCITY, b"no message")
    outside.session.step()
    outside.session.step()
    assert any("/cmd_vel was refused" in event.text for event in outside.session.loop.mpc.events)
    assert outside.asked == 0.0
