"""Laws of the solution as a function of time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollgait.errors import InputError
from rollgait.plan.plan import MAX_SAMPLES, Plan
from rollgait.plan.samples import Array
from rollgait.plan.trajectory import CollocationTrajectory, feet_in_world
from rollgait.polynomials import HEIGHT_POINTS, STATE_POINTS, gauss_points, lagrange
from rollgait.robot import Robot, find_robot
from rollgait.scenario import ContactSchedule, Scenario, find_scenario
from tests.view.builders import motion_plan

FEET_KINDS = ("steerable", "fixed", "point")
STEP = 1e-6
"""s, of the finite differences."""


def plan_with(feet: str, name: str = "hybrid-goback") -> Plan:
    """A hand-built plan of a robot with these feet; `mixed`: two fixed wheels in front, point feet behind."""
    robot = find_robot("centauro")
    if feet == "mixed":
        data = robot.model_dump()
        for leg in data["legs"]:
            data["legs"][leg]["foot"] = "fixed" if leg in ("FL", "FR") else "point"
        return motion_plan(find_scenario(name), Robot.model_validate(data))
    return motion_plan(find_scenario(name), robot.with_feet(feet))


def uneven(scenario: Scenario, seed: int = 0) -> ContactSchedule:
    """The scenario's schedule on a mesh of which some intervals, no matter which, are cut in 2 or 3."""
    random, schedule = np.random.default_rng(seed), scenario.schedule
    which = random.choice(schedule.intervals, schedule.intervals // 3, replace=False)
    return schedule.refined(which, random.integers(2, 4, which.size))


@pytest.fixture(scope="module", params=[*FEET_KINDS, "mixed", "uneven"])
def plan(request: pytest.FixtureRequest) -> Plan:
    if request.param == "uneven":
        scenario = find_scenario("hybrid-goback")
        return motion_plan(scenario, schedule=uneven(scenario))
    return plan_with(request.param)


def inside_times(plan: Plan) -> Array:
    """Times well inside the intervals, three in each."""
    inside = np.array([0.15, 0.5, 0.85])
    schedule = plan.schedule
    return np.asarray((schedule.node_times[:-1, None] + np.outer(schedule.lengths, inside)).ravel())


@pytest.mark.parametrize("points", [STATE_POINTS, HEIGHT_POINTS])
@given(seed=st.integers(0, 2**32 - 1))
def test_lagrange_reproduces_polynomials(points: int, seed: int) -> None:
    polynomial = np.polynomial.Polynomial(np.random.default_rng(seed).normal(size=points + 1))
    support, tau = np.concatenate([[0.0], gauss_points(points)]), np.linspace(-0.2, 1.2, 29)
    value, slope = lagrange(support, tau)
    np.testing.assert_allclose(value @ polynomial(support), polynomial(tau), atol=1e-11)
    np.testing.assert_allclose(slope @ polynomial(support), polynomial.deriv()(tau), atol=1e-10)


@pytest.mark.parametrize("points", [STATE_POINTS, HEIGHT_POINTS])
def test_lagrange_is_a_partition_of_one(points: int) -> None:
    support = np.concatenate([[0.0], gauss_points(points)])
    value, slope = lagrange(support, np.linspace(0.0, 1.0, 11))
    np.testing.assert_allclose(value.sum(axis=1), 1.0, atol=1e-13)
    np.testing.assert_allclose(slope.sum(axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose(lagrange(support, support)[0], np.eye(points + 1), atol=1e-14)


@pytest.mark.parametrize("count", [2, 3])
def test_gauss_points_are_roots_of_the_legendre_polynomial(count: int) -> None:
    points = gauss_points(count)
    np.testing.assert_allclose(
        np.polynomial.legendre.Legendre.basis(count)(2.0 * points - 1.0), 0.0, atol=1e-14
    )
    np.testing.assert_allclose(points + points[::-1], 1.0, atol=1e-15)


@pytest.mark.parametrize("seed", range(3))
def test_a_cubic_motion_is_sampled_exactly(seed: int) -> None:
    """States that are cubic (heights: quadratic) in time on the whole horizon come out as they are."""
    plan = motion_plan(find_scenario("wheeled"), schedule=uneven(find_scenario("wheeled"), seed))
    mesh = plan.schedule.mesh
    random = np.random.default_rng(seed)
    cubic = np.polynomial.Polynomial(random.normal(size=4), domain=[0.0, plan.horizon], window=[0.0, 1.0])
    square = np.polynomial.Polynomial(random.normal(size=3), domain=[0.0, plan.horizon], window=[0.0, 1.0])
    states, heights = (
        mesh.times[:-1, None] + np.outer(mesh.lengths, np.concatenate([[0.0], gauss_points(points)]))
        for points in (STATE_POINTS, HEIGHT_POINTS)
    )
    solution = plan.trajectory
    assert isinstance(solution, CollocationTrajectory)
    solution = replace(
        solution,
        base=np.repeat(cubic(states)[..., None], 6, axis=-1),
        base_rate=np.repeat(cubic.deriv()(states)[..., None], 6, axis=-1),
        foot_z=np.repeat(square(heights)[..., None], 4, axis=-1),
    )
    s = replace(plan, trajectory=solution).sample_every(73.0)
    expected = {
        "com_position": cubic(s.time),
        "euler": cubic(s.time),
        "com_velocity": cubic.deriv()(s.time),
        "euler_rate": cubic.deriv()(s.time),
    }
    for name, values in expected.items():
        np.testing.assert_allclose(getattr(s, name), values[:, None] + np.zeros(3), atol=1e-12)
    np.testing.assert_allclose(s.foot_position[..., 2], square(s.time)[:, None] + np.zeros(4), atol=1e-12)
    rate = square.deriv()(s.time)[:, None] + np.zeros(4)
    np.testing.assert_allclose(s.foot_velocity[..., 2], rate, atol=1e-10)


def test_velocities_are_the_derivatives_of_positions(plan: Plan) -> None:
    """As far as cubics on 0.1 s follow the smooth motion of the builder."""
    t = inside_times(plan)
    before, now, after = plan.sample(t - STEP), plan.sample(t), plan.sample(t + STEP)

    def slope(name: str) -> Array:
        return np.asarray((getattr(after, name) - getattr(before, name)) / (2.0 * STEP))

    np.testing.assert_allclose(slope("com_position"), now.com_velocity, atol=2e-3)
    np.testing.assert_allclose(slope("euler"), now.euler_rate, atol=2e-3)
    np.testing.assert_allclose(slope("foot_position"), now.foot_velocity, atol=2e-3)
    np.testing.assert_allclose(slope("foot_position")[..., 2], now.foot_velocity[..., 2], atol=1e-8)
    np.testing.assert_allclose(slope("heading"), now.heading_rate, atol=2e-3)


def test_wheels_do_not_slip_sideways(plan: Plan) -> None:
    """Steerable wheels never, between the collocation points too, fixed ones not in stance; points stand."""
    s = plan.sample_every(333.0)
    vx, vy = s.foot_velocity[..., 0], s.foot_velocity[..., 1]
    lateral = -vx * np.sin(s.heading) + vy * np.cos(s.heading)
    along = vx * np.cos(s.heading) + vy * np.sin(s.heading)
    for leg, data in enumerate(plan.robot.leg_list):
        if data.foot == "point":
            assert not s.foot_velocity[s.contact[:, leg], leg, :2].any()
            for values in (s.heading, s.speed, s.heading_rate):
                assert not values[:, leg].any()
            continue
        where = s.contact[:, leg] if data.foot == "fixed" else slice(None)
        np.testing.assert_allclose(lateral[where, leg], 0.0, atol=1e-14)
        np.testing.assert_allclose(along[:, leg], s.speed[:, leg], atol=1e-14)


@given(
    angle=st.floats(-10.0, 10.0),
    first=st.floats(-2.0, 2.0),
    second=st.floats(-2.0, 2.0),
    kind=st.sampled_from(["steerable", "fixed"]),
)
def test_turning_the_world_turns_the_velocity(angle: float, first: float, second: float, kind: str) -> None:
    robot = find_robot("centauro").with_feet(kind)  # type: ignore[arg-type]
    motion = np.broadcast_to([first, second], (2, 4, 2))
    yaw = np.array([0.3, 0.3 + angle])
    foot = feet_in_world(robot, motion, np.repeat(yaw[:, None], 4, axis=1), yaw, np.zeros(2))
    c, s = np.cos(angle), np.sin(angle)
    np.testing.assert_allclose(foot.velocity_xy[1], foot.velocity_xy[0] @ [[c, s], [-s, c]], atol=1e-12)
    speed = first if kind == "steerable" else np.hypot(first, second)
    np.testing.assert_allclose(np.linalg.norm(foot.velocity_xy, axis=-1), abs(speed), atol=1e-12)


def test_at_a_border_the_inputs_are_those_of_the_later_interval(plan: Plan) -> None:
    at = plan.sample(plan.schedule.node_times)
    later = plan.sample(plan.schedule.mesh.middles)
    np.testing.assert_array_equal(at.contact[:-1], plan.schedule.contact.T)
    np.testing.assert_array_equal(at.force[:-1], later.force)
    np.testing.assert_array_equal(at.contact[-1], later.contact[-1])
    np.testing.assert_array_equal(at.force[-1], later.force[-1])


def test_states_are_continuous_at_the_borders(plan: Plan) -> None:
    borders = plan.schedule.node_times[1:-1]
    before, after = plan.sample(borders - 1e-8), plan.sample(borders)
    np.testing.assert_allclose(before.com_position, after.com_position, atol=1e-4)
    np.testing.assert_allclose(before.foot_position[..., :2], after.foot_position[..., :2], atol=1e-6)


def test_one_time_has_no_first_axis(plan: Plan) -> None:
    one, many = plan.sample(0.7), plan.sample([0.1, 0.7])
    for name, values in vars(one).items():
        np.testing.assert_array_equal(values, getattr(many, name)[1], name)
    assert one.foot_position.shape == (4, 3)
    assert one.contact.dtype == np.bool_


@pytest.mark.parametrize("time", [-0.01, 1e9, np.nan, np.inf, [0.0, -1.0]])
def test_times_outside_the_horizon(plan: Plan, time: float) -> None:
    with pytest.raises(InputError, match=r"^time: .* must lie within the horizon \[0, 16\] s$"):
        plan.sample(time)


def test_times_in_a_table(plan: Plan) -> None:
    with pytest.raises(InputError, match="must be a number or an array of shape"):
        plan.sample(np.zeros((2, 2)))


@pytest.mark.parametrize("rate", [0.0, -1.0, np.nan, np.inf, 1.0 + MAX_SAMPLES])
def test_rates_that_make_no_sense(plan: Plan, rate: float) -> None:
    with pytest.raises(InputError, match=r"^rate: "):
        plan.sample_every(rate)


@given(rate=st.floats(0.01, 2000.0))
def test_a_fixed_rate_has_both_ends(rate: float) -> None:
    plan = GO_AND_BACK
    t = plan.sample_every(rate).time
    assert t[0] == 0.0
    assert t[-1] == plan.horizon
    assert np.all(np.diff(t) > 0.0)
    np.testing.assert_array_equal(t[:-1], np.arange(len(t) - 1) / rate)
    assert np.diff(t)[-1] <= 1.0 / rate + 1e-9


GO_AND_BACK = plan_with("steerable")
