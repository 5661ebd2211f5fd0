"""Laws of plans whose gait was found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rollgait as rg
from rollgait.discover.search import discover
from rollgait.errors import InputError, NotSolvedError
from rollgait.ocp.problem import make_problem
from rollgait.solvers import Iteration
from tests.discover.worlds import PILLAR, STEP, WALL, world

PATIENT = {"kind": "discover", "search": {"seconds": 600.0}}


@pytest.fixture(scope="module")
def planner() -> rg.Planner:
    return rg.Planner()


@pytest.fixture(scope="module")
def kerb(planner: rg.Planner) -> rg.Plan:
    return planner.plan(world([STEP], {"x": 2.2}, gait=PATIENT))


def test_flat_ground_is_driven_over(planner: rg.Planner) -> None:
    plan = planner.plan(world(goal={"x": 1.5, "y": 0.4, "yaw_deg": 40.0}))
    assert plan.certificate().passed
    assert plan.schedule.contact.all()
    assert [(r.name, r.outcome) for r in plan.statistics.discovery] == [("driving", "certified")]


def test_a_kerb_is_stepped_up_with_reserves(kerb: rg.Plan) -> None:
    assert kerb.certificate().passed
    assert [sum(swing.leg == leg for swing in kerb.schedule.swings()) for leg in range(4)] == [1, 1, 1, 1]
    bounds = kerb.scenario.bounds
    assert (bounds.friction_share, bounds.reach_margin, bounds.com_margin) == (0.8, 0.01, 0.01)
    s = kerb.sample_every(50.0)
    tangential = np.hypot(s.force[..., 0], s.force[..., 1])  # the treads are level
    assert (tangential <= np.sqrt(2.0) * 0.8 * 0.5 * s.force[..., 2] + 1.0).all()


def test_what_was_found_plans_again_to_the_same_motion(kerb: rg.Plan, planner: rg.Planner) -> None:
    again = planner.plan(kerb.scenario)
    assert again.schedule == kerb.schedule
    assert again.statistics.discovery == ()
    times = np.linspace(0.0, kerb.horizon, 50)
    np.testing.assert_array_equal(again.sample(times).com_position, kerb.sample(times).com_position)


def test_the_same_input_gives_the_same_plan(kerb: rg.Plan) -> None:
    again = rg.Planner().plan(world([STEP], {"x": 2.2}, gait=PATIENT))
    assert again.statistics.discovery == kerb.statistics.discovery
    times = np.linspace(0.0, kerb.horizon, 50)
    np.testing.assert_array_equal(again.sample(times).com_position, kerb.sample(times).com_position)


def test_what_was_tried_survives_a_file(kerb: rg.Plan, tmp_path: Path) -> None:
    loaded = rg.Plan.load(kerb.save(tmp_path / "kerb.npz"))
    assert loaded.statistics.discovery == kerb.statistics.discovery
    assert len(loaded.statistics.discovery) >= 1


def test_a_pillar_is_gone_around(planner: rg.Planner) -> None:
    told = set[str]()

    def listen(iteration: Iteration) -> None:
        told.add(iteration.task)

    plan = planner.plan(world([PILLAR], {"x": 3.0}, gait=PATIENT), progress=listen)
    assert plan.certificate().passed
    assert plan.schedule.contact.all()
    feet = plan.sample_every(50.0).foot_position[..., :2]
    assert np.abs(feet - [1.5, 0.0]).max(axis=-1).min() > 0.15 + 0.12
    assert any(task.startswith("gait 1 of at most 12, around") for task in told)


def test_a_closed_wall_is_refused(planner: rg.Planner) -> None:
    with pytest.raises(NotSolvedError, match=r"no landing between x = 1\.17 and 1\.6. m for FL"):
        planner.plan(world([WALL], {"x": 3.0}))


def test_where_the_search_is_cut_the_sentence_says_so() -> None:
    cut = {"kind": "discover", "search": {"seconds": 1e-6}}

    def fails(scenario: rg.Scenario, task: str, until: float, start: rg.Plan | None = None) -> rg.Plan:
        raise NotSolvedError("it does not converge")

    with pytest.raises(
        NotSolvedError, match=r"one gait was tried until gait\.search\.seconds = 1e-06 were over"
    ):
        discover(world([STEP], {"x": 2.2}, gait=cut), fails)
    few = {"kind": "discover", "search": {"candidates": 3, "seconds": 600.0}}
    with pytest.raises(
        NotSolvedError, match=r": 3 gaits were tried; the first one \(as it comes\): it does not"
    ):
        discover(world([STEP], {"x": 2.2}, gait=few), fails)


def test_gaits_that_the_mesh_cannot_hold_are_tried_and_told() -> None:
    def unused(scenario: rg.Scenario, task: str, until: float, start: rg.Plan | None = None) -> rg.Plan:
        raise AssertionError(task)

    with pytest.raises(
        NotSolvedError, match=r"gaits were tried; the first one \(as it comes\): gait\.FL: .* 2 intervals"
    ):
        discover(world([STEP], {"x": 2.2}, gait=PATIENT, interval=0.9), unused)


def test_a_problem_of_a_gait_yet_to_be_found_is_refused() -> None:
    with pytest.raises(InputError, match=r"^gait: 'discover' must be found first"):
        make_problem(world())


@pytest.mark.parametrize(
    ("search", "field"),
    [({"candidates": 0}, r"gait\.search\.candidates"), ({"seconds": 0.0}, r"gait\.search\.seconds")],
)
def test_nonsense_is_refused(search: dict[str, float], field: str) -> None:
    with pytest.raises(InputError, match=field):
        world(gait={"kind": "discover", "search": search})
    with pytest.raises(InputError, match=r"gait\.reserves\.friction_share"):
        world(gait={"kind": "discover", "reserves": {"friction_share": 1.2}})


def test_the_horizon_is_free_where_nobody_gives_it() -> None:
    free = world()
    assert free.horizon == 120.0
    assert free.with_values({"goal.x": 1.0}).horizon == 120.0
    assert free.with_values({"gait": "drive"}).horizon == 10.0
    assert rg.Scenario.from_dict({"robot": "centauro", "goal": {"x": 1.0}}).with_values(
        {"gait": "discover"}
    ) == world(goal={"x": 1.0})
    given = rg.Scenario.from_dict({"robot": "centauro", "goal": {"x": 1.0}, "horizon": 8.0})
    assert given.with_values({"gait": "discover"}).horizon == 8.0
    assert given.with_values({"horizon": 120.0}).with_values({"goal.x": 0.5}).horizon == 120.0
    assert rg.Scenario.from_dict(free.to_dict()) == free
