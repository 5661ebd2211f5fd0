"""Each equation of the paper, as the planner evaluates it, against plain NumPy written from the paper.

Everything on the right-hand sides here is written without a look at the package: rotations are products of
elementary matrices, ω is found by differentiating R, quadratures are spelled out.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from rollgait.dynamics.rigid_body import momentum_rate, torque_about_com
from rollgait.ocp import boundary, costs, friction, limits
from rollgait.ocp.problem import Problem, make_problem
from rollgait.ocp.term import Cost
from rollgait.plan.samples import Samples
from rollgait.robot.library import find_robot
from rollgait.scenario.mesh import Mesh
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule
from rollgait.transcription.collocation import Collocation, transcribe
from rollgait.transcription.guess import kinematic_guess
from tests.expressions import value
from tests.instants import Numbers, as_instant, data_of, random_numbers

Array = NDArray[np.float64]

ROBOT = find_robot("centauro-2020")
G = 9.81  # m/s²
SEEDS = range(5)
STEP = 1e-5
"""s; of central differences."""


def Rz(a: float) -> Array:
    return np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])


def Ry(a: float) -> Array:
    return np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])


def Rx(a: float) -> Array:
    return np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])


def R(theta: Array) -> Array:
    return np.asarray(Rz(theta[0]) @ Ry(theta[1]) @ Rx(theta[2]))


def omega(theta: Array, dtheta: Array) -> Array:
    """ω from [ω]× = Ṙ Rᵀ."""
    cross = (R(theta + STEP * dtheta) - R(theta - STEP * dtheta)) / (2 * STEP) @ R(theta).T
    return np.array([cross[2, 1], cross[0, 2], cross[1, 0]])


def feet_in_yaw_frame(n: Numbers) -> Array:
    """Rzᵀ (p_i − r), (4, 3)."""
    return np.array([Rz(n.yaw).T @ (p - n.r) for p in n.p])


def scenario(**values: Any) -> Scenario:
    data: dict[str, Any] = {
        "robot": "centauro-2020",
        "profile": "paper",
        "goal": {"x": 0.3, "y": -0.2, "yaw_deg": 30, "then": [{"at": 1.2, "x": 0.1}]},
        "horizon": 2.0,
        "interval": 0.2,
        "gait": {"kind": "schedule", "HL": [[0.6, 1.2]]},
        "ground": {"height": 0.2},
    }
    return Scenario.from_dict(data | values)


PROBLEM = make_problem(scenario())


def cost_value(cost: Cost, n: Numbers, interval: int = 1, problem: Problem = PROBLEM) -> float:
    return float(value(cost.expression(as_instant(ROBOT, n), data_of(cost, problem, interval)))[0])


@pytest.fixture(params=SEEDS)
def n(request: pytest.FixtureRequest) -> Numbers:
    return random_numbers(request.param, ROBOT)


# -- dynamics ------------------------------------------------------------------------------------------------


def test_equation_1_linear_momentum(n: Numbers) -> None:
    """m r̈ = m g + Σ f_i"""
    expected = n.force.sum(axis=0) - [0, 0, ROBOT.mass * G]
    np.testing.assert_allclose(ROBOT.mass * value(as_instant(ROBOT, n).ddr), expected, rtol=1e-12)


def test_equation_2_angular_momentum(n: Numbers) -> None:
    """I_W ω̇ + ω × I_W ω = Σ f_i × (r − p_i), I_W = R I_B Rᵀ"""
    ddtheta = np.array([0.3, -0.7, 1.1])

    def momentum(t: float) -> Array:
        theta = n.theta + t * n.dtheta + 0.5 * t**2 * ddtheta
        I_W = R(theta) @ ROBOT.inertia_matrix @ R(theta).T
        return np.asarray(I_W @ omega(theta, n.dtheta + t * ddtheta))

    # the left-hand side is the derivative of I_W ω
    left = (momentum(1e-3) - momentum(-1e-3)) / 2e-3
    np.testing.assert_allclose(
        value(momentum_rate(ROBOT.inertia_matrix, n.theta, n.dtheta, ddtheta)), left, rtol=1e-4, atol=1e-3
    )
    right = sum(np.cross(f, n.r - p) for f, p in zip(n.force, n.p, strict=True))
    np.testing.assert_allclose(value(torque_about_com(n.r, list(n.p), list(n.force))), right, rtol=1e-10)


def test_equation_3_angular_acceleration(n: Numbers) -> None:
    """ω̇ = E θ̈ + Ė θ̇: with I = 1 the momentum is ω."""
    ddtheta = np.array([0.3, -0.7, 1.1])
    after, before = (
        omega(n.theta + t * n.dtheta + 0.5 * t**2 * ddtheta, n.dtheta + t * ddtheta) for t in (1e-3, -1e-3)
    )
    np.testing.assert_allclose(
        value(momentum_rate(np.eye(3), n.theta, n.dtheta, ddtheta)), (after - before) / 2e-3, atol=1e-4
    )


def test_equation_4_steerable_wheel(n: Numbers) -> None:
    """ṗx = v cos σ, ṗy = v sin σ, ṗz = u2"""
    for i, foot in enumerate(as_instant(ROBOT, n).feet):
        v, sigma_rate = n.motion[i]
        expected = [v * np.cos(n.sigma[i]), v * np.sin(n.sigma[i]), n.p_rate_z[i]]
        np.testing.assert_allclose(value(foot.velocity), expected, atol=1e-12)
        assert value(foot.heading_rate)[0] == sigma_rate


# -- costs ---------------------------------------------------------------------------------------------------


def test_cost_acceleration(n: Numbers) -> None:
    ddr = n.force.sum(axis=0) / ROBOT.mass - [0, 0, G]
    assert cost_value(costs.Acceleration(), n) == pytest.approx(float(ddr @ ddr))


@pytest.mark.parametrize(("interval", "x", "y", "yaw"), [(1, 0.3, -0.2, np.pi / 6), (8, 0.1, 0.0, 0.0)])
def test_cost_goal(n: Numbers, interval: int, x: float, y: float, yaw: float) -> None:
    r_goal, theta_goal = np.array([x, y, 0.2 + 0.685]), np.array([yaw, 0.0, 0.0])
    expected = np.sum((n.r - r_goal) ** 2) + np.sum((n.theta - theta_goal) ** 2)
    assert cost_value(costs.Goal(), n, interval) == pytest.approx(expected)


def test_cost_force_change(n: Numbers) -> None:
    """h_ref² Σ‖(f_k − f_{k−1}) / h‖², none at k = 0, on equal intervals of 0.2 s"""
    expected = 0.1**2 * np.sum((n.force - n.previous_force) ** 2) / 0.2**2
    assert cost_value(costs.ForceChange(), n) == pytest.approx(expected)
    assert cost_value(costs.ForceChange(), n, interval=0) == 0.0


def test_cost_feet(n: Numbers) -> None:
    expected = np.sum((feet_in_yaw_frame(n) - ROBOT.stance) ** 2)
    assert cost_value(costs.Feet(), n) == pytest.approx(expected)


def test_cost_speed(n: Numbers) -> None:
    assert cost_value(costs.Speed(), n, interval=4) == pytest.approx(np.sum(n.motion[:, 0] ** 2))
    in_contact = make_problem(scenario(weights={"speed_in_contact_only": True}))
    expected = np.sum(np.delete(n.motion[:, 0], 2) ** 2)
    assert cost_value(costs.Speed(), n, 4, in_contact) == pytest.approx(expected)


def test_cost_heading_rate(n: Numbers) -> None:
    assert cost_value(costs.HeadingRate(), n) == pytest.approx(np.sum(n.motion[:, 1] ** 2))


# -- constraints ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("inscribed", [False, True])
def test_friction(n: Numbers, inscribed: bool) -> None:
    """|f^x|, |f^y| ≤ μ f^z in the contact frame, less what a wheel may turn in 0.2 s"""
    problem = make_problem(scenario(bounds={"inscribed": inscribed}, ground={"friction": 0.6}))
    mu = (0.6 / np.sqrt(2) if inscribed else 0.6) * np.cos(2.0 * 0.2 / 2)
    for i, foot in enumerate(as_instant(ROBOT, n).feet):
        fx, fy, fz = Rz(n.sigma[i]).T @ n.force[i]
        term = friction.Friction()
        rows = value(term.expression(as_instant(ROBOT, n), foot, data_of(term, problem, leg=i)))
        assert rows.min() == pytest.approx(mu * fz - max(abs(fx), abs(fy)))
        assert term.lower == 0.0


def test_normal_force(n: Numbers) -> None:
    """0 ≤ f^z ≤ f_max"""
    term = friction.ForceLimits()
    x = as_instant(ROBOT, n)
    for i, foot in enumerate(x.feet):
        assert value(term.expression(x, foot, data_of(term, PROBLEM)))[0] == n.force[i, 2]
        assert term.limits(PROBLEM, i) == (0.0, 1500.0)


def test_box(n: Numbers) -> None:
    """|Rzᵀ (p_i − r) − p̄_i| ≤ b"""
    x, term = as_instant(ROBOT, n), limits.Box()
    for i, foot in enumerate(x.feet):
        rows = value(term.expression(x, foot, data_of(term, PROBLEM)))
        np.testing.assert_allclose(rows, feet_in_yaw_frame(n)[i] - ROBOT.stance[i], atol=1e-12)
    low, high = term.limits(PROBLEM, 0)
    np.testing.assert_array_equal(np.ravel(high), [0.20, 0.18, 0.15])
    np.testing.assert_array_equal(low, -np.asarray(high))


def test_box_in_the_base_frame(n: Numbers) -> None:
    x, term = as_instant(ROBOT, n), limits.Box(full_rotation=True)
    for i, foot in enumerate(x.feet):
        rows = value(term.expression(x, foot, data_of(term, PROBLEM)))
        np.testing.assert_allclose(rows, R(n.theta).T @ (n.p[i] - n.r) - ROBOT.stance[i], atol=1e-12)


def test_steering(n: Numbers) -> None:
    """σ_min ≤ σ_i − θz ≤ σ_max, never reduced mod 2π"""
    x, term = as_instant(ROBOT, n), limits.Steering()
    for i, foot in enumerate(x.feet):
        rows = value(term.expression(x, foot, data_of(term, PROBLEM)))
        assert rows[0] == pytest.approx(n.sigma[i] - n.theta[0])
        assert term.limits(PROBLEM, i) == ((-1.79, 1.81) if i in (0, 2) else (-1.81, 1.79))


def test_end(n: Numbers) -> None:
    """ṙ(T) = 0, v_i(T) = 0, Rzᵀ (p_i − r)(T) = p̄_i, the height once"""
    x = as_instant(ROBOT, n)
    none = data_of(boundary.RestAtEnd(), PROBLEM)
    np.testing.assert_array_equal(value(boundary.RestAtEnd().expression(x, none)), n.dr)
    apart = feet_in_yaw_frame(n) - ROBOT.stance
    assert value(boundary.HeightAtEnd().expression(x, none))[0] == pytest.approx(apart[0, 2])
    for i, foot in enumerate(x.feet):
        assert value(boundary.WheelsRestAtEnd().expression(x, foot, none))[0] == n.motion[i, 0]
        rows = value(boundary.StanceAtEnd().expression(x, foot, none))
        np.testing.assert_allclose(rows, apart[i, :2], atol=1e-12)


# -- the whole problem on its mesh ---------------------------------------------------------------------------

GAUSS_3 = 0.5 * (leggauss(3)[0] + 1.0)
WEIGHTS_3 = np.array([5.0, 8.0, 5.0]) / 18.0
GAUSS_2 = 0.5 * (leggauss(2)[0] + 1.0)


UNEVEN = Mesh(0.2 * np.array([0.5, 1.3, 1.2, 1.6, 0.4, 1.0, 0.7, 1.8, 0.9, 0.6]))
"""With nodes where the foot lifts off and touches down."""


@pytest.fixture(scope="module", params=["even", "uneven"])
def disorder(request: pytest.FixtureRequest) -> tuple[Collocation, Array]:
    """The problem on its mesh, and variables that obey nothing."""
    mesh = UNEVEN if request.param == "uneven" else PROBLEM.schedule.mesh
    transcribed = transcribe(replace(PROBLEM, schedule=ContactSchedule(PROBLEM.schedule.contact, mesh)))
    guess = transcribed.encode(kinematic_guess(transcribed.problem))
    return transcribed, guess + np.random.default_rng(0).uniform(-0.3, 0.3, guess.shape)


def slopes(support: Array, values: Array, at: Array) -> Array:
    """Derivatives at `at` of the polynomials through `values` (n, …) at `support` (n,)."""
    flat = values.reshape(len(support), -1)
    derived = [np.polyder(np.polyfit(support, column, len(support) - 1)) for column in flat.T]
    return np.stack([np.polyval(p, at) for p in derived], axis=-1).reshape(len(at), *values.shape[1:])


def test_rows_are_the_equations_at_the_collocation_points(disorder: tuple[Collocation, Array]) -> None:
    transcribed, w = disorder
    nlp, mesh = transcribed.nlp, transcribed.problem.schedule.mesh
    g = np.asarray(nlp.functions["nlp_g"](w, nlp.parameters)).ravel()
    trajectory = transcribed.decode(w)
    support = np.concatenate([[0.0], GAUSS_3])
    I_B = ROBOT.inertia_matrix
    for k, h in enumerate(mesh.lengths):
        found: dict[str, list[float]] = {"dynamics": [], "rolling": [], "continuity": []}
        for origin, row in zip(nlp.origins, g, strict=True):
            if origin.interval == k and origin.label.term in found:
                found[origin.label.term].append(row)
        at = trajectory.sample(mesh.times[k] + h * GAUSS_3, ROBOT)
        base_slope = slopes(support, trajectory.base[k], GAUSS_3) / h
        rate_slope = slopes(support, trajectory.base_rate[k], GAUSS_3) / h
        xy_slope = slopes(support, trajectory.foot_xy[k], GAUSS_3) / h
        heading_slope = slopes(support, trajectory.heading[k], GAUSS_3) / h
        dynamics, rolling = [], []
        for j in range(3):
            theta, dtheta = at.euler[j], at.euler_rate[j]
            dynamics += [*(h * (base_slope[j] - np.concatenate([at.com_velocity[j], dtheta])))]
            dynamics += [*(h * (rate_slope[j, :3] - at.force[j].sum(axis=0) / ROBOT.mass + [0, 0, G]))]
            momentum = [
                R(a) @ I_B @ R(a).T @ omega(a, dtheta + t * rate_slope[j, 3:])
                for t in (2e-4, -2e-4)
                for a in [theta + t * dtheta + 0.5 * t**2 * rate_slope[j, 3:]]
            ]
            torque = np.cross(at.force[j], at.com_position[j] - at.foot_position[j]).sum(axis=0)
            rate = (momentum[0] - momentum[1]) / 4e-4
            dynamics += [*(h * (rate - torque) / (np.trace(I_B) / 3))]
            for i in range(4):
                rolls = at.speed[j, i] * np.array([np.cos(at.heading[j, i]), np.sin(at.heading[j, i])])
                rolling += [
                    *(h * (xy_slope[j, i] - rolls)),
                    h * (heading_slope[j, i] - at.heading_rate[j, i]),
                ]
        np.testing.assert_allclose(found["dynamics"], dynamics, atol=1e-4)
        np.testing.assert_allclose(found["rolling"], rolling, atol=1e-9)


def test_costs_are_integrals_by_the_weights_of_the_points(disorder: tuple[Collocation, Array]) -> None:
    transcribed, w = disorder
    trajectory, mesh = transcribed.decode(w), transcribed.problem.schedule.mesh
    expected = dict.fromkeys(("acc", "goal", "force", "feet", "speed", "yaw"), 0.0)
    for k, h in enumerate(mesh.lengths):
        at = trajectory.sample(mesh.times[k] + h * GAUSS_3, ROBOT)
        for j, b in enumerate(WEIGHTS_3 * h):
            for name, cost in running_costs(at.at(j), mesh.times[k] + 0.5 * h).items():
                expected[name] += b * cost
        if k > 0:  # a force is its value at the middle, and changes from one middle to the next
            change = trajectory.force[k] - trajectory.force[k - 1]
            expected["force"] += 5e-4 * 0.1**2 * np.sum(change**2) / (0.5 * (mesh.lengths[k - 1] + h))
    assert transcribed.nlp.costs(w) == pytest.approx(expected)


def running_costs(s: Samples, middle: float) -> dict[str, float]:
    goal = [0.3, -0.2, 0.885, np.pi / 6, 0, 0] if middle < 1.2 else [0.1, 0, 0.885, 0, 0, 0]
    ddr = s.force.sum(axis=0) / ROBOT.mass - [0, 0, G]
    feet = (s.foot_position - s.com_position) @ Rz(s.euler[0]) - ROBOT.stance
    return {
        "acc": float(ddr @ ddr),
        "goal": 10 * float(np.sum((np.concatenate([s.com_position, s.euler]) - goal) ** 2)),
        "feet": 20 * float(np.sum(feet**2)),
        "speed": float(np.sum(s.speed**2)),
        "yaw": 1.5 * float(np.sum(s.heading_rate**2)),
    }
