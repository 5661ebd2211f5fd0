"""Laws of the three kinds of foot."""

import math

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from rollgait.dynamics.foot import planar_inputs, planar_motion
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
    foot = planar_motion(ca, "steerable", motion, sigma, yaw, yaw_rate, offset)
    vx, vy = value(ca.vertcat(*foot.velocity))
    assert vx * np.sin(sigma) - vy * np.cos(sigma) == pytest.approx(0.0, abs=1e-12)
    assert vx * np.cos(sigma) + vy * np.sin(sigma) == pytest.approx(motion[0], abs=1e-12)
    assert value(foot.heading) == sigma
    assert value(foot.heading_rate) == motion[1]
    assert value(foot.lateral_speed) == 0.0


@given(motions, headings, headings, numbers(2.0), numbers(1.0))
def test_fixed_wheel_turns_with_the_base(
    motion: Array, sigma: float, yaw: float, yaw_rate: float, offset: float
) -> None:
    foot = planar_motion(ca, "fixed", motion, sigma, yaw, yaw_rate, offset)
    along = np.array([np.cos(yaw + offset), np.sin(yaw + offset)])
    left = np.array([-along[1], along[0]])
    np.testing.assert_allclose(
        value(ca.vertcat(*foot.velocity)), motion[0] * along + motion[1] * left, atol=1e-12
    )
    assert value(foot.heading) == yaw + offset
    assert value(foot.heading_rate) == yaw_rate
    assert (value(foot.speed), value(foot.lateral_speed)) == tuple(motion)


@given(motions, headings, headings)
def test_point_foot_has_no_heading(motion: Array, sigma: float, yaw: float) -> None:
    foot = planar_motion(ca, "point", motion, sigma, yaw, 1.0, 0.5)
    np.testing.assert_array_equal(value(ca.vertcat(*foot.velocity)), motion)
    assert [value(x) for x in (foot.heading, foot.heading_rate, foot.speed, foot.lateral_speed)] == [0] * 4


@given(kinds, motions, headings, headings, numbers(2.0))
def test_a_plan_means_by_its_inputs_what_the_problem_means(
    kind: FootKind, motion: Array, sigma: float, yaw: float, yaw_rate: float
) -> None:
    robot = find_robot("centauro-2020").with_feet(kind)
    offset = robot.leg_list[0].heading
    expected = planar_motion(ca, kind, motion, sigma, yaw, yaw_rate, offset)
    shown = feet_in_world(
        robot, np.tile(motion, (1, 4, 1)), np.full((1, 4), sigma), np.array([yaw]), np.array([yaw_rate])
    )
    np.testing.assert_allclose(shown.velocity_xy[0, 0], value(ca.vertcat(*expected.velocity)), atol=1e-12)
    for name in ("heading", "heading_rate", "speed"):
        assert getattr(shown, name)[0, 0] == pytest.approx(
            float(value(getattr(expected, name))[0]), abs=1e-12
        )


@given(kinds, motions, headings, headings, numbers(2.0), numbers(1.0))
def test_inputs_are_found_again_from_the_motion(
    kind: FootKind, motion: Array, sigma: float, yaw: float, yaw_rate: float, offset: float
) -> None:
    foot = planar_motion(np, kind, motion, sigma, yaw, yaw_rate, offset)
    again = planar_inputs(np, kind, foot.velocity, foot.heading, foot.heading_rate, foot.speed)
    np.testing.assert_allclose(again, motion, atol=1e-12)


@given(kinds, motions, headings, headings, numbers(2.0), numbers(1.0))
def test_numbers_and_expressions_are_the_same(
    kind: FootKind, motion: Array, sigma: float, yaw: float, yaw_rate: float, offset: float
) -> None:
    arguments = (kind, motion, sigma, yaw, yaw_rate, offset)
    in_numbers, in_python = planar_motion(np, *arguments), planar_motion(math, *arguments)
    expression = planar_motion(ca, *arguments)
    np.testing.assert_allclose(in_numbers.velocity, value(ca.vertcat(*expression.velocity)), atol=1e-12)
    np.testing.assert_allclose(in_python.velocity, in_numbers.velocity, atol=1e-12)
