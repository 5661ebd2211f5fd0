"""What goes wrong around the controller: the whole robot stands safely in MuJoCo, and the log says why."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.estimator import Dropping, Estimator, Truth
from rollgait.mpc.loop import ClosedLoop
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.settings import MpcSettings
from rollgait.mpc.setup import make_loop, observer
from rollgait.plant.state import RobotState

pytest.importorskip("mujoco")
pytest.importorskip("pinocchio")

GAITS = ("drive", "crawl", "trot")
FAULT_AT = 130
"""Step at which the fault begins: in crawl and trot with feet in the air, at full speed."""
DEADLINE = 1.0
"""s of wall time: how busy the machine is shall not decide about a test."""


@dataclass
class Spoiling:
    """Spoils the states of some periods: with what is no number, or with a number that cannot be."""

    spoilt: range
    offset: float = np.nan

    def __post_init__(self) -> None:
        self._count = -1

    def __call__(self, true: RobotState, expected: RobotState | None) -> RobotState | None:
        self._count += 1
        if self._count not in self.spoilt:
            return true
        return replace(true, com_position=true.com_position + np.array([0.0, self.offset, 0.0]))


@pytest.fixture(scope="module", params=GAITS)
def driving(request: pytest.FixtureRequest) -> Callable[..., ClosedLoop]:
    """Makes a loop in which the robot moves in a gait and is about to meet a fault."""

    def make(measurement: Estimator | None = None) -> ClosedLoop:
        loop = make_loop("centauro", "mujoco", MpcSettings(deadline=DEADLINE), gait=request.param)
        if measurement is not None:
            known = observer("mujoco", loop.mpc.settings.period, measurement)
            loop = ClosedLoop(loop.mpc, loop.plant, known)
        for _ in range(FAULT_AT):
            loop.step(COMMAND)
        return loop

    return make


COMMAND = VelocityCommand(forward=0.3, turn_rate=0.1)


def texts(mpc: Mpc) -> str:
    """All that the controller has noted."""
    return "; ".join(event.text for event in mpc.events)


def assert_stands(loop: ClosedLoop) -> None:
    """On its feet, level, at rest, all feet on the ground, and no control that is not a number."""
    state = loop.plant.state
    assert not loop.plant.fallen
    assert np.degrees(np.abs(state.euler[1:])).max() < 2.0
    assert np.linalg.norm(state.com_velocity) < 0.01
    assert np.abs(state.euler_rate).max() < 0.02
    assert state.foot_position[:, 2].max() < 0.005
    assert loop.control is not None
    assert np.isfinite(loop.control.force).all()
    assert np.isfinite(loop.control.motion).all()


def go_on(loop: ClosedLoop, seconds: float) -> None:
    for _ in range(round(seconds / loop.mpc.settings.period)):
        loop.step(COMMAND)


def assert_goes_on(loop: ClosedLoop) -> None:
    """It still follows the command."""
    begin = loop.plant.state
    go_on(loop, 3.0)
    end = loop.plant.state
    assert not loop.plant.fallen
    assert np.linalg.norm(end.com_position - begin.com_position) > 0.6
    assert loop.prediction is not None
    assert loop.prediction.status.mode == "tracking"


def test_few_lost_messages_are_made_up_for(driving: Callable[..., ClosedLoop]) -> None:
    loop = driving(Dropping(range(FAULT_AT, FAULT_AT + 5), Truth()))
    go_on(loop, 0.03)
    assert loop.prediction is not None
    assert loop.prediction.status.mode == "coasting"
    assert "no usable state has come" in texts(loop.mpc)
    assert_goes_on(loop)


def test_without_messages_the_robot_stands(driving: Callable[..., ClosedLoop]) -> None:
    loop = driving(Dropping(range(FAULT_AT, 10**6), Truth()))
    go_on(loop, 4.0)
    assert "stands: no usable state" in texts(loop.mpc)
    assert_stands(loop)


def test_a_state_with_nan_counts_as_none(driving: Callable[..., ClosedLoop]) -> None:
    loop = driving(Spoiling(range(FAULT_AT, FAULT_AT + 5)))
    go_on(loop, 0.05)
    assert "com_position holds a value that is not a number" in texts(loop.mpc)
    assert_goes_on(loop)


def test_nothing_but_nan_brings_it_to_a_stand(driving: Callable[..., ClosedLoop]) -> None:
    loop = driving(Spoiling(range(FAULT_AT, 10**6)))
    go_on(loop, 4.0)
    assert "stands: no usable state" in texts(loop.mpc)
    assert_stands(loop)


def test_a_state_that_no_robot_can_have_counts_as_none(driving: Callable[..., ClosedLoop]) -> None:
    loop = driving(Spoiling(range(FAULT_AT, 10**6), offset=1e4))  # ten kilometres from its feet
    go_on(loop, 4.0)
    assert "not one that a robot can have" in texts(loop.mpc)
    assert_stands(loop)


def test_a_measurement_far_from_what_was_expected_is_not_believed(driving: Callable[..., ClosedLoop]) -> None:
    loop = driving(Spoiling(range(FAULT_AT, 10**6), offset=0.6))
    go_on(loop, 4.0)
    assert "stands: no usable state" in texts(loop.mpc)
    assert "the state's com_position is 0." in texts(loop.mpc)
    assert_stands(loop)


def test_a_stall_of_50_ms_is_survived_and_noted(driving: Callable[..., ClosedLoop]) -> None:
    loop = driving()
    loop.stall(5)
    go_on(loop, 0.05)
    assert "60 ms ago" in texts(loop.mpc)
    assert_goes_on(loop)


def test_after_a_long_stall_it_stands(driving: Callable[..., ClosedLoop]) -> None:
    loop = driving()
    loop.stall(35)
    go_on(loop, 4.0)
    assert "stands: a stall of" in texts(loop.mpc)
    assert_stands(loop)


def test_a_command_beyond_the_limits_is_cut_and_noted(driving: Callable[..., ClosedLoop]) -> None:
    loop = driving()
    for _ in range(300):
        loop.step(VelocityCommand(forward=50.0, turn_rate=-9.0))
    assert "speed 50 m/s is cut to 0.8 m/s" in texts(loop.mpc)
    assert "turn rate -9 rad/s is cut" in texts(loop.mpc)
    assert texts(loop.mpc).count("is cut to 0.8 m/s") == 1  # once for a command, not in every period
    assert not loop.plant.fallen
    assert np.linalg.norm(loop.plant.state.com_velocity) < 1.0
    for _ in range(400):
        loop.step(VelocityCommand(gait="stand"))
    assert_stands(loop)


def test_ten_failed_solves_bring_it_to_a_stand(driving: Callable[..., ClosedLoop]) -> None:
    loop = driving()
    for count in range(1, 11):
        loop.mpc._iterate.states[1:] = 1e6  # a plan from which the solver finds no way back
        _, prediction = loop.step(COMMAND)
        assert prediction.status.mode == ("coasting" if count < 10 else "standing")
    go_on(loop, 4.0)
    assert "stands: 10 solves in a row have failed" in texts(loop.mpc)
    assert_stands(loop)


class Hurried:
    """The controller's solver, which always has time for one iteration only."""

    def __init__(self, solver: Any) -> None:
        self._solver = solver

    def __getattr__(self, name: str) -> Any:
        return getattr(self._solver, name)

    def solve(self, guess: Any, **options: Any) -> Any:
        return self._solver.solve(guess, **options | {"iterations": 1, "repair": None})


def test_a_solve_goes_on_where_the_one_before_was_cut(
    driving: Callable[..., ClosedLoop], monkeypatch: pytest.MonkeyPatch
) -> None:
    loop = driving()
    mpc = loop.mpc
    monkeypatch.setattr(mpc, "_solver", Hurried(mpc._solver))
    mpc._iterate.states[1:] += 0.1 * np.sin(np.arange(mpc._iterate.states[1:].size)).reshape(
        mpc._iterate.states[1:].shape
    )
    violations = []
    for _ in range(9):
        _, prediction = loop.step(COMMAND)
        violations.append(prediction.status.violation)
        if prediction.status.mode == "tracking":
            break
    assert len(violations) > 1
    assert all(after < before for before, after in pairwise(violations))
    assert prediction.status.mode == "tracking"
    assert_goes_on(loop)


def test_after_a_reset_it_moves_again(driving: Callable[..., ClosedLoop]) -> None:
    loop = driving()
    loop.mpc.stop("asked to")
    go_on(loop, 4.0)
    assert_stands(loop)
    loop.mpc.reset()
    go_on(loop, 1.0)
    assert_goes_on(loop)
