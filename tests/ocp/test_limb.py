"""The closed form of a limb's joints is the inverse of its geometry, built forwards by rotations."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rollgait.ocp.limb import JointSteering, Reach
from rollgait.ocp.problem import Problem, make_problem
from rollgait.plan.certificate.limits import reach
from rollgait.robot.robot import Limb, Robot
from rollgait.scenario.scenario import Scenario
from tests.expressions import numbers, value
from tests.instants import Numbers, as_instant, data_of, random_numbers
from tests.plan.builders import robot as simple_robot

Array = NDArray[np.float64]

ROBOT: Robot = simple_robot(limbs=True)
PROBLEM: Problem = make_problem(
    Scenario(robot=ROBOT, goal={"x": 0.0}, horizon=1.0, bounds={"joint_margin_deg": 5.0})
)
legs = st.integers(0, 3)


def turned(angle: float, vector: Any) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ np.asarray(vector)


def limb_of(leg: int) -> Limb:
    limb = ROBOT.leg_list[leg].limb
    assert limb is not None
    return limb


def posed(leg: int, hip_yaw: float, ankle_yaw: float, forward: float, drop: float, yaw: float) -> Numbers:
    """The robot with one leg in the pose of these joints.

    The leg's plane stands `plane_offset` beside the hip_yaw axis; in it the wheel is `forward` ahead of (or
    behind) the axis, and the ankle pitch axis `drop` below the hip pitch axis. Joints turn downwards.
    """
    limb = limb_of(leg)
    in_plane = np.array([limb.direction * forward, limb.plane_offset, -drop - limb.ankle_height])
    contact = np.asarray(limb.hip) + turned(-hip_yaw, in_plane)
    n = random_numbers(0, ROBOT)
    theta = np.array([yaw, 0.0, 0.0])
    p, sigma = n.p.copy(), n.sigma.copy()
    p[leg] = n.r + turned(yaw, contact)
    sigma[leg] = yaw - hip_yaw - ankle_yaw
    return Numbers(**{**vars(n), "theta": theta, "p": p, "sigma": sigma})


@given(legs, numbers(1.2), numbers(2.0), st.floats(0.1, 0.5), st.floats(0.2, 0.6), numbers(3.0))
def test_joints_are_found_from_the_place_of_the_foot(
    leg: int, hip_yaw: float, ankle_yaw: float, forward: float, drop: float, yaw: float
) -> None:
    x = as_instant(ROBOT, posed(leg, hip_yaw, ankle_yaw, forward, drop, yaw))
    term = JointSteering()
    joints = value(term.expression(x, x.feet[leg], data_of(term, PROBLEM, leg=leg)))
    np.testing.assert_allclose(joints, [hip_yaw, ankle_yaw], atol=1e-5)


@given(legs, numbers(1.2), numbers(2.0), st.floats(0.1, 0.5), st.floats(0.2, 0.6), numbers(3.0))
def test_extension_is_the_distance_of_the_two_pitch_axes(
    leg: int, hip_yaw: float, ankle_yaw: float, forward: float, drop: float, yaw: float
) -> None:
    limb = limb_of(leg)
    x = as_instant(ROBOT, posed(leg, hip_yaw, ankle_yaw, forward, drop, yaw))
    term = Reach()
    extension, radius = value(term.expression(x, x.feet[leg], data_of(term, PROBLEM, leg=leg)))
    assert extension == pytest.approx(forward**2 + drop**2, abs=1e-9)
    assert radius == pytest.approx(forward**2 + limb.plane_offset**2, abs=1e-9)


@given(legs, numbers(1.2), st.floats(0.1, 0.5), st.floats(0.2, 0.6), numbers(0.3), numbers(0.3), numbers(3.0))
def test_on_a_slope_the_ankle_stands_above_the_wheel_in_the_world(
    leg: int, hip_yaw: float, forward: float, drop: float, pitch: float, roll: float, yaw: float
) -> None:
    """The leg reaches to a place in its plane; below it the wheel is as upright as the plane lets it."""
    limb = limb_of(leg)
    R = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    up = turned(hip_yaw, R.inv().apply([0.0, 0.0, 1.0])) * [1.0, 0.0, 1.0]  # in the leg's plane
    ankle = np.array([limb.direction * forward, limb.plane_offset, -drop])
    in_plane = ankle - limb.ankle_height * up
    assume(limb.direction * in_plane[0] > 0.05)
    n = random_numbers(0, ROBOT)
    p = n.p.copy()
    p[leg] = n.r + R.apply(np.asarray(limb.hip) + turned(-hip_yaw, in_plane))
    x = as_instant(ROBOT, replace(n, theta=np.array([yaw, pitch, roll]), p=p))
    up_body, p_body = R.inv().apply([0.0, 0.0, 1.0]), R.inv().apply(p[leg] - n.r)
    foot = replace(x.feet[leg], up_body=ca.SX(up_body), p_body=ca.SX(p_body))
    extension, _ = value(Reach().expression(x, foot, data_of(Reach(), PROBLEM, leg=leg)))
    assert extension == pytest.approx(forward**2 + drop**2, abs=1e-6)
    judged, _ = reach(limb, p_body, up_body)
    assert judged == pytest.approx(np.hypot(forward, drop), abs=1e-9)


@pytest.mark.parametrize("leg", range(4))
def test_limits_are_those_of_the_robot_less_the_margin(leg: int) -> None:
    limb, margin = limb_of(leg), np.radians(5.0)
    low, high = JointSteering().limits(PROBLEM, leg)
    np.testing.assert_allclose(np.ravel(low), [limb.hip_yaw[0] + margin, limb.steering_joint[0] + margin])
    np.testing.assert_allclose(np.ravel(high), [limb.hip_yaw[1] - margin, limb.steering_joint[1] - margin])
    low, high = Reach().limits(PROBLEM, leg)
    np.testing.assert_allclose(np.ravel(low), [limb.extension[0] ** 2, limb.radius_min**2])
    assert np.ravel(high)[0] == pytest.approx(limb.extension[1] ** 2)


def test_joints_stay_finite_where_the_foot_is_below_the_hip() -> None:
    """Such a foot is out of reach, but a solver may try it."""
    n = posed(0, 0.0, 0.0, 0.0, 0.4, 0.3)
    n.p[0, :2] = n.r[:2] + turned(0.3, limb_of(0).hip)[:2]
    x, term = as_instant(ROBOT, n), JointSteering()
    assert np.isfinite(value(term.expression(x, x.feet[0], data_of(term, PROBLEM)))).all()
