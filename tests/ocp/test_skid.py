"""Friction of wheels that slip sideways: Coulomb's law where they slide, and nothing where none may."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollgait.errors import InputError
from rollgait.ocp.contact import StanceMotion
from rollgait.ocp.problem import make_problem
from rollgait.ocp.skid import Skid
from rollgait.scenario import Scenario
from tests.expressions import value
from tests.instants import Numbers, as_instant, random_numbers
from tests.skidding import robot, turning

ROBOT = robot()
EPSILON = 0.01
MU = 0.5
WEIGHT = ROBOT.weight


def standing(slip: float, along: float, left: float, normal: float) -> Numbers:
    """A robot whose wheels slip and push so, while it does not turn."""
    n = random_numbers(0, ROBOT)
    c, s = np.cos(n.yaw), np.sin(n.yaw)
    force = np.array([c * along - s * left, s * along + c * left, normal])
    still = np.zeros(3)
    return replace(
        n,
        theta=np.array([n.yaw, 0.0, 0.0]),
        dtheta=still,
        force=np.tile(force, (4, 1)),
        motion=np.tile([0.2, slip], (4, 1)),
    )


def law(n: Numbers) -> np.ndarray:
    """By how much the middle of the band is missed, and the room along the heading, N."""
    x = as_instant(ROBOT, n)
    data = SimpleNamespace(mu=ca.SX(MU), soft=ca.SX(EPSILON), weight=ca.SX(WEIGHT))
    too_far_left, too_far_right, *along = value(Skid().expression(x, x.feet[0], data))
    return np.array([0.5 * (too_far_right - too_far_left), *along])


slips = st.floats(-0.2, 0.2)
shares = st.floats(-0.9, 0.9)


@given(slip=slips, share=shares)
def test_a_mirrored_slip_has_a_mirrored_force(slip: float, share: float) -> None:
    one = law(standing(slip, share * MU * 100.0, 0.0, 100.0))
    other = law(standing(-slip, share * MU * 100.0, 0.0, 100.0))
    np.testing.assert_allclose(one[0], -other[0], atol=1e-9)
    np.testing.assert_allclose(one[1:], other[1:], atol=1e-9)


@given(slip=st.floats(0.15, 1.0), share=shares)
def test_what_slides_has_all_of_its_friction_against_the_slip(slip: float, share: float) -> None:
    along = share * MU * 100.0
    left = -law(standing(slip, along, 0.0, 100.0))[0]  # the force that keeps the law
    assert left < 0.0
    assert np.hypot(along, left) == pytest.approx(MU * 100.0, rel=0.01)


@given(share=st.floats(-1.0, 1.0), slip=slips)
def test_the_force_is_never_outside_the_cone_by_more_than_it_is_rounded(share: float, slip: float) -> None:
    along = share * MU * 100.0
    left = -law(standing(slip, along, 0.0, 100.0))[0]
    assert np.hypot(along, left) <= 1.01 * MU * 100.0


def test_what_does_not_slip_has_no_force_across() -> None:
    assert law(standing(0.0, 10.0, 0.0, 100.0))[0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("normal", [0.0, 100.0])
@pytest.mark.parametrize("slip", [0.0, 0.1])
def test_its_derivative_is_finite(slip: float, normal: float) -> None:
    x = as_instant(ROBOT, standing(slip, 0.0, 0.0, normal))
    foot_slip, force = ca.SX.sym("slip"), ca.SX.sym("force", 3)
    foot = replace(x.feet[0], lateral_speed=foot_slip, force_contact=force)
    data = SimpleNamespace(mu=ca.SX(MU), soft=ca.SX(EPSILON), weight=ca.SX(WEIGHT))
    rows, inputs = Skid().expression(x, foot, data), ca.vertcat(foot_slip, force)
    jacobian = ca.Function("jacobian", [inputs], [ca.jacobian(rows, inputs)])
    assert np.isfinite(np.array(jacobian([slip, 0.0, 0.0, normal]))).all()


STEP = {"parts": [{"kind": "step", "x": 1.0, "height": 0.05}]}
OFF = {
    "no robot that may": turning(30.0, slip_max=None),
    "ground that is not flat": turning(0.0, goal={"x": 0.2}, ground=STEP),
    "locked wheels": turning(0.0, gait={"kind": "walk", "wheels": "locked"}, horizon=10.0),
}


@pytest.mark.parametrize("scenario", OFF.values(), ids=OFF)
def test_where_no_wheel_may_slip_nothing_is_asked(scenario: Scenario) -> None:
    problem = make_problem(scenario)
    assert "skid" not in {term.name for term in problem.terms}
    for leg in range(4):
        assert not np.any(StanceMotion().limits(problem, leg))


def test_wheels_slip_within_their_limit_and_not_at_the_end() -> None:
    lower, upper = StanceMotion().limits(make_problem(turning(30.0)), 0)
    np.testing.assert_array_equal(np.asarray(upper)[0], [0.1] * 29 + [0.0])
    np.testing.assert_array_equal(lower, -np.asarray(upper))


@pytest.mark.parametrize("foot", ["steerable", "point"])
def test_only_fixed_wheels_have_a_limit_of_slip(foot: str) -> None:
    data = ROBOT.model_dump()
    data["legs"]["FL"]["foot"] = foot
    with pytest.raises(InputError, match="slip_max"):
        Scenario.from_dict({"robot": data, "goal": {"x": 0.0}})
