"""Solved means certified: what fails between nodes is mended on a finer mesh."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import rollgait as rg
from rollgait.attempts import Effort
from rollgait.mending import failing_intervals, finer
from rollgait.planner import Planner
from rollgait.robot.library import find_robot


def coarse(**values: object) -> rg.Scenario:
    """A half turn on long intervals, whose feet leave their boxes between the nodes."""
    data = {"robot": "centauro-2020", "goal": {"x": 0.0, "yaw_deg": 180}, "horizon": 8.4, "interval": 0.2}
    return rg.Scenario.from_dict(data | values)


def unmended(scenario: rg.Scenario, monkeypatch: pytest.MonkeyPatch) -> rg.Plan:
    with monkeypatch.context() as patch:
        patch.setattr("rollgait.planner.finer", lambda plan: None)
        patch.setattr("rollgait.attempts.FALLBACKS", 1)
        return rg.plan(scenario)


def test_what_fails_between_nodes_is_mended(monkeypatch: pytest.MonkeyPatch) -> None:
    before = unmended(coarse(), monkeypatch)
    assert before.certificate().failures
    plan = rg.plan(coarse())
    assert plan.certificate().passed, plan.certificate().failures
    assert plan.schedule.intervals > before.schedule.intervals
    assert plan.horizon == pytest.approx(before.horizon)
    assert plan.statistics.start.endswith("finer mesh")
    parts = plan.statistics.seconds
    assert parts["certify"] > 0.0
    assert plan.statistics.wall_time == pytest.approx(sum(parts.values()))


@pytest.mark.parametrize("looks", [1, 2])
def test_nothing_is_mended_that_nobody_judges(looks: int, monkeypatch: pytest.MonkeyPatch) -> None:
    mended = list[rg.Plan]()

    def counted(planner: Planner, *arguments: Any) -> rg.Plan | None:
        found = mend(planner, *arguments)
        mended.extend([] if found is None else [found])
        return found

    mend = Planner._mended
    monkeypatch.setattr(Planner, "_mended", counted)
    plan = Planner().plan_within(coarse(), Effort(starts=1, rounds=looks))
    assert len(mended) == looks - 1
    assert plan.certificate().passed == (looks == 2)


def test_only_what_fails_and_its_neighbours_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = unmended(coarse(), monkeypatch)
    bad, schedule = failing_intervals(plan), finer(plan)
    assert bad is not None
    assert schedule is not None
    assert bad.any()
    assert schedule.horizon == pytest.approx(plan.horizon)
    middles = plan.schedule.mesh.middles
    cut = np.abs(middles[:, None] - schedule.node_times).min(axis=1) < 1e-9
    assert cut[bad].all()
    assert cut.sum() <= 3 * bad.sum()


def test_a_plan_that_passes_stays_as_it_is() -> None:
    plan = rg.plan("hybrid-forward")
    assert plan.schedule.mesh.is_equal
    assert finer(plan) is None


def test_a_row_tells_all_places_where_it_fails() -> None:
    plan = rg.plan("hybrid-forward")
    force = plan.trajectory.force.copy()
    bad = [10, 50]
    force[bad, 0, 0] += 5000.0
    spoilt = replace(plan, trajectory=replace(plan.trajectory, force=force))
    for row in spoilt.certificate().failures:
        assert row.failing
    found = np.array(spoilt.certificate().row("friction_margin").failing)
    begins = spoilt.schedule.node_times[bad]
    assert found.size == len(bad)
    assert ((found >= begins) & (found <= begins + spoilt.schedule.lengths[bad] + 1e-6)).all()


@pytest.mark.parametrize("yaw", [20.0, 45.0])
def test_fixed_wheels_agree_with_the_certificate(yaw: float) -> None:
    robot = find_robot("centauro-2020").with_feet("fixed")
    for gait in ({"kind": "drive"}, {"kind": "crawl", "steps": 8}):
        asked = rg.Scenario.from_dict(
            {"robot": robot, "goal": {"x": 0.0, "yaw_deg": yaw}, "gait": gait, "horizon": 10.0}
        )
        plan = Planner().plan(asked)
        assert plan.certificate().passed, plan.certificate().failures


def test_defaults_fit_the_robot() -> None:
    big = rg.Scenario.from_dict({"robot": "centauro", "goal": {"x": 1.0}})
    assert big.clearance == 0.08
    assert big.value_of("bounds", "force_min") == 40.0
    robot = find_robot("centauro")
    data = robot.model_dump(mode="json")
    data["mass"] = 15.0
    small = rg.Scenario.from_dict({"robot": type(robot).model_validate(data), "goal": {"x": 1.0}})
    assert small.value_of("bounds", "force_min") == pytest.approx(0.045 * 15.0 * 9.81, rel=1e-3)
    assert small.with_values({"bounds.force_min": 20.0}).value_of("bounds", "force_min") == 20.0


@pytest.mark.parametrize("mass", [2.0, 15.0, 60.0])
def test_changes_of_forces_cost_light_robots_what_they_are_of_their_weight(mass: float) -> None:
    """So that motions of robots that differ in mass alone are the same, as `test_planner` has it."""
    robot = find_robot("centauro-2020")
    data = robot.model_dump(mode="json") | {"mass": mass}
    data["inertia"] = {axis: value * mass / robot.mass for axis, value in data["inertia"].items()}

    def cost(mass_: float, profile: str) -> float:
        body = type(robot).model_validate(data | {"mass": mass_})
        asked = rg.Scenario.from_dict({"robot": body, "goal": {"x": 1.0}, "profile": profile})
        return float(asked.value_of("weights", "force")) * body.weight**2

    assert cost(mass, "executable") == pytest.approx(cost(0.5 * mass, "executable"))
    assert cost(mass, "paper") == pytest.approx(4.0 * cost(0.5 * mass, "paper"))
    assert cost(200.0, "executable") == cost(200.0, "paper")
