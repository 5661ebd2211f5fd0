"""Plans on meshes of unequal intervals: solved, certified, saved, started from each other, diagnosed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rollgait as rg
from rollgait.diagnosis.elastic import Missed
from rollgait.diagnosis.reasons import reasons_of
from rollgait.ocp.problem import make_problem
from rollgait.ocp.term import Place
from rollgait.transcription.nlp import RowOrigin
from rollgait.transcription.stage import RowLabel
from tests.stepping import METHODS, solved, stepping

CUT = [1, 2, 7, 8, 15, 18]
"""Intervals in stance and in swing."""
CUT_AT_CONTACTS = [4, 5, 11, 12]
"""Those about the lift-off and the touch-down."""


def assert_certified(plan: rg.Plan) -> None:
    assert plan.solved
    assert plan.certificate().passed, "\n".join(map(str, plan.certificate().failures))


@pytest.fixture(scope="module", params=METHODS)
def method(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.mark.parametrize("feet", ["steerable", "fixed", "point"])
def test_some_intervals_halved_lead_to_nearly_the_same_motion(feet: str, method: str) -> None:
    asked = stepping(robot=rg.find_robot("centauro-2020").with_feet(feet), goal={"x": 0.06})
    even = solved(asked, asked.schedule, method)
    assert_certified(even)
    times = np.linspace(0.0, even.horizon, 101)
    for cut in (CUT, CUT_AT_CONTACTS):
        finer = solved(asked, asked.schedule.refined(cut), method)
        assert_certified(finer)
        assert finer.schedule.intervals == even.schedule.intervals + len(cut)
        apart = finer.sample(times).com_position - even.sample(times).com_position
        assert np.linalg.norm(apart, axis=1).max() < 1e-3
        if cut is CUT:  # the jump of a force where a contact changes costs more, as `ForceChange` says
            assert finer.statistics.cost == pytest.approx(even.statistics.cost, rel=0.02)


@pytest.mark.parametrize("seed", range(3))
def test_where_no_contact_changes_the_cost_is_that_of_the_finest_mesh(seed: int) -> None:
    asked = stepping(gait={"kind": "drive"})
    random, last = np.random.default_rng(seed), asked.schedule.intervals - 1
    # wheels rest for all of the last interval: cut, that would be another problem
    which = random.choice(last, last // 2, replace=False)
    uneven = asked.schedule.refined(which, random.integers(2, 4, which.size))
    finest = asked.schedule.refined(np.arange(last), 3)
    costs = [solved(asked, schedule).statistics.cost for schedule in (uneven, finest)]
    assert costs[0] == pytest.approx(costs[1], rel=5e-3)


def test_meshes_start_from_each_other() -> None:
    asked = stepping()
    even = solved(asked, asked.schedule)
    cold, warm = (solved(asked, asked.schedule.refined(CUT), warm_start=w) for w in (None, even))
    back = solved(asked, asked.schedule, warm_start=warm)
    assert warm.statistics.iterations < cold.statistics.iterations
    assert warm.statistics.cost == pytest.approx(cold.statistics.cost, rel=1e-3)
    assert back.statistics.cost == pytest.approx(even.statistics.cost, rel=1e-3)
    # and the planner takes a plan on any mesh
    again = rg.plan(asked, warm_start=warm)
    assert again.statistics.start == "warm start"
    assert again.schedule == asked.schedule


def test_an_equal_mesh_plans_as_the_interval_of_the_scenario_does() -> None:
    asked = stepping()
    one, other = rg.plan(asked), solved(asked, asked.schedule)
    assert other.statistics.cost == one.statistics.cost
    assert other.statistics.iterations == one.statistics.iterations
    for name, array in one.trajectory.arrays().items():
        np.testing.assert_array_equal(other.trajectory.arrays()[name], array, name)


def test_nothing_jumps_at_the_nodes_and_a_file_keeps_it_all(method: str, tmp_path: Path) -> None:
    asked = stepping()
    plan = solved(asked, asked.schedule.refined(CUT, [2, 3, 2, 4, 2, 2]), method)
    nodes = plan.schedule.node_times[1:-1]
    before, after = plan.sample(nodes - 1e-8), plan.sample(nodes + 1e-8)
    for name in ("com_position", "euler", "com_velocity", "euler_rate", "foot_position", "heading"):
        np.testing.assert_allclose(getattr(before, name), getattr(after, name), atol=1e-5, err_msg=name)
    loaded = rg.Plan.load(plan.save(tmp_path / "plan"))
    assert loaded.schedule == plan.schedule
    times = np.linspace(0.0, plan.horizon, 77)
    for name, array in vars(plan.sample(times)).items():
        np.testing.assert_array_equal(getattr(loaded.sample(times), name), array, err_msg=name)


def test_the_acceleration_bound_holds_between_intervals_of_any_length() -> None:
    """A bound that is active: the certificate, which knows the lengths by itself, finds it reached."""
    asked = stepping(goal={"x": 0.45}, gait={"kind": "drive"}, bounds={"acceleration_max": 0.5})
    plan = solved(asked, asked.schedule.refined([0, 1, 2, 9, 10, 17], 2))
    row = plan.certificate().row("acceleration")
    assert row.verdict == "pass"
    assert row.worst == pytest.approx(0.5, abs=1e-3)


def test_reasons_are_told_in_time_whatever_the_mesh() -> None:
    problem = make_problem(stepping(), schedule=stepping().schedule.refined([0, 1], 2))
    cut = RowOrigin(RowLabel("acceleration", 0, Place.NODE.name, unit="m/s"), 4)
    (reason,) = reasons_of(problem, [Missed(cut, 0.075)])
    assert (reason.begin, reason.end) == (pytest.approx(0.2), pytest.approx(0.3))
    assert (reason.excess, reason.unit) == (pytest.approx(0.075 / 0.075), "m/s²")
