"""Turning on the spot on wheels that slip sideways: certified, mirrored, and judged where it is spoilt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import rollgait as rg
from tests.skidding import SLIP_MAX, robot, turning

YAW = 30.0
LEFT_TO_RIGHT = [1, 0, 3, 2]


@pytest.fixture(scope="module")
def plan() -> rg.Plan:
    """A turn to the left."""
    return rg.plan(turning(YAW))


@pytest.fixture(scope="module")
def samples(plan: rg.Plan) -> rg.Samples:
    return plan.sample(np.linspace(0.0, plan.horizon, 61))


def across(samples: rg.Samples, vector: np.ndarray) -> np.ndarray:
    return vector[..., 1] * np.cos(samples.heading) - vector[..., 0] * np.sin(samples.heading)


def test_it_is_certified(plan: rg.Plan, samples: rg.Samples) -> None:
    certificate = plan.certificate()
    assert certificate.passed, "\n".join(map(str, certificate.failures))
    assert certificate.row("skid_friction").verdict == "pass"
    slip = across(samples, samples.foot_velocity)
    assert 0.5 * SLIP_MAX < np.abs(slip).max() < SLIP_MAX + 1e-6


def test_it_ends_in_its_stance_and_sticks(plan: rg.Plan) -> None:
    end = plan.sample([plan.horizon])
    np.testing.assert_allclose(across(end, end.foot_velocity), 0.0, atol=1e-6)
    assert plan.certificate().row("end_feet").worst < 1e-6


def test_the_mirrored_goal_has_the_mirrored_plan(plan: rg.Plan, samples: rg.Samples) -> None:
    mirrored = rg.plan(turning(-YAW))
    other = mirrored.sample(samples.time)
    assert mirrored.statistics.cost == pytest.approx(plan.statistics.cost, rel=1e-6)
    np.testing.assert_allclose(other.euler[:, 0], -samples.euler[:, 0], atol=1e-4)
    np.testing.assert_allclose(other.force[:, LEFT_TO_RIGHT, 2], samples.force[..., 2], atol=0.5)
    np.testing.assert_allclose(other.force[:, LEFT_TO_RIGHT, 1], -samples.force[..., 1], atol=0.5)


def asked(plan: rg.Plan, slip_max: float | None) -> rg.Plan:
    """The same motion of a robot whose wheels may slip so fast."""
    body = robot(slip_max)
    return replace(plan, robot=body, scenario=plan.scenario.model_copy(update={"robot": body}))


def failing(plan: rg.Plan) -> set[str]:
    return {row.name for row in plan.certificate().failures}


def test_a_slip_beyond_the_limit_fails(plan: rg.Plan) -> None:
    assert "skid_slip" in failing(asked(plan, 0.5 * SLIP_MAX))


def test_a_slip_of_wheels_that_may_not_fails(plan: rg.Plan) -> None:
    assert "stance_slip" in failing(asked(plan, None))


def test_a_slip_that_is_not_over_at_the_end_fails(plan: rg.Plan) -> None:
    """In the last interval wheels rest; to slip there as fast as elsewhere is not allowed."""
    motion = np.array(plan.trajectory.motion)
    motion[-1, :, 1] = 0.5 * SLIP_MAX
    row = replace(plan, trajectory=replace(plan.trajectory, motion=motion)).certificate().row("skid_slip")
    assert row.verdict == "fail"
    assert row.time is not None
    assert row.time > plan.horizon - float(plan.schedule.lengths[-1]) - 1e-6


def spoilt(plan: rg.Plan, force: np.ndarray) -> rg.Plan:
    return replace(plan, trajectory=replace(plan.trajectory, force=force))


def forces_across(plan: rg.Plan, factor: float) -> np.ndarray:
    """The plan's forces, the part across the headings times a factor."""
    lengths = plan.schedule.lengths
    middle = plan.sample(np.cumsum(lengths) - 0.5 * lengths)
    left = np.stack([-np.sin(middle.heading), np.cos(middle.heading), np.zeros_like(middle.heading)], axis=-1)
    force = np.asarray(plan.trajectory.force)
    assert force.shape == middle.force.shape
    np.testing.assert_allclose(force, middle.force, atol=1e-6)
    return force + (factor - 1.0) * across(middle, force)[..., None] * left


def test_a_force_along_the_slip_fails(plan: rg.Plan) -> None:
    assert {"skid_direction"} <= failing(spoilt(plan, forces_across(plan, -1.0)))


def test_sliding_for_nothing_fails(plan: rg.Plan) -> None:
    assert "skid_friction" in failing(spoilt(plan, forces_across(plan, 0.5)))


def test_the_judge_takes_the_plan_back_when_nothing_is_spoilt(plan: rg.Plan) -> None:
    assert not failing(spoilt(plan, forces_across(plan, 1.0))) & {"skid_direction", "skid_friction"}
