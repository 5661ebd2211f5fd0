"""States that no robot has, or that are not its own: the controller refuses them and says what was wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rollgait.errors import InputError
from rollgait.mpc.command import PoseCommand, VelocityCommand
from rollgait.mpc.incoming import LEAP_MAX, fault_of
from rollgait.mpc.loop import ClosedLoop
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.mpc.settings import MpcSettings
from rollgait.mpc.setup import make_loop
from rollgait.plant.stance import standing_state
from rollgait.plant.state import SHAPES, RobotState
from tests.mpc.builders import random_state

PATIENT = MpcSettings(deadline=60.0)
"""So that the load of the machine changes nothing."""
STANDING, MOVING = VelocityCommand(), VelocityCommand(forward=0.3, turn_rate=0.1)
FAULT_AT = 130
"""Step at which the fault begins: at full speed, with feet in the air where there are steps."""
SWAPS = {
    "front": [1, 0, 2, 3],
    "left": [2, 1, 0, 3],
    "sides": [1, 0, 3, 2],
    "diagonal": [3, 1, 2, 0],
}
"""Orders of legs that a wrong table of names gives."""


@pytest.fixture(scope="module")
def built() -> Mpc:
    """Without compiled kernels: the numbers are the same, and no compiler is needed."""
    return Mpc("centauro", PATIENT, kernels=False)


@pytest.fixture
def mpc(built: Mpc) -> Mpc:
    built.reset("drive")
    return built


def swapped(state: RobotState, order: list[int]) -> RobotState:
    return replace(
        state,
        foot_position=state.foot_position[order],
        heading=state.heading[order],
        speed=state.speed[order],
    )


@dataclass
class Spoilt:
    """Spoils the true states from a step on, as a function of all until now says."""

    spoil: Callable[[list[RobotState]], RobotState]
    begin: int = FAULT_AT
    count: int = 10**6
    past: list[RobotState] = field(default_factory=list)

    def __call__(self, true: RobotState, expected: RobotState | None) -> RobotState:
        self.past.append(true)
        step = len(self.past) - 1
        return self.spoil(self.past) if self.begin <= step < self.begin + self.count else true


def old_by(periods: int) -> Callable[[list[RobotState]], RobotState]:
    """A state of long ago that is said to be of now."""
    return lambda past: past[max(0, len(past) - 1 - periods)].at(past[-1].time)


def texts(mpc: Mpc) -> str:
    return "; ".join(event.text for event in mpc.events)


# -- believed by nobody ------------------------------------------------------------------------------------

PARTS_IN_WORDS = ("CoM", "foot", "yaw", "pitch")


def spoilt_parts(shape: tuple[int, ...]) -> st.SearchStrategy[Any]:
    """What may stand in the place of an array of this shape."""
    zeros = np.zeros(shape)
    values = st.sampled_from([np.nan, np.inf, -np.inf, 1e300, -1e300, 1e7])
    places = st.integers(0, zeros.size - 1)

    def with_value(place: int, value: float) -> np.ndarray:
        part = zeros.copy()
        part.flat[place] = value
        return part

    others = st.sampled_from(
        [
            zeros.tolist(),
            "abc",
            None,
            1.0,
            zeros.astype(complex),
            zeros.astype(str),
            zeros.astype(object),
            zeros.astype(bool),
            zeros.ravel()[:-1],
            zeros[None],
            [[1.0], [1.0, 2.0]],
        ]
    )
    return others | st.builds(with_value, places, values)


PARTS = st.sampled_from(sorted(set(SHAPES) - {"speed"})).flatmap(
    lambda name: st.tuples(st.just(name), spoilt_parts(SHAPES[name]))
)
TIMES = st.sampled_from([np.nan, np.inf, "now", None, [0.0], 1j, True + 1e300, 10**400, np.zeros(2)])


@given(PARTS | st.tuples(st.just("time"), TIMES))
def test_what_is_wrong_with_a_state_is_said_in_one_sentence(spoilt: tuple[str, Any]) -> None:
    name, value = spoilt
    fault = fault_of(replace(random_state(1), **{name: value}))
    assert fault.startswith("the state")
    assert "\n" not in fault
    assert len(fault) < 150


@given(st.integers(0, 2**32 - 1))
def test_a_usual_state_has_no_fault(seed: int) -> None:
    assert fault_of(random_state(seed)) == ""


@given(spoilt=PARTS | st.tuples(st.just("time"), TIMES))
@settings(max_examples=50)
def test_a_state_that_cannot_be_is_an_event_and_the_robot_goes_on(
    built: Mpc, spoilt: tuple[str, Any]
) -> None:
    built.reset("drive")
    name, value = spoilt
    plant = RigidPlant(built.robot)
    for step in range(4):
        state = plant.state if step != 2 else replace(plant.state, **{name: value})
        control, prediction = built.step(state, STANDING)
        plant.step(control)
        assert prediction.status.mode == ("coasting" if step == 2 else "tracking")
        assert control.end.is_finite()
    (event,) = built.events
    assert any(word in event.text for word in (name, *PARTS_IN_WORDS))
    built.reset("drive")
    with pytest.raises(InputError, match="state: cannot be used for the first step"):
        built.step(replace(plant.state, **{name: value}), STANDING)


@pytest.mark.parametrize("state", [{}, "standing", 3.0, [np.zeros(3)], standing_state])
def test_what_is_no_state_is_an_event(mpc: Mpc, state: Any) -> None:
    mpc.step(standing_state(mpc.robot), STANDING)
    control, _ = mpc.step(state, STANDING)
    assert control.end.is_finite()
    assert f"of type {type(state).__name__}" in texts(mpc)


@pytest.mark.parametrize("name", LEAP_MAX)
def test_one_leap_of_any_part_is_refused_and_leaves_nothing_behind(mpc: Mpc, name: str) -> None:
    plant, most = RigidPlant(mpc.robot), LEAP_MAX[name][0]
    for step in range(40):
        leap = (1.5 if step == 20 else 0.0) * most
        state = replace(plant.state, **{name: getattr(plant.state, name) + leap})
        control, prediction = mpc.step(state, MOVING)
        plant.step(control)
    assert f"the state's {name}" in texts(mpc)
    assert len(mpc.events) == 1
    assert prediction.status.mode == "tracking"


@pytest.mark.parametrize("ahead", [-1.0, 1e6])
def test_a_clock_that_leaps_once_is_refused_and_leaves_nothing_behind(mpc: Mpc, ahead: float) -> None:
    plant = RigidPlant(mpc.robot)
    for step in range(30):
        time = plant.state.time + (ahead if step == 20 else 0.0)
        control, prediction = mpc.step(plant.state.at(time), MOVING)
        plant.step(control)
    assert len(mpc.events) == 1
    assert prediction.status.mode == "tracking"


# -- believed by who does not look twice -------------------------------------------------------------------


@pytest.mark.parametrize("order", SWAPS.values(), ids=SWAPS)
def test_one_state_with_swapped_legs_does_not_make_it_stand(mpc: Mpc, order: list[int]) -> None:
    loop = ClosedLoop(
        mpc, RigidPlant(mpc.robot), Spoilt(lambda past: swapped(past[-1], order), begin=60, count=1)
    )
    for _ in range(160):
        _, prediction = loop.step(MOVING)
    assert not loop.plant.fallen
    assert prediction.status.mode == "tracking"
    assert np.hypot(*loop.plant.state.com_velocity[:2]) == pytest.approx(0.3, abs=0.05)
    assert "m from what was expected" in texts(mpc)


@pytest.fixture(scope="module", params=["drive", "crawl", "trot"])
def whole(request: pytest.FixtureRequest) -> Callable[[Spoilt], ClosedLoop]:
    """Makes a loop of the whole robot and of the bare controller, which gets spoilt states; and runs it."""
    pytest.importorskip("mujoco")
    pytest.importorskip("pinocchio")

    def run(known: Spoilt) -> ClosedLoop:
        made = make_loop("centauro", "mujoco", MpcSettings(deadline=1.0), gait=request.param)
        loop = ClosedLoop(made.mpc, made.plant, known)
        for _ in range(550):
            loop.step(MOVING)
        return loop

    return run


def assert_rests(loop: ClosedLoop) -> None:
    """On its feet, level, at rest, and no control that is not a number."""
    state = loop.plant.state
    assert not loop.plant.fallen
    assert np.degrees(np.abs(state.euler[1:])).max() < 2.0
    assert np.linalg.norm(state.com_velocity) < 0.02
    assert loop.control is not None
    assert all(np.isfinite(getattr(loop.control.end, part.name)).all() for part in fields(RobotState))


@pytest.mark.slow
@pytest.mark.parametrize("order", [SWAPS["front"], SWAPS["sides"]], ids=["front", "sides"])
def test_legs_swapped_for_good_bring_it_to_a_stand(
    whole: Callable[[Spoilt], ClosedLoop], order: list[int]
) -> None:
    loop = whole(Spoilt(lambda past: swapped(past[-1], order)))
    assert_rests(loop)
    assert "stands: no usable state for 0.1 s (the state's foot_position of " in texts(loop.mpc)


@pytest.mark.parametrize("begin", [FAULT_AT, pytest.param(0, marks=pytest.mark.slow)])
def test_states_one_second_old_do_not_fell_it(whole: Callable[[Spoilt], ClosedLoop], begin: int) -> None:
    loop = whole(Spoilt(old_by(100), begin=begin))
    assert not loop.plant.fallen
    if begin:
        assert "from what was expected" in texts(loop.mpc)
        assert_rests(loop)
    else:  # for a second it is the first one again and again
        assert_rests(loop)
        assert "the state stays the same while the robot is told to go" in texts(loop.mpc)


def test_a_source_that_has_stopped_is_believed_until_the_robot_should_have_moved(mpc: Mpc) -> None:
    plant = RigidPlant(mpc.robot)
    first = plant.state
    for step in range(100):
        mpc.step(first.at(0.01 * step), STANDING)
    assert not mpc.events  # who rests may say so for ever
    for step in range(100, 150):
        mpc.step(first.at(0.01 * step), MOVING)
    assert "the state stays the same while the robot is told to go" in mpc.events[0].text
    assert "stands" in mpc.events[-1].text


@pytest.mark.slow
def test_states_that_say_that_they_are_one_second_old_bring_it_to_a_stand(
    whole: Callable[[Spoilt], ClosedLoop],
) -> None:
    loop = whole(Spoilt(lambda past: past[-101]))
    assert_rests(loop)
    assert "old" in texts(loop.mpc)


# -- commands ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("command", "says"),
    [
        (VelocityCommand().model_copy(update={"forward": np.nan}), "command.forward: nan must be a finite"),
        (VelocityCommand().model_copy(update={"turn_rate": np.inf}), "command.turn_rate: inf must be"),
        (
            VelocityCommand().model_copy(update={"lateral": "fast"}),
            "command.lateral: 'fast' must be a number",
        ),
        (VelocityCommand().model_copy(update={"height_change": 1j}), "command.height_change: 1j must be"),
        (VelocityCommand().model_copy(update={"gait": 3}), "command.gait: 3 must be"),
        (PoseCommand.model_construct(y=1.0), "command.x: must be given"),
        (PoseCommand(x=1.0).model_copy(update={"cruise": np.nan}), "command.cruise: nan must be a finite"),
    ],
)
def test_a_command_with_a_value_that_is_none_is_refused_and_nothing_has_changed(
    mpc: Mpc, command: Any, says: str
) -> None:
    plant = RigidPlant(mpc.robot)
    for _ in range(3):
        control, _ = mpc.step(plant.state, MOVING)
        plant.step(control)
    with pytest.raises(InputError, match=says):
        mpc.step(plant.state, command)
    control, prediction = mpc.step(plant.state, MOVING)
    assert prediction.status.mode == "tracking"
    assert not mpc.events


@pytest.mark.parametrize("size", [1e30, 1e300])
def test_a_command_beyond_all_measure_is_cut(mpc: Mpc, size: float) -> None:
    plant = RigidPlant(mpc.robot)
    for command in (
        VelocityCommand(forward=size, lateral=size, turn_rate=-size),
        PoseCommand(x=size, y=-size),
    ):
        for _ in range(20):
            control, prediction = mpc.step(plant.state, command)
            plant.step(control)
            assert control.end.is_finite()
        assert prediction.status.mode == "tracking"
