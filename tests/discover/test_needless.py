"""Laws of steps that are left out: geometry names them, the certificate and the cost decide."""

from __future__ import annotations

from dataclasses import replace

import pytest

import rollgait as rg
from rollgait.discover.needless import needless_steps
from rollgait.discover.search import discover
from rollgait.discover.steps import steps_of
from rollgait.scenario import Scenario
from tests.discover.test_greedy import FIXED, to
from tests.discover.worlds import STEP, world

GOAL = (1.0, -0.6, 40.0)
"""Ahead, aside and turned: some steps of fixed wheels are needless."""


@pytest.fixture(scope="module")
def planner() -> rg.Planner:
    return rg.Planner()


@pytest.fixture(scope="module")
def lean(planner: rg.Planner) -> rg.Plan:
    return planner.plan(to(FIXED, *GOAL, gait={"kind": "discover", "search": {"seconds": 600.0}}))


@pytest.fixture(scope="module")
def first(planner: rg.Planner) -> rg.Plan:
    """The same with the gait that was found first."""
    one = {"kind": "discover", "search": {"candidates": 1, "seconds": 600.0}}
    return planner.plan(to(FIXED, *GOAL, gait=one))


def test_what_is_left_out_was_called_needless_and_costs_nothing(lean: rg.Plan, first: rg.Plan) -> None:
    kept, before = set(steps_of(lean.scenario)), set(steps_of(first.scenario))
    assert kept < before
    assert before - kept <= set(needless_steps(first))
    assert lean.certificate().passed
    assert lean.statistics.cost <= first.statistics.cost * 1.001


def test_what_was_found_is_told_last(lean: rg.Plan) -> None:
    *others, found = lean.statistics.discovery
    assert found.outcome == "certified"
    assert found.steps == sum(len(step.legs) for step in steps_of(lean.scenario))
    assert others
    assert others[0].outcome == "certified, not kept"


def test_the_candidates_are_a_limit(first: rg.Plan) -> None:
    assert needless_steps(first)
    assert [tried.outcome for tried in first.statistics.discovery] == ["certified"]


def test_who_would_be_dearer_keeps_its_steps(first: rg.Plan) -> None:
    """The same plan for all gaits, dearer each time: what was found first stays, and is told last."""
    asked: list[Scenario] = []

    def dearer(scenario: Scenario, task: str, until: float, start: rg.Plan | None = None) -> rg.Plan:
        asked.append(scenario)
        return first.with_statistics(replace(first.statistics, cost=100.0 * len(asked)))

    gait = {"kind": "discover", "search": {"seconds": 600.0}}
    plan = discover(to(FIXED, *GOAL, gait=gait), dearer)
    assert plan.statistics.cost == 100.0
    assert len(asked) == 3  # all of them, then half of them
    all_of_them, without_any, without_half = (len(steps_of(scenario)) for scenario in asked)
    assert without_any < without_half < all_of_them
    outcomes = [tried.outcome for tried in plan.statistics.discovery]
    assert outcomes == ["certified, not kept", "certified, not kept", "certified"]


def test_over_an_edge_every_step_is_needed(planner: rg.Planner) -> None:
    plan = planner.plan(world([STEP], {"x": 2.2}))
    assert needless_steps(plan) == ()
    assert [tried.outcome for tried in plan.statistics.discovery] == ["certified"]


def test_a_step_on_ground_that_can_be_rolled_over_is_needless(planner: rg.Planner) -> None:
    """Behind the kerb a further step of FL leads over nothing."""
    kerb = planner.plan(world([STEP], {"x": 2.2}))
    swings = {leg: [list(s) for s in own] for leg, own in kerb.scenario.gait.swings(kerb.horizon).items()}
    last = max(end for own in swings.values() for _, end in own)
    swings["FL"].append([last + 0.4, last + 1.2])
    gait = {**kerb.scenario.gait.model_dump(mode="json"), **swings}
    longer = kerb.scenario.with_values({"gait": gait, "horizon": kerb.horizon + 1.6})
    found = needless_steps(planner.plan(longer))
    assert [(step.begin, step.legs) for step in found] == [(pytest.approx(last + 0.4), ("FL",))]
