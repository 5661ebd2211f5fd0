"""A trajectory of the condensed transcription as a function of time, on short plans of every kind of foot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import rollgait as rg
from rollgait.plan.condensed import CondensedTrajectory

Array = NDArray[np.float64]

STEP = 1e-6
"""s, of the finite differences."""


@pytest.fixture(scope="module", params=["steerable", "fixed", "point"])
def plan(request: pytest.FixtureRequest) -> rg.Plan:
    """A step of a hind foot on the way to a goal nearby."""
    data: dict[str, Any] = {
        "robot": rg.find_robot("centauro-2020").with_feet(request.param),
        "goal": {"x": 0.04, "y": 0.01, "yaw_deg": 3},
        "horizon": 1.6,
        "gait": {"kind": "schedule", "HL": [[0.4, 0.9]]},
    }
    found = rg.plan(rg.Scenario.from_dict(data))
    assert isinstance(found.trajectory, CondensedTrajectory)
    return found


def inside_times(plan: rg.Plan) -> Array:
    """Times inside the intervals, three in each."""
    inside = np.array([0.15, 0.5, 0.85])
    schedule = plan.schedule
    return np.asarray((schedule.node_times[:-1, None] + np.outer(schedule.lengths, inside)).ravel())


def test_nothing_jumps_at_the_nodes(plan: rg.Plan) -> None:
    nodes = plan.schedule.node_times[1:-1]
    before, after = plan.sample(nodes - 1e-8), plan.sample(nodes + 1e-8)
    for name in ("com_position", "euler", "com_velocity", "euler_rate", "foot_position"):
        np.testing.assert_allclose(getattr(before, name), getattr(after, name), atol=1e-5, err_msg=name)
    np.testing.assert_allclose(before.heading, after.heading, atol=1e-5)
    if plan.robot.legs.FL.foot == "fixed":
        np.testing.assert_allclose(after.heading, after.euler[:, :1].repeat(4, axis=1), atol=1e-12)


def test_rates_are_the_slopes_of_what_they_are_rates_of(plan: rg.Plan) -> None:
    """Of the CoM and the lift to the last digit; of angles and feet as exactly as a step of 0.1 s is."""
    times = inside_times(plan)
    before, s, after = (plan.sample(times + shift) for shift in (-STEP, 0.0, STEP))

    def slope(name: str) -> Array:
        return np.asarray((getattr(after, name) - getattr(before, name)) / (2 * STEP))

    np.testing.assert_allclose(slope("com_position"), s.com_velocity, atol=1e-8)
    np.testing.assert_allclose(slope("foot_position")[..., 2], s.foot_velocity[..., 2], atol=1e-8)
    # a fixed wheel turns with the base, whose yaw it only knows to the second order
    turned = 1e-3 if plan.robot.legs.FL.foot == "fixed" else 1e-4
    np.testing.assert_allclose(slope("foot_position")[..., :2], s.foot_velocity[..., :2], atol=turned)
    np.testing.assert_allclose(slope("euler"), s.euler_rate, atol=2e-3)


def test_forces_and_contacts_are_those_of_the_interval(plan: rg.Plan) -> None:
    trajectory = plan.trajectory
    assert isinstance(trajectory, CondensedTrajectory)
    s = plan.sample(inside_times(plan))
    np.testing.assert_array_equal(s.force, np.repeat(trajectory.force, 3, axis=0))
    np.testing.assert_array_equal(s.contact, np.repeat(plan.schedule.contact.T, 3, axis=0))
    assert not s.force[~s.contact].any()


def test_saved_and_loaded_it_is_the_same(plan: rg.Plan, tmp_path: Path) -> None:
    again = rg.Plan.load(plan.save(tmp_path / "plan"))
    assert isinstance(again.trajectory, CondensedTrajectory)
    for name, array in plan.trajectory.arrays().items():
        np.testing.assert_array_equal(again.trajectory.arrays()[name], array)
    assert again.statistics == plan.statistics
    times = np.linspace(0.0, plan.horizon, 77)
    for name, array in vars(plan.sample(times)).items():
        np.testing.assert_array_equal(getattr(again.sample(times), name), array, err_msg=name)


def test_the_order_of_the_times_does_not_matter(plan: rg.Plan) -> None:
    times = np.random.default_rng(0).uniform(0.0, plan.horizon, 20)
    together = plan.sample(times)
    for k, time in enumerate(times):
        np.testing.assert_allclose(plan.sample(float(time)).euler, together.euler[k], atol=1e-12)
