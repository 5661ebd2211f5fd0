"""Laws of the kinematic guess."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from rollgait.ocp.lift import lift
from rollgait.ocp.problem import Problem, make_problem
from rollgait.scenario.library import find_scenario
from rollgait.scenario.scenario import Scenario
from rollgait.transcription.guess import kinematic_guess, motion_inputs
from tests.library import FLAT

Array = NDArray[np.float64]


def problem(name: str, **values: Any) -> Problem:
    return make_problem(find_scenario(name).with_values({"robot": "centauro-2020", **values}))


@pytest.fixture(params=FLAT)
def library(request: pytest.FixtureRequest) -> Problem:
    return problem(request.param)


def times(of: Problem, rate: float = 200.0) -> Array:
    return np.linspace(0.0, of.schedule.horizon, round(of.schedule.horizon * rate) + 1)


def turned(a: float, xy: Array) -> Array:
    return xy @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])


def test_base_goes_from_start_to_goal_at_rest(library: Problem) -> None:
    ends = np.array([0.0, library.schedule.horizon])
    s = kinematic_guess(library)(ends)
    poses = np.hstack([s.com_position, s.euler])
    np.testing.assert_allclose(poses[0], library.start.base, atol=1e-12)
    np.testing.assert_allclose(poses[1], library.scenario.goal_at(ends[1:])[0], atol=1e-12)
    np.testing.assert_allclose(s.com_velocity, 0.0, atol=1e-12)
    np.testing.assert_allclose(s.euler_rate, 0.0, atol=1e-12)


def test_velocities_are_derivatives(library: Problem) -> None:
    t = times(library)
    s = kinematic_guess(library)(t)
    for path, rate, accuracy in (
        (s.com_position, s.com_velocity, 6e-3),  # of steps: cubics, whose acceleration jumps
        (s.euler, s.euler_rate, 1e-3),
        (s.foot_position[..., 2], s.foot_velocity[..., 2], 5e-3),
    ):
        np.testing.assert_allclose(np.gradient(path, t, axis=0)[1:-1], rate[1:-1], atol=accuracy)


def test_forces_carry_the_weight_and_feet_in_the_air_nothing(library: Problem) -> None:
    s = kinematic_guess(library)(times(library, 20.0))
    np.testing.assert_allclose(s.force[..., 2].sum(axis=-1), library.robot.weight)
    assert s.force[..., 2].min() >= 0.0
    np.testing.assert_array_equal(s.force[~s.contact], 0.0)
    np.testing.assert_array_equal(s.force[..., :2], 0.0)


def test_standing_forces_balance_about_the_centre_of_mass() -> None:
    s = kinematic_guess(problem("wheeled"))(np.linspace(0.0, 15.0, 50))
    torque = np.cross(s.foot_position - s.com_position[:, None], s.force).sum(axis=1)
    np.testing.assert_allclose(torque, 0.0, atol=1e-8)


def test_feet_follow_the_smooth_lift_and_the_contacts_the_schedule(library: Problem) -> None:
    t = times(library)
    s = kinematic_guess(library)(t)
    np.testing.assert_allclose(
        s.foot_position[..., 2], lift(library.schedule, library.scenario.clearance, t)[0], atol=1e-12
    )
    middles = library.schedule.mesh.middles
    np.testing.assert_array_equal(kinematic_guess(library)(middles).contact, library.schedule.contact.T)


def test_wheels_keep_their_nominal_places_below_the_base() -> None:
    of = problem("hybrid-goback")
    s = kinematic_guess(of)(of.schedule.node_times)
    for k in range(len(s.time)):
        below = turned(-s.euler[k, 0], s.foot_position[k, :, :2] - s.com_position[k, :2])
        np.testing.assert_allclose(below, of.robot.stance[:, :2], atol=1e-9)


def test_wheels_point_along_their_paths_once_they_are_steered() -> None:
    """No lateral slip, apart from where steering takes its time: at the beginning."""
    of = problem("wheeled")
    s = kinematic_guess(of)(times(of))
    c, sn = np.cos(s.heading), np.sin(s.heading)
    lateral = c * s.foot_velocity[..., 1] - sn * s.foot_velocity[..., 0]
    along = c * s.foot_velocity[..., 0] + sn * s.foot_velocity[..., 1]
    np.testing.assert_allclose(s.speed, along, atol=1e-12)
    middle = (s.time > 2.0) & (s.time < 13.0)
    assert np.abs(lateral[middle]).max() < 0.01 * np.abs(along[middle]).max()


def test_straight_ahead_nothing_is_steered() -> None:
    of = problem("hybrid-forward")
    s = kinematic_guess(of)(times(of))
    np.testing.assert_allclose(s.heading, 0.0, atol=1e-9)
    assert s.speed.min() >= -1e-12


def test_headings_keep_their_range_and_rate(library: Problem) -> None:
    if library.robot.legs.FL.foot == "point":
        return
    s = kinematic_guess(library)(times(library))
    relative = s.heading - s.euler[:, :1]
    for leg in range(4):
        low, high = library.scenario.steering_range(leg)
        # σ and θz are interpolated apart
        assert low - 1e-4 <= relative[:, leg].min() <= relative[:, leg].max() <= high + 1e-4
    limit = library.scenario.value_of("bounds", "steering_rate_max")
    steering_rate = np.gradient(relative, s.time, axis=0)
    assert np.abs(steering_rate).max() <= limit + 0.01  # rad/s; the same


def test_point_feet_stand_in_stance_and_step_towards_the_goal() -> None:
    of = problem("legged-forward")
    guess, nodes = kinematic_guess(of), of.schedule.node_times
    for leg in range(4):
        for k in np.flatnonzero(of.schedule.contact[leg]):
            begin, end = guess(np.array([nodes[k] + 1e-9, nodes[k + 1]])).foot_position[:, leg, :2]
            np.testing.assert_allclose(begin, end, atol=1e-6)
    last = guess(np.array([of.schedule.horizon])).foot_position[0]
    np.testing.assert_allclose(last[:, :2], of.robot.stance[:, :2] + [0.7, 0.0], atol=1e-9)


@settings(max_examples=20)
@given(st.floats(-1.0, 1.0), st.floats(-0.5, 0.5), st.integers(-60, 60), st.integers(-170, 170))
def test_a_turned_and_moved_scenario_turns_and_moves_the_guess(
    x: float, y: float, yaw: int, turn: int
) -> None:
    gait = {"kind": "crawl", "steps": 4}
    here = Scenario(robot="centauro-2020", goal={"x": x, "y": y, "yaw_deg": yaw}, gait=gait)
    a, shift = np.radians(turn), np.array([3.0, -2.0])
    goal = turned(a, np.array([x, y])) + shift
    there = Scenario(
        robot="centauro-2020",
        start={"x": shift[0], "y": shift[1], "yaw_deg": turn},
        goal={"x": goal[0], "y": goal[1], "yaw_deg": yaw + turn},
        gait=gait,
    )
    t = np.linspace(0.0, 10.0, 41)
    first, second = (kinematic_guess(make_problem(of))(t) for of in (here, there))
    np.testing.assert_allclose(
        second.com_position[:, :2], turned(a, first.com_position[:, :2]) + shift, atol=1e-9
    )
    np.testing.assert_allclose(
        second.foot_position[..., :2], turned(a, first.foot_position[..., :2]) + shift, atol=1e-9
    )
    np.testing.assert_allclose(second.force, first.force, atol=1e-6)


def test_planar_inputs_are_the_inverse_of_what_they_mean() -> None:
    """Of a fixed wheel: the velocity along and across its heading."""
    of = make_problem(
        Scenario(
            robot=problem("wheeled").robot.with_feet("fixed"),
            goal={"x": 0.3, "y": 0.2, "yaw_deg": 20},
            horizon=3.0,
        )
    )
    s = kinematic_guess(of)(np.linspace(0.0, 3.0, 31))
    inputs = motion_inputs(of.robot, s)
    for k in range(31):
        for leg in range(4):
            back = turned(s.heading[k, leg], inputs[k, leg])
            np.testing.assert_allclose(back, s.foot_velocity[k, leg, :2], atol=1e-12)
