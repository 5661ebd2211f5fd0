"""The paper's transcription: to variables and back, and its order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import spsolve

from rollgait.ocp.problem import Problem
from rollgait.plan.certificate.physics import (
    BodyState,
    Inputs,
    angular_velocity_world,
    derivative,
    rotation_angle,
    rotation_world_base,
)
from rollgait.plan.samples import Samples
from rollgait.plan.trajectory import CollocationTrajectory
from rollgait.transcription.collocation import Collocation, transcribe
from rollgait.transcription.guess import kinematic_guess
from tests.transcription.problems import KINDS, about_the_guess, small_problem

Array = NDArray[np.float64]


@pytest.fixture(scope="module", params=KINDS)
def transcribed(request: pytest.FixtureRequest) -> Collocation:
    return transcribe(small_problem(request.param))


def test_decoding_is_the_inverse_of_encoding(transcribed: Collocation) -> None:
    robot = transcribed.problem.robot
    trajectory = transcribed.decode(about_the_guess(transcribed))
    w = transcribed.encode(lambda times: trajectory.sample(times, robot))
    again = transcribed.decode(w)
    for name, array in trajectory.arrays().items():
        np.testing.assert_allclose(again.arrays()[name], array, atol=1e-9, err_msg=name)


def test_a_motion_keeps_its_values_at_the_collocation_points(transcribed: Collocation) -> None:
    problem, h = transcribed.problem, transcribed.problem.schedule.interval
    guess = kinematic_guess(problem)
    trajectory = transcribed.decode(transcribed.encode(guess))
    points = 0.5 + 0.5 * np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)])
    times = (h * (np.arange(problem.schedule.intervals)[:, None] + points)).ravel()
    planned, wanted = trajectory.sample(times, problem.robot), guess(times)
    np.testing.assert_allclose(planned.com_position, wanted.com_position, atol=1e-12)
    np.testing.assert_allclose(planned.euler_rate, wanted.euler_rate, atol=1e-12)
    np.testing.assert_allclose(planned.foot_position[..., :2], wanted.foot_position[..., :2], atol=1e-12)
    if problem.robot.legs.FL.foot == "steerable":
        np.testing.assert_allclose(planned.heading, wanted.heading, atol=1e-12)
    middles = h * (np.arange(problem.schedule.intervals) + 0.5)
    np.testing.assert_allclose(
        trajectory.sample(middles, problem.robot).force, guess(middles).force, atol=1e-9
    )


# -- order: a body in free tumble under constant inputs, against an integrator --------------------------------------

FORCE = np.array([[20.0, 30.0, 250.0], [-30.0, 10.0, 300.0], [10.0, -20.0, 240.0], [15.0, 5.0, 200.0]])
SPEED = np.array([0.5, -0.4, 0.6, 0.3])
HEADING_RATE = np.array([1.5, -1.0, 0.8, 2.0])
HORIZON = 0.6
"""s; short enough to stay away from a pitch of 90°."""


def simulated(problem: Problem) -> CollocationTrajectory:
    """The motion from x0 under constant inputs: the problem's dynamics rows, solved by Newton's method."""
    transcribed = transcribe(problem)
    nlp = transcribed.nlp
    plain = kinematic_guess(problem)

    def driven(times: Array) -> Samples:
        s, n = plain(times), times.size
        velocity = np.zeros((n, 4, 3))
        return replace(
            s,
            force=np.tile(FORCE, (n, 1, 1)),
            speed=np.tile(SPEED, (n, 1)),
            heading_rate=np.tile(HEADING_RATE, (n, 1)),
            foot_velocity=velocity,
        )

    def other_inputs(times: Array) -> Samples:
        s = driven(times)
        return replace(
            s,
            force=s.force + 1,
            speed=s.speed + 1,
            heading_rate=s.heading_rate + 1,
            foot_velocity=s.foot_velocity + 1,
        )

    w = transcribed.encode(driven)
    state = np.isclose(w, transcribed.encode(other_inputs), rtol=0, atol=0)
    assert state.sum() == nlp.rows, "as many equations as unknowns"
    for _ in range(20):
        g, jacobian = nlp.functions["nlp_jac_g"](w, nlp.parameters)
        step = spsolve(csc_matrix(jacobian.sparse())[:, state], -np.asarray(g).ravel())
        w[state] += step
        if np.abs(step).max() < 1e-11:
            return transcribed.decode(w)
    raise AssertionError("Newton's method did not converge")


def tumbling(intervals: int) -> Problem:
    """No terms, so that the dynamics alone is left; x0 turns about all axes."""
    problem = small_problem(
        gait={"kind": "drive"}, interval=HORIZON / intervals, horizon=HORIZON, profile="paper"
    )
    start = replace(
        problem.start,
        base=problem.start.base + [0.0, 0.0, 0.0, 0.4, -0.1, 0.2],
        base_rate=np.array([0.3, -0.2, 0.1, 1.0, 0.6, -0.8]),
    )
    return replace(problem, terms=(), start=start)


def reference(problem: Problem) -> BodyState:
    """The state at the end, integrated by the certificate's physics."""
    start = problem.start
    begin = BodyState(
        position=start.base[:3],
        velocity=start.base_rate[:3],
        rotation=rotation_world_base(start.base[3:]),
        angular_velocity=angular_velocity_world(start.base[3:], start.base_rate[3:]),
        foot=start.p_foot,
        heading=start.heading,
    )
    inputs = Inputs(FORCE, SPEED, np.zeros(4), np.zeros(4), HEADING_RATE)

    def right_side(t: float, y: Array) -> Array:
        return derivative(problem.robot, BodyState.from_flat(y), inputs).flat()

    solution = solve_ivp(right_side, (0.0, HORIZON), begin.flat(), method="DOP853", rtol=1e-12, atol=1e-13)
    return BodyState.from_flat(solution.y[:, -1])


def test_order_at_the_nodes_is_that_of_three_gauss_points() -> None:
    exact = reference(tumbling(1))
    errors: dict[str, list[float]] = {"position": [], "angle": [], "velocity": [], "foot": [], "rate": []}
    for intervals in (2, 4, 8):
        problem = tumbling(intervals)
        end = simulated(problem).sample(np.array([HORIZON]), problem.robot).at(0)
        errors["position"].append(np.linalg.norm(end.com_position - exact.position))
        errors["velocity"].append(np.linalg.norm(end.com_velocity - exact.velocity))
        errors["angle"].append(float(rotation_angle(rotation_world_base(end.euler), exact.rotation)))
        rate = angular_velocity_world(end.euler, end.euler_rate) - exact.angular_velocity
        errors["rate"].append(np.linalg.norm(rate))
        errors["foot"].append(np.abs(end.foot_position - exact.foot).max())
    # the centre of mass is a parabola: exact
    assert max(errors["position"]) < 1e-10
    assert max(errors["velocity"]) < 1e-10
    for name in ("angle", "rate", "foot"):
        orders = np.log2(np.array(errors[name][:-1]) / errors[name][1:])
        assert orders[-1] > 5.5, f"{name}: errors {errors[name]}"
