"""Body and legs stay off the ground: laws of the row, and what the certificate says of the same motion."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import rollgait as rg
from rollgait.footing.beneath import BodyPath, Underside
from rollgait.ocp.body import BodyClearance
from rollgait.ocp.problem import Problem, make_problem
from rollgait.plan.plan import Plan
from rollgait.robot.robot import Shapes
from rollgait.transcription.condensed import transcribe
from tests.expressions import value
from tests.instants import Numbers, as_instant, data_of, random_numbers

Array = NDArray[np.float64]

ROBOT = rg.find_scenario("kerb").body
UNDERSIDE = Underside.of(ROBOT)
CLEARANCE = 0.03
DRIVE: dict[str, Any] = {
    "robot": "centauro",
    "goal": {"x": 2.0},
    "horizon": 8.0,
    "gait": {"kind": "drive"},
}
"""A drive over what stands between the wheels."""
HEIGHT = 0.65
"""Of a narrow block that hips pass only if the base rises, m."""
RIGID = 0.9
"""The certificate judges what goes with the base by at least this share."""


def over(width: float, height: float, **values: Any) -> rg.Scenario:
    block = {"kind": "block", "x": 0.9, "length": 0.3, "width": width, "height": height}
    return rg.Scenario.from_dict(DRIVE | {"ground": {"parts": [block]}} | values)


seeds = st.integers(0, 1000)
some = settings(max_examples=20)


@pytest.fixture(scope="module")
def problem() -> Problem:
    return make_problem(over(0.16, HEIGHT))


@pytest.fixture(scope="module")
def plan() -> Plan:
    return rg.plan(over(0.16, HEIGHT), diagnose=False)


def some_row(problem: Problem, leg: int) -> int:
    """An interval in which a leg has a row."""
    return int(np.flatnonzero(problem.beneath.near[leg])[0])


def rows(problem: Problem, n: Numbers, leg: int, interval: int) -> Array:
    x = as_instant(ROBOT, n)
    return value(BodyClearance().expression(x, x.feet[leg], data_of(BodyClearance(), problem, interval, leg)))


def path_of(*poses: Numbers) -> BodyPath:
    return BodyPath(*(np.stack([getattr(n, name) for n in poses]) for name in ("r", "theta", "p")))


def standing(**values: Any) -> Numbers:
    """The nominal stance, the CoM at the origin."""
    n = random_numbers(0, ROBOT)
    return replace(n, r=np.zeros(3), theta=np.zeros(3), p=ROBOT.stance, **values)


def test_points_lie_on_the_lower_half_of_their_spheres() -> None:
    for sphere in ROBOT.underside.limbs:
        own = UNDERSIDE.place - np.array(sphere.centre)
        on = own[np.isclose(np.linalg.norm(own, axis=1), sphere.radius, atol=1e-9)]
        assert len(on) >= 7
        assert on[:, 2].min() == pytest.approx(-sphere.radius)


def test_in_the_nominal_stance_points_are_where_they_are_drawn() -> None:
    assert np.allclose(UNDERSIDE.at(path_of(standing()))[0], UNDERSIDE.place, atol=1e-12)


@some
@given(seed=seeds)
def test_points_move_with_a_robot_that_is_turned_and_displaced(seed: int) -> None:
    n, rng = random_numbers(seed, ROBOT), np.random.default_rng(seed)
    shift, yaw = rng.uniform(-1.0, 1.0, 3), rng.uniform(-3.0, 3.0)
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    moved = replace(n, r=R @ n.r + shift, p=n.p @ R.T + shift, theta=n.theta + np.array([yaw, 0.0, 0.0]))
    before, after = UNDERSIDE.at(path_of(n, moved))
    assert np.allclose(after, before @ R.T + shift, atol=1e-9)


@some
@given(seed=seeds, leg=st.integers(0, 3))
def test_the_row_is_the_place_of_a_point_along_its_normal(problem: Problem, seed: int, leg: int) -> None:
    k = some_row(problem, leg)
    n = random_numbers(seed, ROBOT)
    q = UNDERSIDE.at(path_of(n))[0]
    for number, found in zip(problem.beneath.numbers[leg, k], rows(problem, n, leg, k), strict=True):
        if not number.any():
            assert found == 0.0
            continue
        along = q @ number[7:]
        assert np.abs(along - found).min() < 1e-9


@some
@given(seed=seeds, leg=st.integers(0, 3))
def test_its_derivatives_are_finite_differences(problem: Problem, seed: int, leg: int) -> None:
    k, n, step = some_row(problem, leg), random_numbers(seed, ROBOT), 1e-6
    direction = np.random.default_rng(seed).uniform(-1.0, 1.0, 9)

    def at(t: Any) -> Any:
        x = as_instant(ROBOT, n)
        x = replace(x, r=x.r + t * direction[:3], theta=x.theta + t * direction[3:6])
        foot = replace(x.feet[leg], p=x.feet[leg].p + t * direction[6:])
        return BodyClearance().expression(x, foot, data_of(BodyClearance(), problem, k, leg))

    t = ca.SX.sym("t")
    slope = value(ca.substitute(ca.jacobian(at(t), t), t, 0.0))
    assert np.allclose(slope, (value(at(step)) - value(at(-step))) / (2.0 * step), atol=1e-6)


@pytest.mark.parametrize("name", ["kerb", "stairs", "gap", "one-sided"])
def test_where_nothing_comes_near_the_code_is_that_without_the_row(name: str) -> None:
    near = make_problem(rg.find_scenario(name))
    assert not near.beneath.near.any()
    without = make_problem(rg.find_scenario(name).with_values({"bounds.without": ["body_clearance"]}))
    codes = [{id(block.stage.code) for block in transcribe(p).nlp.blocks} for p in (near, without)]
    assert codes[0] == codes[1]


def test_flat_ground_and_robots_without_shapes_have_no_such_term() -> None:
    flat = make_problem(rg.find_scenario("wheeled"))
    bare = over(0.16, HEIGHT, robot=ROBOT.model_copy(update={"underside": Shapes()}))
    for other in (flat, make_problem(bare)):
        assert "body_clearance" not in {term.name for term in other.terms}


@pytest.mark.parametrize(("width", "height"), [(0.16, 0.65), (0.34, 0.56), (0.34, 0.60)])
def test_over_a_block_the_certificate_agrees_with_the_points(width: float, height: float, plan: Plan) -> None:
    found = plan if height == HEIGHT else rg.plan(over(width, height), diagnose=False)
    certificate = found.certificate()
    row = certificate.row("body_clearance")
    assert certificate.passed, "\n".join(map(str, certificate.failures))
    assert row.worst < 0.1  # something is near
    at = found.sample(found.schedule.node_times)
    q = UNDERSIDE.at(BodyPath(at.com_position, at.euler, at.foot_position))
    asked = CLEARANCE * UNDERSIDE.is_trunk
    above = q[..., 2] - found.scenario.terrain.height(q[..., 0], q[..., 1]) - asked
    assert above[:, UNDERSIDE.with_base >= RIGID].min() == pytest.approx(row.worst, abs=0.01)


def test_the_base_rises_over_a_block(plan: Plan) -> None:
    z = plan.sample(plan.schedule.node_times).com_position[:, 2]
    assert z.max() > ROBOT.height + 0.03
    assert z[-1] == pytest.approx(ROBOT.height, abs=1e-3)


def test_without_the_row_the_motion_is_what_the_certificate_would_not_pass(plan: Plan) -> None:
    scenario = plan.scenario.with_values({"bounds.without": ["body_clearance"]})
    low = rg.plan(scenario, diagnose=False).certificate().row("body_clearance")
    assert low.verdict == "not promised"
    assert low.limit is not None
    assert low.worst < low.limit


def test_the_whole_body_is_as_far_off_the_ground_as_the_spheres_say() -> None:
    found = rg.plan(over(0.34, 0.60), diagnose=False)
    row = rg.track(found, rate=100.0).report.row("ground clearance")
    assert row.passed
    assert row.worst == pytest.approx(found.certificate().row("body_clearance").worst, abs=0.01)


def test_a_shank_that_stays_off_an_edge_is_not_forbidden_to() -> None:
    # of point feet that step down the shank leans back towards the edge; what tracking passes is planned
    found = rg.plan(
        rg.Scenario.from_dict(
            {
                "robot": "strider",
                "goal": {"x": 0.35},
                "horizon": 11.0,
                "interval": 0.08,
                "gait": {"kind": "crawl", "steps": 12, "clearance": 0.04},
                "ground": {"friction": 0.6, "parts": [{"kind": "step", "x": 0.36, "height": -0.1}]},
            }
        ),
        diagnose=False,
    )
    assert found.certificate().passed
    assert rg.track(found, rate=100.0).report.row("ground clearance").passed
