"""What is left of a plan, planned anew: as good as the plan, from the very start, and refused by name."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rollgait as rg
from rollgait.errors import InputError, NotSolvedError
from rollgait.ocp.problem import make_problem
from rollgait.transcription import transcribe
from rollgait.transcription.easing import GRACE

PLANNER = rg.Planner()
SWING = (0.8, 1.6)
IN_SWING, AT_NODE, STANDING = 1.15, 1.3, 0.45
"""s of the plan: in the first half of its swing, at a node in the second, before it."""
COST_TOLERANCE = 1e-5
"""Relative; what a solver leaves."""
EXACT = 1e-9
FAR_START = 1e-3
"""Relative; what a solver leaves that comes from another start."""
ROBOT = {"robot": "by its name, or spelled out"}
BOX = [0.15, 0.15, 0.05]
"""m; the start is a centimetre outside it."""

plan_rest = partial(PLANNER.plan, diagnose=False)


@pytest.fixture(scope="module")
def step() -> rg.Plan:
    """A step of a hind foot on a short way."""
    gait = {"kind": "schedule", "HR": [SWING]}
    return PLANNER.plan(rg.Scenario(robot="centauro", goal={"x": 0.12}, horizon=2.4, gait=gait))


@pytest.fixture(scope="module")
def renewed(step: rg.Plan) -> dict[float, rg.Plan]:
    """The rest of it, by the time from which on."""
    return {time: plan_rest(step.rest(time)) for time in (STANDING, IN_SWING, AT_NODE)}


def mirrored(state: rg.MotionState) -> rg.MotionState:
    """The state seen in the x–z plane."""
    swap, flip = [1, 0, 3, 2], np.array([1.0, -1.0, 1.0])
    return rg.MotionState(
        time=state.time,
        com_position=state.com_position * flip,
        euler=state.euler * [-1.0, 1.0, -1.0],
        com_velocity=state.com_velocity * flip,
        euler_rate=state.euler_rate * [-1.0, 1.0, -1.0],
        foot_position=state.foot_position[swap] * flip,
        heading=-state.heading[swap],
        speed=state.speed[swap],
        foot_velocity=state.foot_velocity[swap] * flip,
        force=None if state.force is None else state.force[swap] * flip,
        contact=state.contact[swap],
    )


@pytest.mark.parametrize("time", [STANDING, IN_SWING, AT_NODE])
def test_the_rest_of_a_plan_is_certified(renewed: dict[float, rg.Plan], time: float) -> None:
    assert renewed[time].certificate().passed, renewed[time].certificate().failures


@pytest.mark.parametrize("time", [STANDING, IN_SWING, AT_NODE])
def test_it_begins_exactly_at_the_state(step: rg.Plan, renewed: dict[float, rg.Plan], time: float) -> None:
    asked, begun = step.state_at(time), renewed[time].state_at(0.0)
    for name in ("com_position", "euler", "com_velocity", "euler_rate", "foot_position", "heading"):
        np.testing.assert_allclose(getattr(begun, name), getattr(asked, name), atol=EXACT, err_msg=name)
    assert renewed[time].horizon == pytest.approx(step.horizon - time)
    assert renewed[time].statistics.start_changes == ()


def test_it_is_no_worse_than_the_rest_of_the_old_plan(step: rg.Plan, renewed: dict[float, rg.Plan]) -> None:
    rest = step.rest(AT_NODE)
    transcribed = transcribe("condensed", make_problem(rest.scenario), None)
    old = sum(transcribed.nlp.costs(transcribed.encode(rest.motion)).values())
    assert renewed[AT_NODE].statistics.cost <= old * (1.0 + COST_TOLERANCE)


def test_a_foot_in_the_air_keeps_its_touch_down(step: rg.Plan, renewed: dict[float, rg.Plan]) -> None:
    (swing,) = renewed[IN_SWING].schedule.swings()
    assert swing.begun == pytest.approx(IN_SWING - SWING[0])
    touch_down = renewed[IN_SWING].schedule.node_times[swing.touch_down]
    assert touch_down == pytest.approx(SWING[1] - IN_SWING)


def test_it_is_the_same_in_a_mirror() -> None:
    gait, seen = {"HR": [[-0.4, 0.5]], "nodes": [0.1 * k for k in range(13)]}, {"HL": [[-0.4, 0.5]]}
    plan = PLANNER.plan(
        rg.Scenario(robot="centauro", goal={"x": 0.1}, horizon=2.4, gait={"kind": "schedule", "HR": [SWING]})
    )
    moved = replace(
        plan.state_at(SWING[0] + 0.4), com_velocity=np.array([0.1, 0.05, 0.0]), euler_rate=np.full(3, 0.05)
    )
    x = {"goal": {"x": 0.15}, "horizon": 1.2, "robot": "centauro"}
    # a start needs swings that have begun, and these a start: both are said at once
    states = {"HR": moved, "HL": mirrored(moved)}
    found = {}
    for leg, state in states.items():
        swings = gait if leg == "HR" else {**seen, "nodes": gait["nodes"]}
        scenario = rg.Scenario(**x, gait={"kind": "schedule", **swings}, start={"motion": as_motion(state)})
        found[leg] = plan_rest(scenario)
    assert found["HL"].certificate().passed
    assert found["HL"].statistics.cost == pytest.approx(found["HR"].statistics.cost, rel=COST_TOLERANCE)


def as_motion(state: rg.MotionState) -> dict[str, Any]:
    """The state as a scenario says it."""
    names = ("com_position", "euler", "com_velocity", "euler_rate", "foot_position", "foot_velocity")
    return {name: getattr(state, name).tolist() for name in (*names, "heading", "speed")}


def test_a_pushed_state_is_a_start(step: rg.Plan) -> None:
    state = step.state_at(IN_SWING)
    pushed = replace(
        state,
        com_position=state.com_position + np.array([0.01, 0.01, 0.002]),
        com_velocity=state.com_velocity + np.array([0.0, 0.05, 0.0]),
        foot_position=state.foot_position + np.array([0.0, 0.0, 0.003]),
    )
    plan = plan_rest(step.rest(IN_SWING, pushed))
    assert plan.certificate().passed
    np.testing.assert_allclose(plan.state_at(0.0).com_position, pushed.com_position, atol=EXACT)
    changes = plan.statistics.start_changes
    assert len(changes) == 3, "the feet that stand are put on the ground, the other is where it is"
    assert all("height above the ground" in change for change in changes)


def test_a_plan_from_a_start_beyond_its_box_comes_back(step: rg.Plan) -> None:
    state = step.state_at(STANDING)
    beyond = replace(state, com_position=state.com_position + np.array([0.0, 0.0, -0.06]))
    tight = step.rest(STANDING).scenario.with_values({"bounds.box": BOX})
    plan = PLANNER.plan(tight, start=beyond, diagnose=False)
    assert plan.certificate().passed
    later = plan.sample(np.linspace(GRACE, plan.horizon, 50))
    below = later.foot_position[..., 2] - later.com_position[:, None, 2] - plan.robot.stance[:, 2]
    first = plan.sample(0.0)
    assert (first.foot_position[:, 2] - first.com_position[2] - plan.robot.stance[:, 2]).max() > BOX[2]
    assert below[later.contact].max() <= BOX[2] + 1e-3, "it is back in its box"


def test_it_plans_the_same_from_its_file(renewed: dict[float, rg.Plan], tmp_path: Path) -> None:
    plan = renewed[IN_SWING]
    loaded = rg.Plan.load(plan.save(tmp_path / "rest"))
    assert loaded.certificate().passed
    assert loaded.schedule == plan.schedule
    path = tmp_path / "rest.yaml"
    path.write_text(plan.scenario.to_yaml(brief=True))
    read = rg.find_scenario(str(path))
    assert read.resolved().to_dict() | ROBOT == plan.scenario.to_dict() | ROBOT
    again = plan_rest(read)
    assert again.statistics.cost == pytest.approx(plan.statistics.cost, rel=FAR_START)


def test_what_is_put_off_stands_meanwhile(step: rg.Plan) -> None:
    delay = 0.3
    plan = plan_rest(step.rest(STANDING, delay=delay))
    (swing,) = plan.schedule.swings()
    assert plan.schedule.node_times[swing.lift_off] == pytest.approx(SWING[0] - STANDING + delay)
    assert plan.certificate().passed
    with pytest.raises(InputError, match=r"delay: 0.3 must be 0 while a foot is in the air: HR"):
        step.rest(IN_SWING, delay=delay)


def test_a_state_that_cannot_be_a_start_is_refused_by_name(step: rg.Plan) -> None:
    state = step.state_at(STANDING)
    with pytest.raises(InputError, match=r"time: 2.3 must lie in \[0, 2.2\] s"):
        step.rest(2.3)
    flying = replace(state, foot_position=state.foot_position + np.array([0.0, 0.0, 0.05]))
    with pytest.raises(InputError, match=r"start.FL.height above the ground"):
        step.rest(STANDING, flying)
    fallen = replace(state, euler=np.array([0.0, 0.9, 0.0]))
    with pytest.raises(InputError, match=r"start.motion.euler: 0.9 must be at most 0.5 rad"):
        step.rest(STANDING, fallen)
    broken = replace(state, com_velocity=np.array([np.nan, 0.0, 0.0]))
    with pytest.raises(InputError, match=r"start.com_velocity: .* must be finite"):
        step.rest(STANDING, broken)
    given: Any = "here"
    with pytest.raises(InputError, match=r"start: .* must be a RobotState"):
        PLANNER.plan("wheeled", start=given)
    with pytest.raises(InputError, match="needs a gait whose times are given"):
        PLANNER.plan("kerb-discover", start=state)
    with pytest.raises(InputError, match=r"transcription: .collocation. cannot begin in motion"):
        rg.plan(step.rest(STANDING), transcription="collocation")


def test_a_start_far_outside_its_box_is_refused_by_its_bound(step: rg.Plan) -> None:
    state = step.state_at(STANDING)
    away = replace(state, com_position=state.com_position + np.array([0.0, 0.4, 0.0]))
    with pytest.raises(NotSolvedError, match=r"box of \w\w|joint_steering of \w\w|reach of \w\w"):
        plan_rest(step.rest(STANDING, away))


def test_a_swing_that_has_begun_needs_a_start_in_motion() -> None:
    gait = {"kind": "schedule", "HR": [[-0.3, 0.5]]}
    scenario = rg.Scenario(robot="centauro", goal={"x": 0.1}, horizon=2.0, gait=gait)
    with pytest.raises(
        InputError, match=r"gait.HR: .* lifts off before t = 0, which needs a start in motion"
    ):
        PLANNER.plan(scenario)


@pytest.fixture(scope="module")
def climbing() -> rg.Plan:
    """A way over a kerb of which the first foot is on top at the end of its swing."""
    return PLANNER.plan("kerb", diagnose=False)


BEFORE_STEP, STEPPING, ON_TOP = 1.05, (1.25, 1.27, 1.36, 1.65), 8.0
"""s of the plan over a kerb: the first foot stands by the riser, swings over it; all stand beyond it."""
OVER_DITCH = (2.24, 5.5)
"""s of the plan over a gap: feet in the air, above it."""
LIMIT = 0.746
"""m, x of the first foot in front of the riser, where plans have it at the farthest."""


@pytest.mark.parametrize("time", STEPPING)
def test_in_a_swing_over_a_riser_the_rest_is_as_near_as_the_plan(climbing: rg.Plan, time: float) -> None:
    plan = plan_rest(climbing.rest(time))
    assert plan.certificate().passed, plan.certificate().failures
    assert plan.statistics.start == "warm start"


@pytest.mark.parametrize("nearer", [0.004, 0.012, 0.025])
def test_a_foot_too_near_to_an_edge_stands_there_until_it_leaves(climbing: rg.Plan, nearer: float) -> None:
    state = climbing.state_at(BEFORE_STEP)
    place = state.foot_position.copy()
    place[0, 0] = LIMIT + nearer
    plan = plan_rest(climbing.rest(BEFORE_STEP, replace(state, foot_position=place)))
    assert plan.certificate().passed, plan.certificate().failures
    (change,) = plan.statistics.start_changes
    assert change == f"FL stands {nearer:.3g} m nearer to an edge than it may, until it leaves"
    standing = plan.sample(np.linspace(0.0, 0.05, 5)).foot_position[:, 0, 0]
    assert standing.max() <= LIMIT + nearer + 1e-6


def test_a_foot_on_an_edge_is_no_start(climbing: rg.Plan) -> None:
    state = climbing.state_at(BEFORE_STEP)
    place = state.foot_position.copy()
    place[0, 0] = LIMIT + 0.06
    with pytest.raises((InputError, NotSolvedError), match=r"FL"):
        plan_rest(climbing.rest(BEFORE_STEP, replace(state, foot_position=place)))


@pytest.mark.parametrize(("sunk", "verdict"), [(0.03, "pass"), (0.09, "fail")])
def test_a_body_that_begins_too_low_may_for_the_judge_as_for_the_solver(
    climbing: rg.Plan, sunk: float, verdict: str
) -> None:
    state = climbing.state_at(ON_TOP)
    low = replace(state, com_position=state.com_position - np.array([0.0, 0.0, sunk]))
    rest = climbing.rest(ON_TOP, low)
    lowest = min(box.z for box in climbing.robot.underside.belly)
    asked = climbing.robot.height + lowest - 0.01
    asking = rest.scenario.with_values({"bounds.body_clearance": float(asked)})
    certificate = plan_rest(replace(rest, scenario=asking)).certificate()
    (row,) = [row for row in certificate.rows if row.name == "body_clearance"]
    assert row.verdict == verdict, row


def test_a_ditch_below_a_foot_asks_nothing_of_the_base() -> None:
    plan = PLANNER.plan("gap", diagnose=False)
    for time in OVER_DITCH:
        again = plan_rest(plan.rest(time))
        assert again.certificate().passed, again.certificate().failures
