"""Manoeuvres from where a robot stands: placed by the laws of rigid motions, carried out, stopped."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollgait.angles import turned
from rollgait.errors import InputError
from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.plans.manoeuvres import AHEAD, Manoeuvre, ahead, check_manoeuvre, manoeuvres_of, placed
from rollgait.mpc.plans.performer import Performer
from rollgait.mpc.plans.worker import Worker
from rollgait.mpc.settings import MpcSettings
from rollgait.mpc.setup import make_loop
from rollgait.plant.stance import standing_state
from rollgait.robot.library import find_robot
from rollgait.scenario.library import find_scenario
from rollgait.scenario.scenario import Scenario
from rollgait.view.driving.messages import Request
from rollgait.view.driving.session import GONE_AFTER, Session

ROBOT: Final = find_robot("centauro")
PLANNED_WITHIN: Final = 300.0
"""s of wall time: only a test that fails waits for so long."""
PATIENT: Final = MpcSettings(deadline=60.0)
"""So that the load of the machine changes nothing."""
FEET_BACK: Final = 0.06
"""m: the body may move so far while feet roll back to their places after steps that were to come did not."""
STEPS: Final = Manoeuvre(
    "steps",
    find_scenario("hybrid-forward").with_values(
        {"goal.x": 0.8, "goal.y": 0.1, "horizon": 7.0, "gait.steps": 3, "gait.pause_start": 0.5}
    ),
)
places = st.floats(-3.0, 3.0)


@given(places, places, st.floats(-7.0, 7.0), places, places, st.floats(-90.0, 90.0), st.floats(-1.0, 1.0))
def test_a_goal_is_the_same_as_the_robot_sees_it(
    x: float, y: float, yaw: float, gx: float, gy: float, turn: float, begin: float
) -> None:
    asked = Scenario.model_validate(
        {
            "robot": "centauro",
            "goal": {"x": gx, "y": gy, "yaw_deg": turn},
            "start": {"x": begin},
            "horizon": 60,
        }
    )
    found = placed(Manoeuvre("m", asked), ROBOT, standing_state(ROBOT, x=x, y=y, yaw=yaw), None)
    goal, start = found.goal, found.start
    seen = turned(np.array([goal.x - start.x, goal.y - start.y]), -np.radians(start.yaw_deg))
    assert seen == pytest.approx([gx - begin, gy], abs=1e-9)
    assert goal.yaw_deg - start.yaw_deg == pytest.approx(turn, abs=1e-9)
    assert (start.x, start.y) == pytest.approx((x, y), abs=1e-9)
    assert found.start_headings() == pytest.approx(np.zeros(4), abs=1e-9)


def test_feet_away_from_their_places_are_named() -> None:
    state = standing_state(ROBOT)
    state.foot_position[2, 0] += 0.1
    with pytest.raises(InputError, match=r"foot HL.*75 mm off"):
        placed(STEPS, ROBOT, state, None)


def test_another_robot_s_motion_is_refused() -> None:
    for one in manoeuvres_of(ROBOT):
        check_manoeuvre(one, ROBOT)
    with pytest.raises(InputError, match="must be of the robot rover"):
        check_manoeuvre(STEPS, find_robot("rover"))


@pytest.mark.parametrize("distance", [-1.0, 0.0, 1e9, float("nan")])
def test_what_is_ahead_is_not_everywhere(distance: float) -> None:
    low, high = AHEAD
    with pytest.raises(InputError, match=rf"\[{low:g}, {high:g}\] m"):
        ahead(ROBOT, distance)


@pytest.fixture(scope="module")
def worker() -> Iterator[Worker]:
    found = Worker()
    yield found
    found.close()


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


class Driven:
    """A robot that is driven, on the planner's model."""

    def __init__(self, worker: Worker) -> None:
        self.clock = Clock()
        self.session = Session(lambda: make_loop(ROBOT, "rigid", PATIENT), self.clock, manoeuvres=[STEPS])
        self.session.performer.worker = worker

    @property
    def performer(self) -> Performer:
        return self.session.performer

    def say(self, manoeuvre: str = "", halt: bool = False, **velocity: float) -> None:
        command = VelocityCommand(gait="drive", **velocity)  # type: ignore[arg-type]
        self.session.handle(Request(command, manoeuvre=manoeuvre, halt=halt))

    def until(self, stage: str, seconds: float = 15.0) -> None:
        """Goes on until a manoeuvre is so far; planning takes no time of the robot's."""
        end, patience = self.session.loop.time + seconds, time.monotonic() + PLANNED_WITHIN
        while self.performer.stage != stage:
            if self.performer.stage == "planning":
                assert time.monotonic() < patience, "no plan"
                time.sleep(0.01)
                self.performer.update(self.session.loop.plant.state)
                continue
            self.session.step()
            assert self.session.loop.time < end, (self.performer.stage, list(self.session.loop.mpc.events))

    def after(self, seconds: float) -> np.ndarray:
        for _ in range(round(seconds / self.session.period)):
            self.session.step()
        state = self.session.loop.plant.state
        return np.array([*state.com_position[:2], state.euler[0]])


@pytest.fixture
def driven(worker: Worker) -> Driven:
    return Driven(worker)


def test_it_begins_where_the_robot_is_and_commands_count_again_at_its_end(driven: Driven) -> None:
    driven.say(lateral=0.2, turn_rate=0.3)
    driven.after(1.0)
    driven.say("steps")
    driven.until("following")
    begin = driven.after(0.0)
    driven.say(forward=0.4)  # nobody hears it
    assert driven.session.snapshot().manoeuvre.startswith("steps: following")
    lifted = []
    while driven.performer.stage == "following":
        driven.session.step()
        lifted.append(~driven.session.snapshot().contact)
    end = driven.after(0.0)
    assert np.any(lifted, axis=0).sum() == 3
    assert end - begin == pytest.approx([*turned(np.array([0.8, 0.1]), begin[2]), 0.0], abs=0.02)
    assert driven.session.snapshot().manoeuvre == ""
    driven.say(forward=0.3)
    assert np.hypot(*(driven.after(1.0) - end)[:2]) > 0.1


def test_it_stops_where_all_feet_stand_and_commands_count_again(driven: Driven) -> None:
    driven.say("steps")
    driven.until("following")
    while driven.session.snapshot().contact.all():
        driven.session.step()
    first = driven.session.snapshot().contact
    driven.say(halt=True)
    assert driven.performer.stage == "stopping"
    while driven.performer.stage:
        driven.session.step()
        assert (driven.session.snapshot().contact | ~first).all()  # no other foot lifts
    stopped = driven.after(0.0)
    assert driven.session.snapshot().contact.all()
    driven.say()
    assert np.abs(driven.after(1.0) - stopped).max() < FEET_BACK
    driven.say(forward=0.3)
    assert driven.after(1.5)[0] > stopped[0] + 0.1


def test_a_page_that_is_silent_stops_it(driven: Driven) -> None:
    driven.say("steps")
    driven.until("following")
    while driven.session.snapshot().contact.all():
        driven.session.step()
    driven.clock.now += GONE_AFTER + 0.01
    driven.session.step()
    assert driven.performer.stage == "stopping"
    driven.until("")
    assert driven.session.snapshot().contact.all()


def test_what_cannot_be_is_an_event_and_the_drive_goes_on(driven: Driven) -> None:
    driven.say("nothing")
    driven.say("steps")
    driven.say("steps")
    driven.say(halt=True)
    texts = [event.text for event in driven.session.loop.mpc.events]
    assert "manoeuvre: 'nothing'" in texts[0]
    assert "steps" in texts[0]  # which there are
    assert texts[1] == "steps: not begun, as steps is under way; stop it before"
    assert texts[2] == "steps: stopped before it began"
    driven.say(forward=0.3)
    assert driven.after(1.0)[0] > 0.1


def test_a_plan_that_cannot_be_is_said(driven: Driven) -> None:
    hopeless = Manoeuvre("far", STEPS.scenario.with_values({"goal.x": 4.4, "horizon": 4.0}))
    driven.performer.ask(hopeless, driven.session.loop.plant.state)
    driven.until("")
    assert any(event.text.startswith("far: ") for event in driven.session.loop.mpc.events)
