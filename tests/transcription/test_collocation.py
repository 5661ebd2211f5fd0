"""The paper's transcription: from motions to variables and back."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

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
