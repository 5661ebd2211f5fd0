"""A plan takes another one's place in mid-motion: where the robot is expected, or not at all."""

from __future__ import annotations

import numpy as np
import pytest

import rollgait as rg
from rollgait.errors import InputError
from rollgait.mpc.execution import execute
from rollgait.mpc.loop import ClosedLoop
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.plans.path import PlanPath
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.mpc.script import TimedPush

SWING, HR = (0.8, 1.6), 3
AHEAD, PERIOD = 0.5, 0.01
PLANNER = rg.Planner()
NEAR, FAST = 0.005, 0.03
"""m, m/s: so near to what was expected an undisturbed robot is half a second later."""


@pytest.fixture(scope="module")
def step() -> rg.Plan:
    """A step of a hind foot on a short way."""
    gait = {"kind": "schedule", "HR": [SWING]}
    return PLANNER.plan(rg.Scenario(robot="centauro", goal={"x": 0.12}, horizon=2.4, gait=gait))


@pytest.fixture
def loop(mpc: Mpc, step: rg.Plan) -> ClosedLoop:
    """A robot that begins to follow the step."""
    mpc.follow(step)
    return ClosedLoop(mpc, RigidPlant(mpc.robot, PlanPath(step).state(0.0)))


def run(loop: ClosedLoop, until: float) -> None:
    while loop.time < until - 1e-9:
        loop.step(rg.VelocityCommand())


def plan_ahead(loop: ClosedLoop, step: rg.Plan) -> tuple[rg.MotionState, rg.Plan]:
    """What is expected, and the rest of the plan from there."""
    progress = loop.mpc.progress
    assert progress is not None
    expected = loop.mpc.expected(AHEAD)
    plan_time = progress.plan_time + expected.time - loop.time + PERIOD
    return expected, PLANNER.plan(step.rest(plan_time, expected), diagnose=False)


def test_a_plan_takes_over_in_mid_swing(loop: ClosedLoop, step: rg.Plan) -> None:
    run(loop, 0.6)
    expected, new = plan_ahead(loop, step)
    assert new.certificate().passed
    assert not expected.contact[HR], "the foot is in the air then"
    run(loop, expected.time)
    state = loop.plant.state
    np.testing.assert_allclose(state.com_position, expected.com_position, atol=NEAR)
    np.testing.assert_allclose(state.com_velocity, expected.com_velocity, atol=FAST)
    np.testing.assert_allclose(state.foot_position, expected.foot_position, atol=2.0 * NEAR)
    before = state.foot_position[HR].copy()
    loop.mpc.replace(new, expected.time)
    loop.step(rg.VelocityCommand())
    assert np.abs(loop.plant.state.foot_position[HR] - before).max() < 0.02, "the foot goes on"
    run(loop, 4.0)
    progress = loop.mpc.progress
    assert progress is not None
    assert (progress.phase, progress.number) == ("done", 1)
    assert np.hypot(*(loop.plant.state.com_position - step.sample(step.horizon).com_position)[:2]) < 0.01
    assert not loop.mpc.events


def test_a_plan_that_does_not_begin_as_the_robot_moves_is_refused(loop: ClosedLoop, step: rg.Plan) -> None:
    run(loop, 0.4)
    in_swing = PLANNER.plan(step.rest(1.2), diagnose=False)
    with pytest.raises(InputError, match=r"HR.* must stand or swing as the plan has it"):
        loop.mpc.replace(in_swing, loop.time)
    state = step.state_at(0.4)
    aside = rg.MotionState.of(state)
    aside.com_position[1] += 0.04
    beside = PLANNER.plan(step.rest(0.4, aside), diagnose=False)
    with pytest.raises(InputError, match="must begin within 30 mm"):
        loop.mpc.replace(beside, loop.time)
    run(loop, 0.5)
    progress = loop.mpc.progress
    assert progress is not None
    assert (progress.phase, progress.number) == ("going", 0), "the old plan goes on"


def test_what_is_expected_is_refused_beyond_the_horizon(mpc: Mpc, loop: ClosedLoop) -> None:
    with pytest.raises(InputError, match="needs a step of the controller before"):
        mpc.expected(AHEAD)
    run(loop, 0.02)
    with pytest.raises(InputError, match=r"ahead: 3.0 must lie in"):
        mpc.expected(3.0)


def test_a_pushed_robot_gets_another_plan_and_says_so(mpc: Mpc) -> None:
    plan = PLANNER.plan(rg.Scenario(robot="centauro", goal={"x": 0.4}, horizon=3.0))
    loop = ClosedLoop(mpc, RigidPlant(mpc.robot, PlanPath(plan).state(0.0)))
    push = TimedPush(at=0.4, force=(0.0, 250.0, 0.0), duration=0.3)
    report = execute([plan], loop, pushes=[push], replan=True).report
    assert report.done
    assert report.replacements, "it was pushed by centimetres"
    for one in report.replacements:
        assert one.done or one.message
        assert any(str(one) in str(event) for event in report.controller.events)
    assert len({"replacements"} & report.to_dict().keys()) == 1
