"""The controller of robots whose wheels cannot be steered, or that have none: what stands does not slip."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.loop import ClosedLoop
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.mpc.settings import MpcSettings
from rollgait.mpc.setup import make_loop
from rollgait.mpc.support import support_margin
from rollgait.plant.state import RobotState
from rollgait.robot.library import find_robot
from tests.mpc.test_footwork import with_box

Array = NDArray[np.float64]
PATIENT = MpcSettings(deadline=10.0)
"""How busy the machine is shall not decide about a test."""


def run(
    kind: Literal["fixed", "point"], seconds: float, gait: str, told: str = "", **command: Any
) -> tuple[RobotState, Array]:
    """The last state, and the fastest that feet on the ground moved along their heading and across, m/s.

    Events say what the feet cannot do, `told`, and nothing else.
    """
    loop: ClosedLoop = make_loop(find_robot("centauro").with_feet(kind), "rigid", PATIENT, gait=gait)
    fastest = np.zeros(2)
    for _ in range(round(seconds / PATIENT.period)):
        before = loop.plant.state
        control, _ = loop.step(VelocityCommand(gait=gait, **command))
        after = loop.plant.state
        velocity = (after.foot_position - before.foot_position)[control.contact, :2] / PATIENT.period
        heading = 0.5 * (before.heading + after.heading)[control.contact]
        along, across = (
            np.stack([np.cos(heading), np.sin(heading)]),
            np.stack([-np.sin(heading), np.cos(heading)]),
        )
        for axis, direction in enumerate((along, across)):
            fastest[axis] = max(fastest[axis], np.abs((direction * velocity.T).sum(axis=0)).max(initial=0.0))
        assert not loop.plant.fallen
    assert all(told and told in event.text for event in loop.mpc.events)
    assert len(loop.mpc.events) == bool(told)
    return loop.plant.state, fastest


@pytest.mark.parametrize("forward", [0.2, -0.2])
def test_fixed_wheels_drive_straight(forward: float) -> None:
    state, (along, across) = run("fixed", 2.0, "drive", forward=forward)
    assert state.com_velocity[0] == pytest.approx(forward, abs=0.01)
    assert abs(state.com_position[1]) < 1e-3
    assert abs(state.euler[0]) < 1e-3
    assert along == pytest.approx(0.2, abs=0.03)
    assert across < 1e-6


@pytest.mark.parametrize(
    "command", [{"turn_rate": 0.3}, {"lateral": 0.1}, {"forward": 0.2, "turn_rate": 0.3}]
)
def test_fixed_wheels_never_slip_sideways_whatever_they_are_told(command: dict[str, float]) -> None:
    state, (_, across) = run(
        "fixed", 2.0, "drive", told="wheels that do not steer only roll ahead", **command
    )
    assert across < 1e-3  # the heading turns within a period
    assert abs(state.euler[0]) < 0.02  # it goes straight on
    assert state.com_velocity[0] == pytest.approx(command.get("forward", 0.0), abs=0.02)


def test_fixed_wheels_turn_by_steps() -> None:
    state, (_, across) = run("fixed", 3.0, "trot", turn_rate=0.15)
    assert state.euler[0] == pytest.approx(0.15 * 3.0, abs=0.1)
    assert np.hypot(*state.com_position[:2]) < 0.05
    assert across < 1e-3


def test_fixed_wheels_go_sideways_by_steps() -> None:
    state, (_, across) = run("fixed", 4.0, "trot", lateral=0.1)
    assert state.com_position[1] == pytest.approx(0.4, abs=0.08)
    assert abs(state.com_position[0]) < 0.05
    assert across < 1e-3


def test_point_feet_stand_still_and_walk() -> None:
    state, fastest = run("point", 3.0, "trot", forward=0.1)
    assert state.com_position[0] > 0.15
    np.testing.assert_allclose(fastest, 0.0, atol=1e-9)


def test_point_feet_do_not_roll_and_say_so() -> None:
    state, fastest = run("point", 1.0, "drive", told="point feet do not roll", forward=0.2)
    np.testing.assert_allclose(state.com_position[:2], 0.0, atol=0.01)
    np.testing.assert_allclose(fastest, 0.0, atol=1e-9)


def test_legs_that_cannot_sway_do_not_step_and_say_so() -> None:
    """It would fall: the body leans over the feet that stand, or a foot farther out catches it."""
    loop = make_loop(with_box(find_robot("rover"), 0.002), "rigid", PATIENT, gait="trot")
    for _ in range(200):
        control, _ = loop.step(VelocityCommand(forward=0.2, turn_rate=0.2, gait="crawl"))
        assert control.contact.all()
    assert loop.plant.state.com_velocity[0] == pytest.approx(0.2, abs=0.02)
    told = [event.text for event in loop.mpc.events]
    assert "cannot go sideways or turn" in told[0]
    assert [text for text in told if "the gait 'trot' is 'drive' here" in text]
    assert len(told) == len(set(told))


def least_margin(loop: ClosedLoop, seconds: float) -> float:
    """How far inside the three feet that stand the CoM is at least in the middle of swings, m."""
    margins = []
    for _ in range(round(seconds / PATIENT.period)):
        loop.step(VelocityCommand(turn_rate=0.05))
        state, clock = loop.plant.state, loop.mpc.clock
        swings = clock.swings(state.time, state.time + PATIENT.period)
        if any(
            abs(state.time - 0.5 * (swing.lift_off + swing.touch_down)) < PATIENT.period for swing in swings
        ):
            resting = replace(state, com_velocity=np.zeros(3), speed=np.zeros(4))
            margins.append(support_margin(resting, clock.contact(state.time)))
    assert len(margins) >= 3
    return min(margins)


def test_the_com_stays_over_the_feet_that_stand_while_one_swings() -> None:
    """A small robot needs as much room there as a large one: it tipped over the edge of its support."""
    margin = PATIENT.bounds.com_margin
    loop = make_loop("strider", "rigid", PATIENT, gait="walk")
    assert least_margin(loop, 4.0) > 0.7 * margin
    other = ClosedLoop(loop.mpc, RigidPlant(loop.mpc.robot))
    loop.mpc.set_weights(support=0.0)
    loop.mpc.reset("walk")
    assert least_margin(other, 4.0) < 0.7 * margin
