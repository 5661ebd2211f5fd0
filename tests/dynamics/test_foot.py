"""Laws of the three kinds of foot."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from rollgait.dynamics.foot import planar_motion
from rollgait.plan.trajectory import feet_in_world
from rollgait.robot.library import find_robot
from rollgait.robot.robot import FootKind
from tests.expressions import numbers, value, vectors

Array = NDArray[np.float64]

headings = numbers(10.0)
motions = vectors(2, 2.0)
kinds = st.sampled_from(["steerable", "fixed", "point"])


@given(motions, headings, headings, numbers(2.0), numbers(1.0))
def test_steerable_wheel_rolls_without_slip(
    motion: Array, sigma: float, yaw: float, yaw_rate: float, offset: float
) -> None:
    """ṗx sin σ − ṗy cos σ = 0, whatever the base does."""
    foot = planar_motion("steerable", motion, sigma, yaw, yaw_rate, offset)
    vx, vy = value(foot.velocity)
    assert vx * np.sin(sigma) - vy * np.cos(sigma) == pytest.approx(0.0, abs=1e-12)
    assert vx * np.cos(sigma) + vy * np.sin(sigma) == pytest.approx(motion[0], abs=1e-12)
    assert value(foot.heading) == sigma
    assert value(foot.heading_rate) == motion[1]
    assert value(foot.lateral_speed) == 0.0


@given(motions, headings, headings, numbers(2.0), numbers(1.0))
def test_fixed_wheel_turns_with_the_base(
    motion: Array, sigma: float, yaw: float, yaw_rate: float, offset: float
) -> None:
    foot = planar_motion("fixed", motion, sigma, yaw, yaw_rate, offset)
    along = np.array([np.cos(yaw + offset), np.sin(yaw + offset)])
    left = np.array([-along[1], along[0]])
    np.testing.assert_allclose(value(foot.velocity), motion[0] * along + motion[1] * left, atol=1e-12)
    assert value(foot.heading) == yaw + offset
    assert value(foot.heading_rate) == yaw_rate
    assert (value(foot.speed), value(foot.lateral_speed)) == tuple(motion)


@given(motions, headings, headings)
def test_point_foot_has_no_heading(motion: Array, sigma: float, yaw: float) -> None:
    foot = planar_motion("point", motion, sigma, yaw, 1.0, 0.5)
    np.testing.assert_array_equal(value(foot.velocity), motion)
    assert [value(x) for x in (foot.heading, foot.heading_rate, foot.speed, foot.lateral_speed)] == [0] * 4


@given(kinds, motions, headings, headings, numbers(2.0))
def test_a_plan_means_by_its_inputs_what_the_problem_means(
    kind: FootKind, motion: Array, sigma: float, yaw: float, yaw_rate: float
) -> None:
    robot = find_robot("centauro-2020").with_feet(kind)
    offset = robot.leg_list[0].heading
    expected = planar_motion(kind, motion, sigma, yaw, yaw_rate, offset)
    shown = feet_in_world(
        robot, np.tile(motion, (1, 4, 1)), np.full((1, 4), sigma), np.array([yaw]), np.array([yaw_rate])
    )
    np.testing.assert_allclose(shown.velocity_xy[0, 0], value(expected.velocity), atol=1e-12)
    for name in ("heading", "heading_rate", "speed"):
        assert getattr(shown, name)[0, 0] == pytest.approx(
            float(value(getattr(expected, name))[0]), abs=1e-12
        )
