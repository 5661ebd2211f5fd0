"""The search for better steps: what it finds is certified, planned as it says, and never worse."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from rollgait.cli.app import run
from rollgait.discover.step_search import StepSearch, Tried
from rollgait.discover.steps import steps_of, with_steps
from rollgait.errors import InputError
from rollgait.plan.plan import Plan
from rollgait.plan.work import mechanical_power, mechanical_work
from rollgait.planner import Planner
from rollgait.scenario import Scenario, find_scenario
from rollgait.searching import search_steps

SHORT = find_scenario("hybrid-forward").with_values(
    {"goal": {"x": 0.4}, "horizon": 4.0, "gait": {"kind": "crawl", "steps": 2}}
)


@pytest.fixture(scope="module")
def found() -> StepSearch:
    return search_steps(SHORT)


def test_on_flat_ground_rolling_is_left(found: StepSearch) -> None:
    assert found.best is not None
    assert found.best.steps == ()
    assert not found.cut
    assert set(found.cheapest_by_count()) == {0, 1, 2}
    costs = [tried.cost or np.inf for tried in found.cheapest_by_count().values()]
    assert costs == sorted(costs, reverse=True)


def test_the_first_is_the_gait_as_given(found: StepSearch) -> None:
    assert found.tried[0].steps == steps_of(SHORT)
    assert len({tried.steps for tried in found.tried}) == len(found.tried)


def test_what_it_says_is_what_the_planner_says(found: StepSearch) -> None:
    best = found.best
    assert best is not None
    again = Planner().plan(with_steps(SHORT, best.steps))
    assert again.certificate().passed
    assert again.statistics.cost == pytest.approx(best.cost, rel=1e-2)  # from another start


def test_the_same_input_finds_the_same(found: StepSearch) -> None:
    told: list[Tried] = []
    again = search_steps(SHORT, tell=told.append)
    assert told == list(again.tried)
    assert [tried.steps for tried in again.tried] == [tried.steps for tried in found.tried]


def test_more_than_allowed_is_not_planned() -> None:
    cut = search_steps(SHORT, candidates=2)
    assert cut.cut
    assert len(cut.tried) == 2


@pytest.mark.parametrize("values", [{"changes": ["less"]}, {"candidates": 0}])
def test_wrong_input_is_told(values: dict[str, object]) -> None:
    with pytest.raises(InputError, match=next(iter(values))):
        search_steps(SHORT, **values)  # type: ignore[arg-type]


def test_a_gait_that_cannot_be_is_in_the_table() -> None:
    hopeless = SHORT.with_values({"gait": {"kind": "schedule", "FL": [[0.0, 1.0]]}})  # it stands on FL
    search = search_steps(hopeless, changes=["orders"])
    assert search.best is None
    assert {tried.verdict for tried in search.tried} == {"not solved"}
    assert all(tried.reason for tried in search.tried)


# -- work ------------------------------------------------------------------------------------------------


def test_power_is_what_changes_the_energy(found: StepSearch) -> None:
    """∫ power of wheels and legs is the change of kinetic and potential energy, by the plan's own motion."""
    plan = found.tried[0].plan
    assert plan is not None
    samples = plan.sample_every(500.0)
    power = sum(each.sum(axis=1) for each in mechanical_power(samples))
    mass, g = plan.robot.mass, 9.81
    speed = samples.com_velocity
    energy = 0.5 * mass * (speed**2).sum(axis=1) + mass * g * samples.com_position[:, 2]
    half = len(samples.time) // 2
    done = np.trapezoid(power[: half + 1], samples.time[: half + 1])
    assert done == pytest.approx(energy[half] - energy[0], abs=0.02 * mechanical_work(plan))
    assert mechanical_work(plan) >= abs(done)


# -- command ---------------------------------------------------------------------------------------------


def test_the_command_writes_the_best_plan(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], found: StepSearch
) -> None:
    file = tmp_path / "scenario.yaml"
    file.write_text(SHORT.to_yaml())
    assert run(["search", str(file), "--json", "--change", "fewer", "--out", str(tmp_path / "best")]) == 0
    report = json.loads(capsys.readouterr().out)
    best = report["tried"][report["best"]]
    plan = Plan.load(report["file"])
    assert best["steps"] == []
    assert plan.statistics.cost == pytest.approx(best["cost"])
    assert steps_of(plan.scenario) == ()
    assert run(["search", str(file), "--candidates", "1"]) == 0
    assert "as given" in capsys.readouterr().out


def test_a_change_that_is_none_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["search", "hybrid-forward", "--change", "less"]) == 2
    assert "fewer" in capsys.readouterr().err


def test_the_scenario_of_a_found_plan_is_a_scenario(found: StepSearch) -> None:
    assert found.best is not None
    assert found.best.plan is not None
    assert Scenario.from_dict(found.best.plan.scenario.to_dict()) == found.best.plan.scenario
