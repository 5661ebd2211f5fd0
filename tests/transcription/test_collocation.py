"""The paper's transcription: from motions to variables and back."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from rollgait.plan.trajectory import CollocationTrajectory
from rollgait.transcription.collocation import Collocation, transcribe
from rollgait.transcription.guess import kinematic_guess
from tests.transcription.problems import CASES, about_the_guess, problem_of

Array = NDArray[np.float64]


@pytest.fixture(scope="module", params=CASES)
def transcribed(request: pytest.FixtureRequest) -> Collocation:
    return transcribe(problem_of(request.param))


def test_decoding_is_the_inverse_of_encoding(transcribed: Collocation) -> None:
    robot = transcribed.problem.robot
    trajectory = transcribed.decode(about_the_guess(transcribed))
    w = transcribed.encode(lambda times: trajectory.sample(times, robot))
    again = transcribed.decode(w)
    for name, array in trajectory.arrays().items():
        np.testing.assert_allclose(again.arrays()[name], array, atol=1e-9, err_msg=name)


def test_a_motion_keeps_its_values_at_the_collocation_points(transcribed: Collocation) -> None:
    problem, mesh = transcribed.problem, transcribed.problem.schedule.mesh
    guess = kinematic_guess(problem)
    trajectory = transcribed.decode(transcribed.encode(guess))
    points = 0.5 + 0.5 * np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)])
    times = (mesh.times[:-1, None] + np.outer(mesh.lengths, points)).ravel()
    planned, wanted = trajectory.sample(times, problem.robot), guess(times)
    np.testing.assert_allclose(planned.com_position, wanted.com_position, atol=1e-12)
    np.testing.assert_allclose(planned.euler_rate, wanted.euler_rate, atol=1e-12)
    np.testing.assert_allclose(planned.foot_position[..., :2], wanted.foot_position[..., :2], atol=1e-12)
    if problem.robot.legs.FL.foot == "steerable":
        np.testing.assert_allclose(planned.heading, wanted.heading, atol=1e-12)
    np.testing.assert_allclose(
        trajectory.sample(mesh.middles, problem.robot).force, guess(mesh.middles).force, atol=1e-9
    )


def test_touchdown_speed_is_that_at_the_end_of_the_swing() -> None:
    """Read from the row that bounds it; heights are in disorder, so that no other instant has this speed."""
    transcribed = transcribe(problem_of("uneven"))
    nlp, w = transcribed.nlp, about_the_guess(transcribed)
    g = np.asarray(nlp.functions["nlp_g"](w, nlp.parameters)).ravel()
    ((interval, row),) = [
        (origin.interval, value)
        for origin, value in zip(nlp.origins, g, strict=True)
        if origin.label.term == "touchdown_speed"
    ]
    h = transcribed.problem.schedule.lengths[interval]
    landing = transcribed.decode(w)
    assert isinstance(landing, CollocationTrajectory)
    # the row reads the heights of the interval: the slope at τ = 1 of the parabola through them
    support = np.concatenate([[0.0], 0.5 + 0.5 * np.array([-1.0, 1.0]) / np.sqrt(3.0)])
    parabola = np.polyfit(support, landing.foot_z[interval, :, 2], 2)
    assert row == pytest.approx(np.polyval(np.polyder(parabola), 1.0) / h)
