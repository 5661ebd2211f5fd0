"""Plans as references of the controller: looked up as they are, followed, held, joined, refused."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

import rollgait as rg
from rollgait.errors import InputError
from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.execution import Execution, execute
from rollgait.mpc.loop import ClosedLoop
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.plans.clock import LATE_MAX, SINK_RATE, FollowedSwing, PlanClock
from rollgait.mpc.plans.path import HOVER, PlanPath, PlanSwing
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.mpc.script import TimedPush
from tests.mpc.conftest import PATIENT

SWING = (0.8, 1.6)
HR = 3
DISTANCE, YAW, FOOTHOLD = 0.01, np.radians(1.0), 0.015
"""An execution is as near to its plan: m, rad, m."""
PERIOD = 0.01
ALL = np.ones(4, dtype=bool)


@pytest.fixture(scope="module")
def step() -> rg.Plan:
    """A step of a hind foot on a short way."""
    gait = {"kind": "schedule", "HR": [SWING]}
    return rg.plan(rg.Scenario(robot="centauro", goal={"x": 0.12}, horizon=2.4, gait=gait))


@pytest.fixture(scope="module")
def walked() -> rg.Plan:
    """A step of a hind foot of a robot whose wheels are locked."""
    gait = {"kind": "schedule", "HR": [SWING], "wheels": "locked"}
    return rg.plan(rg.Scenario(robot="centauro", goal={"x": 0.08}, horizon=2.4, gait=gait))


@pytest.fixture(scope="module")
def onward() -> rg.Plan:
    """A drive from where `step` ends."""
    scenario = rg.Scenario(
        robot="centauro", start={"x": 0.12}, goal={"x": 0.3}, horizon=1.6, gait={"kind": "drive"}
    )
    return rg.plan(scenario)


@pytest.fixture(scope="module")
def shared() -> Mpc:
    return Mpc("centauro", PATIENT, kernels=False)


@pytest.fixture
def loop(shared: Mpc, step: rg.Plan) -> Iterator[ClosedLoop]:
    """The controller, and the rigid body as `step` begins."""
    shared.reset("drive")
    yield ClosedLoop(shared, RigidPlant(shared.robot, PlanPath(step).state(0.0)))
    shared.reset("drive")


def assert_near(found: Execution, holds: int | None = 0) -> None:
    report = found.report
    assert report.passed
    assert report.final_distance < DISTANCE
    assert report.final_angle < YAW
    assert report.foothold_worst < FOOTHOLD
    if holds is not None:
        assert report.holds == holds


# -- looking up ------------------------------------------------------------------------------------------


def test_a_path_is_the_plan(step: rg.Plan) -> None:
    times = np.linspace(0.0, step.horizon, 333)
    row, samples = PlanPath(step).at(times), step.sample(times)
    for name in ("com_position", "euler", "com_velocity", "foot_position", "heading"):
        np.testing.assert_allclose(getattr(row, name), getattr(samples, name), atol=2e-3, err_msg=name)


def test_means_add_up(step: rg.Plan) -> None:
    path, random = PlanPath(step), np.random.default_rng(0)
    for times, k in ((np.sort(random.uniform(-1.0, 4.0, 3)), k) for _ in range(50) for k in range(2)):
        a, b, c = times
        parts, whole = path.means(np.array([a, b, c]))[k], path.means(np.array([a, c]))[k][0]
        np.testing.assert_allclose((b - a) * parts[0] + (c - b) * parts[1], (c - a) * whole, atol=1e-5)


def test_a_plan_carries_the_robot_on_the_whole(step: rg.Plan) -> None:
    """Its mean force is its change of momentum and its weight."""
    force = PlanPath(step).means(np.array([0.0, step.horizon]))[0][0].sum(axis=0)
    np.testing.assert_allclose(force, [0.0, 0.0, step.robot.weight], atol=1e-3 * step.robot.weight)


def swing_of(path: PlanPath, plan: rg.Plan) -> tuple[PlanSwing, np.ndarray]:
    """The first swing of a plan, and times within it."""
    swing = path.swings[0]
    return swing, np.linspace(swing.lift_off, swing.touch_down, 161)


def test_feet_that_stand_where_they_land_are_there_before_they_touch_the_ground(walked: rg.Plan) -> None:
    path = PlanPath(walked)
    swing, times = swing_of(path, walked)
    foot = path.at(times).foot_position[:, swing.leg]
    low = (times > 0.5 * (swing.lift_off + swing.touch_down)) & (foot[:, 2] - swing.foothold[2] < 0.9 * HOVER)
    assert low.sum() > 10
    np.testing.assert_allclose(foot[low, :2], np.tile(swing.foothold[:2], (low.sum(), 1)), atol=1e-3)
    own = walked.sample(times).foot_position[:, swing.leg]
    assert np.linalg.norm(own[low, :2] - swing.foothold[:2], axis=1).max() > 5e-3  # planned, they still go on
    np.testing.assert_allclose(foot[:, 2], own[:, 2], atol=1e-4)


def test_such_feet_keep_to_the_planned_way(walked: rg.Plan) -> None:
    path = PlanPath(walked)
    swing, times = swing_of(path, walked)
    foot = path.at(times).foot_position[:, swing.leg, :2]
    way = walked.sample(np.linspace(swing.lift_off, swing.touch_down, 2001)).foot_position[:, swing.leg, :2]
    away = np.linalg.norm(foot[:, None] - way, axis=2)
    assert away.min(axis=1).max() < 5e-4
    assert (np.diff(np.argmin(away, axis=1)) >= 0).all()  # and never go back


def test_their_motions_are_those_of_their_places(walked: rg.Plan) -> None:
    path = PlanPath(walked)
    swing, times = swing_of(path, walked)
    moved = np.cumsum(np.diff(times)[:, None] * path.means(times)[1][:, swing.leg], axis=0)
    foot = path.at(times).foot_position[:, swing.leg, :2]
    np.testing.assert_allclose(moved, foot[1:] - foot[0], atol=1e-3)


# -- the clock -------------------------------------------------------------------------------------------


def clock_at(path: PlanPath, time: float) -> PlanClock:
    clock = PlanClock(path, 0.0)
    for now in np.arange(PERIOD, time + 1e-9, PERIOD):
        clock.advance(float(now))
    return clock


@pytest.mark.parametrize("wait", [0.0, 0.013, 0.5, 2.0])
def test_a_clock_that_waited_is_later_by_that(step: rg.Plan, wait: float) -> None:
    path, edges = PlanPath(step), np.arange(0.0, 3.0, 0.1)
    one, other = PlanClock(path, 0.0), PlanClock(path, 0.0)
    other.hold(wait)
    np.testing.assert_allclose(one.stance_share(edges), other.stance_share(edges + wait), atol=1e-6)
    assert other.plan_time(1.0) == pytest.approx(one.plan_time(1.0) - wait)


def test_contacts_are_the_plans(step: rg.Plan) -> None:
    clock = PlanClock(PlanPath(step), 0.0)
    middles = np.arange(0.05, step.horizon, 0.1)
    planned = step.sample(middles).contact
    assert (np.array([clock.contact(time) for time in middles]) == planned).all()
    assert not planned.all()


def test_a_foot_that_is_stopped_high_up_stands(step: rg.Plan) -> None:
    now = SWING[0] + 0.7 * (SWING[1] - SWING[0])
    clock = clock_at(PlanPath(step), now)
    assert not clock.contact(now)[HR]
    clock.land(now, PERIOD, ALL)
    assert clock.contact(now).all()
    assert clock.shift == 0.0


def test_a_foot_that_grazes_the_ground_as_it_leaves_or_lands_goes_on(step: rg.Plan) -> None:
    for share in (0.1, 0.5, 0.97):
        now = SWING[0] + share * (SWING[1] - SWING[0])
        clock = clock_at(PlanPath(step), now)
        clock.land(now, PERIOD, ALL)
        assert not clock.contact(now)[HR]


def test_a_foot_that_finds_no_ground_is_waited_for_and_let_down_but_not_for_ever(step: rg.Plan) -> None:
    path, now = PlanPath(step), SWING[1] - PERIOD
    clock, nothing = clock_at(path, now), ALL & ~np.eye(4, dtype=bool)[HR]
    heights = []
    while not clock.contact(now)[HR]:
        clock.land(now, PERIOD, nothing)
        heights.append(clock.lift(np.array([now]))[0][0, HR])
        now += PERIOD
        clock.advance(now)
        assert now < SWING[1] + 1.0
    assert clock.shift == pytest.approx(LATE_MAX, abs=1.5 * PERIOD)
    assert heights[-1] < -0.005
    assert (np.diff(heights) < 1e-9).all()


@pytest.mark.parametrize("begin", [0.0, -0.2, 0.15])
@pytest.mark.parametrize("end", [0.0, 0.2, -0.1])
@pytest.mark.parametrize("waited", [0.0, 0.07, LATE_MAX])
def test_a_lift_goes_from_the_ground_to_the_ground_and_as_far_below_as_it_is_let_down(
    step: rg.Plan, begin: float, end: float, waited: float
) -> None:
    """Whatever the heights under both footholds, up a kerb or down; its rates add up to its way."""
    path = PlanPath(step)
    (planned,) = path.swings
    swing = FollowedSwing(HR, SWING[0], SWING[1] + waited, 0.0, path, planned, waited)
    times = np.linspace(swing.lift_off, swing.touch_down, 2001)
    z, rate = swing.over(times, begin, 0.0, end)
    planned_z, _ = path.foot_height(HR, np.array(SWING))
    assert z[0] == pytest.approx(begin, abs=1e-9)
    assert z[-1] == pytest.approx(end - SINK_RATE * waited, abs=1e-9)
    assert planned_z == pytest.approx([0.0, 0.0], abs=1e-6)
    assert np.trapezoid(rate, times) == pytest.approx(z[-1] - z[0], abs=1e-3)


# -- following -------------------------------------------------------------------------------------------


def test_a_step_is_carried_out_as_planned(loop: ClosedLoop, step: rg.Plan) -> None:
    found = execute([step], loop)
    assert_near(found)
    assert [foothold.leg for foothold in found.report.footholds] == [HR]
    assert found.report.shift < 0.1
    # the contacts are those of the plan, at the time of the plan
    begin = found.log.time[~found.log.contact[:, HR]][0] - SWING[0]
    planned = step.sample(np.clip(found.log.time - begin + 1e-6, 0.0, step.horizon)).contact
    assert (found.log.contact == planned).all()


def test_who_is_pushed_off_waits_and_goes_on(loop: ClosedLoop, step: rg.Plan, onward: rg.Plan) -> None:
    push = TimedPush(at=2.6, force=(0.0, 450.0, 0.0), duration=0.2)
    found = execute([step, onward], loop, pushes=[push])
    assert_near(found, holds=None)
    assert found.report.holds >= 1
    assert any("waits" in event.text for event in found.log.events)
    assert any("goes on" in event.text for event in found.log.events)


def test_a_plan_goes_on_where_the_one_before_ended(loop: ClosedLoop, step: rg.Plan, onward: rg.Plan) -> None:
    found = execute([step, onward], loop)
    assert_near(found)
    assert found.log.com_position[-1, 0] == pytest.approx(0.3, abs=DISTANCE)


def test_a_turned_robot_follows_as_if_it_had_not_turned(loop: ClosedLoop, step: rg.Plan) -> None:
    """Whole turns of the yaw are nothing to a plan."""
    mpc, start = loop.mpc, PlanPath(step).state(0.0)
    ends = []
    for turn in (0.0, 4.0 * np.pi):
        mpc.reset("drive")
        euler = np.append(start.euler[0] + turn, start.euler[1:])
        state = replace(start, euler=euler, heading=start.heading + turn)
        plant = RigidPlant(mpc.robot, state)
        mpc.follow(step)
        for _ in range(40):
            control, _ = mpc.step(plant.state, VelocityCommand())
            plant.step(control)
        ends.append(plant.state)
    np.testing.assert_allclose(ends[0].com_position, ends[1].com_position, atol=1e-6)
    assert ends[1].euler[0] - ends[0].euler[0] == pytest.approx(4.0 * np.pi, abs=1e-6)


def test_a_wheel_that_has_waited_for_the_ground_rolls_at_once(loop: ClosedLoop, step: rg.Plan) -> None:
    """It stands over its place meanwhile; it is not sped up from there as if it had stood on the ground."""
    mpc, nothing = loop.mpc, ALL & ~np.eye(4, dtype=bool)[HR]
    planned = PlanPath(step).at(np.array([SWING[1] + PERIOD])).speed[0, HR]
    mpc.follow(step)
    speeds = []
    while not speeds or not mpc.clock.contact(loop.plant.state.time)[HR]:
        now = loop.plant.state
        control, _ = mpc.step(now, VelocityCommand(), nothing)
        loop.plant.step(control)
        clock = mpc.clock
        assert isinstance(clock, PlanClock)
        if clock.waiting(now.time)[HR]:
            speeds.append(control.motion[HR, 0])
    control, _ = mpc.step(loop.plant.state, VelocityCommand(), ALL)
    assert len(speeds) > 5
    assert planned > 0.02
    assert not any(speeds)
    assert control.motion[HR, 0] > 0.8 * planned


def test_who_leaves_a_plan_is_commanded_again(loop: ClosedLoop, step: rg.Plan) -> None:
    mpc = loop.mpc
    mpc.follow(step)
    loop.step(VelocityCommand(forward=0.5))
    assert mpc.progress is not None
    mpc.leave()
    assert mpc.progress is None
    for _ in range(150):
        _, prediction = loop.step(VelocityCommand(forward=0.3))
    assert mpc.clock.gait.name == "drive"
    assert loop.plant.state.com_velocity[0] == pytest.approx(0.3, abs=0.05)
    assert prediction.status.mode == "tracking"


# -- refused ---------------------------------------------------------------------------------------------


def test_what_does_not_join_is_refused(loop: ClosedLoop, step: rg.Plan, onward: rg.Plan) -> None:
    with pytest.raises(InputError, match="must begin where the plan before it ends"):
        loop.mpc.follow(onward, step)
    with pytest.raises(InputError, match="at least one plan"):
        loop.mpc.follow()
    assert loop.mpc.progress is None
    loop.mpc.follow(onward)
    with pytest.raises(InputError, match="must begin where the robot is"):
        loop.step(VelocityCommand())
    loop.step(VelocityCommand())  # as if nothing had been
    assert loop.mpc.progress is None


def test_a_plan_of_another_robot_is_refused(loop: ClosedLoop, step: rg.Plan) -> None:
    with pytest.raises(InputError, match="must be of the robot"):
        loop.mpc.follow(replace(step, robot=rg.find_robot("centauro-2020")))


def test_what_is_changed_while_a_plan_is_followed_lasts(loop: ClosedLoop, step: rg.Plan) -> None:
    mpc = loop.mpc
    mpc.follow(step)
    loop.step(VelocityCommand())
    mpc.set_bounds(friction=0.4)
    mpc.leave()
    assert mpc._fill.bounds == mpc.settings.bounds.model_copy(update={"friction": 0.4})
    mpc.set_bounds(friction=mpc.settings.bounds.friction)


# -- physics ---------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_step_is_carried_out_in_physics(step: rg.Plan) -> None:
    pytest.importorskip("mujoco")
    from rollgait.mpc.execution import loop_for
    from rollgait.plant.disturbances import Disturbances, Payload

    loop = loop_for(
        step, "mujoco", settings=PATIENT, disturbances=Disturbances(payload=Payload(mass=5.0), friction=0.6)
    )
    assert_near(execute([step], loop))
