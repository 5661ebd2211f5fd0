"""Plans under loads: momentum balances, the certificate notices what is taken away, files keep it all."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import rollgait as rg
from rollgait.robot.robot import GRAVITY

Array = NDArray[np.float64]

SHORT = {"robot": "centauro", "goal": {"x": 0.15, "yaw_deg": 8.0}, "horizon": 2.0}
PAYLOAD = {"mass": 20.0, "at": [0.1, 0.15, 0.3]}
PULL = {"force": [-100.0, 20.0, 0.0], "torque": [0.0, 0.0, 5.0], "at": [-0.3, 0.1, 0.05]}
TIMED = PULL | {"start": 0.5, "end": 1.2, "frame": "base"}
CASES: dict[str, dict[str, Any]] = {
    "payload": {"payload": PAYLOAD},
    "pull": {"wrench": PULL},
    "both": {"payload": PAYLOAD, "wrench": [PULL, TIMED]},
}


def asked(loads: dict[str, Any], **values: Any) -> rg.Scenario:
    return rg.Scenario.from_dict(SHORT | {"loads": loads} | values)


@pytest.fixture(scope="module")
def plans() -> dict[str, rg.Plan]:
    planner = rg.Planner(kernels=False)
    return {name: planner.plan(asked(loads)) for name, loads in CASES.items()}


def pulled(plan: rg.Plan, at: rg.Samples) -> tuple[Array, Array]:
    """Force and torque about the CoM of all wrenches, (n, 3) each, written from their definition."""
    turn = Rotation.from_euler("ZYX", at.euler)
    force, torque = np.zeros((2, len(at.time), 3))
    for wrench in plan.scenario.wrenches:
        acts = ((at.time > wrench.start) & (at.time < (wrench.end or np.inf)))[:, None]
        f, t = np.array(wrench.force), np.array(wrench.torque)
        own, twist = (turn.apply(f), turn.apply(t)) if wrench.frame == "base" else (f, t)
        lever = turn.apply(np.array(wrench.at) - plan.robot.com_offset)
        force, torque = force + acts * own, torque + acts * (twist + np.cross(lever, own))
    return force, torque


@pytest.mark.parametrize("name", CASES)
def test_a_plan_under_loads_is_certified(plans: dict[str, rg.Plan], name: str) -> None:
    assert plans[name].certificate().passed, "\n".join(map(str, plans[name].certificate().failures))


@pytest.mark.parametrize("name", CASES)
def test_momentum_changes_by_all_forces_and_torques(plans: dict[str, rg.Plan], name: str) -> None:
    """Between two times in an interval: m Δṙ and ΔL are the integrals of what acts, by Gauss's rule."""
    plan = plans[name]
    robot, nodes = plan.robot, plan.schedule.node_times
    points, weights = np.polynomial.legendre.leggauss(4)
    times = nodes[:-1, None] + 0.5 * (points + 1.0) * np.diff(nodes)[:, None]
    at = plan.sample(times.ravel())
    force, torque = pulled(plan, at)
    force = force + at.force.sum(axis=1) - [0.0, 0.0, robot.weight]
    lever = at.contact_position - at.com_position[:, None]
    torque = torque + np.cross(lever, at.force).sum(axis=1)
    shape, half = (*times.shape, 3), 0.5 * weights[None, :, None] * np.diff(nodes)[:, None, None]
    impulse, twist = ((half * v.reshape(shape)).sum(axis=1) for v in (force, torque))
    ends = plan.sample(nodes)
    np.testing.assert_allclose(robot.mass * np.diff(ends.com_velocity, axis=0), impulse, atol=1e-2)
    np.testing.assert_allclose(np.diff(momentum(plan, ends), axis=0), twist, atol=2e-2)


def momentum(plan: rg.Plan, at: rg.Samples) -> Array:
    """L about the CoM, (n, 3), N m s, from rotation matrices and Euler rates."""
    from rollgait.plan.certificate.physics import angular_velocity_world

    turn = Rotation.from_euler("ZYX", at.euler)
    omega = turn.inv().apply(angular_velocity_world(at.euler, at.euler_rate))
    return turn.apply(omega @ plan.robot.inertia_matrix)


def test_half_the_weight_upward_halves_what_feet_carry() -> None:
    weight = rg.find_robot("centauro").weight
    planner = rg.Planner(kernels=False)
    still = {"goal": {"x": 0.0}, "horizon": 1.0}
    plain = planner.plan(asked({"wrench": {"force": [0.0, 0.0, 1e-9]}}, **still)).sample(0.5)
    hung = planner.plan(asked({"wrench": {"force": [0.0, 0.0, 0.5 * weight]}}, **still)).sample(0.5)
    assert plain.force[:, 2].sum() == pytest.approx(weight, rel=1e-5)
    assert hung.force[:, 2].sum() == pytest.approx(0.5 * weight, rel=1e-5)


def test_a_wrench_that_is_as_good_as_none_changes_nothing() -> None:
    """The code with a wrench is another one than without; its motion is the same."""
    planner = rg.Planner(kernels=False)
    none = planner.plan(asked({}))
    hardly = planner.plan(asked({"wrench": {"force": [1e-9, 0.0, 0.0]}}))
    assert none.trajectory.arrays().keys() | {"wrench"} == hardly.trajectory.arrays().keys()
    assert hardly.statistics.cost == pytest.approx(none.statistics.cost, rel=1e-6)
    times = np.linspace(0.0, 2.0, 21)
    np.testing.assert_allclose(hardly.sample(times).com_position, none.sample(times).com_position, atol=1e-6)


def test_both_transcriptions_find_the_same_motion(plans: dict[str, rg.Plan]) -> None:
    other = rg.plan(asked(CASES["both"]), transcription="collocation", kernels=False)
    assert other.certificate().passed, "\n".join(map(str, other.certificate().failures))
    times = np.linspace(0.0, 2.0, 21)
    np.testing.assert_allclose(
        other.sample(times).com_position, plans["both"].sample(times).com_position, atol=2e-3
    )


@pytest.mark.parametrize(
    ("name", "loads", "rows"),
    [
        ("payload", {}, {"load_mass", "load_place", "load_inertia"}),
        ("pull", {}, {"velocity_defect", "angular_velocity_defect"}),
        ("pull", {"wrench": PULL | {"at": [0.3, 0.0, 0.0]}}, {"angular_velocity_defect"}),
        ("pull", {"wrench": PULL | {"frame": "base"}}, {"velocity_defect"}),
        ("pull", {"wrench": PULL | {"end": 1.0}}, {"velocity_defect"}),
        ("both", {"payload": PAYLOAD}, {"velocity_defect", "angular_velocity_defect"}),
    ],
)
def test_a_load_that_is_changed_afterwards_is_noticed(
    plans: dict[str, rg.Plan], name: str, loads: dict[str, Any], rows: set[str]
) -> None:
    plan = plans[name]
    spoilt = replace(plan, scenario=plan.scenario.with_values({"loads": loads}))
    assert rows <= {row.name for row in spoilt.certificate().failures}


@pytest.mark.parametrize("name", CASES)
def test_a_file_keeps_loads(plans: dict[str, rg.Plan], name: str, tmp_path: Path) -> None:
    plan = plans[name]
    other = rg.Plan.load(plan.save(tmp_path / "plan.npz"))
    assert other.scenario.loads == plan.scenario.loads
    assert other.robot == plan.robot
    times = np.linspace(0.0, 2.0, 57)
    np.testing.assert_array_equal(other.sample(times).euler, plan.sample(times).euler)


def test_feet_carry_the_payload(plans: dict[str, rg.Plan]) -> None:
    end = plans["payload"].sample(2.0)
    weight = rg.find_robot("centauro").weight + 20.0 * GRAVITY
    assert end.force[:, 2].sum() == pytest.approx(weight, rel=0.02)
