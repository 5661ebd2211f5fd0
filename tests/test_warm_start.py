"""Planning from an earlier plan: for the same goal, another one, another horizon, another mesh."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rollgait as rg
from rollgait.ocp.problem import make_problem
from rollgait.starts import from_plan
from tests.stepping import stepping as asked

STEP = 1e-6
"""s, of the finite differences."""


@pytest.fixture(scope="module")
def earlier() -> rg.Plan:
    return rg.plan(asked())


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"goal": {"x": 0.2, "y": -0.02, "yaw_deg": -5}},
        {"horizon": 2.6},
        {"interval": 0.05},
        {"gait": {"kind": "schedule", "HR": [[0.5, 1.2]]}},
        {"profile": "paper"},
    ],
    ids=["same", "goal", "horizon", "interval", "gait", "profile"],
)
def test_it_leads_where_a_cold_start_leads(values: dict[str, Any], earlier: rg.Plan) -> None:
    scenario = asked(**values)
    warm, cold = rg.plan(scenario, warm_start=earlier), rg.plan(scenario)
    assert warm.statistics.start == "warm start"
    assert warm.statistics.cost == pytest.approx(cold.statistics.cost, rel=1e-3)
    assert warm.certificate().passed == cold.certificate().passed
    if not values:
        assert warm.statistics.iterations < cold.statistics.iterations


def test_a_file_serves_as_well(earlier: rg.Plan, tmp_path: Path) -> None:
    file = earlier.save(tmp_path / "earlier.npz")
    costs = [rg.plan(asked(), warm_start=given).statistics.cost for given in (earlier, file, str(file))]
    assert costs[0] == costs[1] == costs[2]


def test_the_transcriptions_start_from_each_other(earlier: rg.Plan) -> None:
    plan = rg.plan(asked(), transcription="collocation", warm_start=earlier)
    assert plan.statistics.start == "warm start"
    back = rg.plan(asked(), warm_start=plan)
    assert back.statistics.cost == pytest.approx(earlier.statistics.cost, rel=1e-3)


@pytest.mark.parametrize("horizon", [1.7, 2.0, 3.0])
def test_a_stretched_motion_has_the_rates_of_its_places(earlier: rg.Plan, horizon: float) -> None:
    problem = make_problem(asked(horizon=horizon))
    motion = from_plan(problem, earlier)
    nodes = problem.schedule.node_times
    np.testing.assert_allclose(
        motion(nodes).com_position[-1], earlier.sample(earlier.horizon).com_position, atol=1e-9
    )
    times = np.linspace(0.0, horizon, 23)[1:-1] + 1e-4
    before, s, after = (motion(times + shift) for shift in (-STEP, 0.0, STEP))
    slope = (after.com_position - before.com_position) / (2 * STEP)
    np.testing.assert_allclose(slope, s.com_velocity, atol=1e-6)
    np.testing.assert_allclose((after.euler - before.euler) / (2 * STEP), s.euler_rate, atol=5e-3)


def test_a_plan_for_other_feet_is_refused(earlier: rg.Plan) -> None:
    robot = rg.find_robot("centauro-2020").with_feet("fixed")
    with pytest.raises(rg.InputError, match=r"warm_start: .*must be a plan for the same kinds of feet"):
        rg.plan(asked(robot=robot), warm_start=earlier)


def test_a_plan_for_another_robot_with_such_feet_is_welcome(earlier: rg.Plan) -> None:
    plan = rg.plan(asked(robot="centauro"), warm_start=earlier)
    assert plan.solved
    assert plan.robot.name == "centauro"


def test_a_missing_file_is_told_before_any_work(tmp_path: Path) -> None:
    with pytest.raises(rg.InputError, match=r"missing\.npz"):
        rg.plan(asked(), warm_start=tmp_path / "missing.npz")
