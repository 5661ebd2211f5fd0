"""Free timing: cheaper, in the same order, within limits, and the same motion when its times are given."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rollgait as rg
from rollgait.scenario.timing import Timing
from rollgait.timing.phases import Phases
from tests.stepping import stepping

TIMED = {"timing": {"effort": 0.0}}
SAME = 1e-3
"""m; so near are motions that are the same."""


def two_steps(**values: object) -> rg.Scenario:
    """Two steps, the second begins while the first foot is in the air still."""
    gait = {"kind": "schedule", "HL": [[0.5, 1.2]], "FR": [[1.8, 2.5]]}
    return stepping(horizon=3.2, gait=gait, **values)


@pytest.fixture(scope="module")
def fixed() -> rg.Plan:
    return rg.plan(two_steps())


@pytest.fixture(scope="module")
def found() -> rg.Plan:
    return rg.plan(two_steps().with_values({"gait.timing": TIMED["timing"]}))


def order(plan: rg.Plan) -> list[tuple[bool, ...]]:
    phases = Phases.of(plan.scenario, plan.schedule)
    return [tuple(column) for column in phases.contact.T]


def test_free_times_cost_less_and_keep_horizon_order_and_limits(fixed: rg.Plan, found: rg.Plan) -> None:
    assert found.certificate().passed
    assert found.statistics.cost < fixed.statistics.cost
    assert found.horizon == pytest.approx(fixed.horizon, abs=1e-6)
    assert order(found) == order(fixed)
    phases, limits = Phases.of(found.scenario, found.schedule), Timing()
    swings = phases.lengths[phases.swings]
    assert (swings >= limits.swing[0] - 1e-5).all()
    assert (swings <= limits.swing[1] + 1e-5).all()
    assert (phases.lengths[~phases.swings] >= limits.stance_min - 1e-5).all()


def test_the_found_times_given_are_the_same_motion(found: rg.Plan) -> None:
    scenario = rg.Scenario.from_dict(found.scenario.to_dict())
    assert scenario.gait.timing is None
    assert scenario.schedule.mesh.intervals == found.schedule.mesh.intervals
    again = rg.plan(scenario)
    times = np.linspace(0.0, found.horizon, 101)
    apart = again.sample(times).com_position - found.sample(times).com_position
    assert np.linalg.norm(apart, axis=1).max() < SAME
    assert again.statistics.cost == pytest.approx(found.statistics.cost, rel=1e-4)


def test_bad_times_lead_to_the_same_ones(found: rg.Plan) -> None:
    gait = {"kind": "schedule", "HL": [[0.2, 0.5]], "FR": [[0.6, 0.9]], **TIMED}
    other = rg.plan(stepping(horizon=3.2, gait=gait))
    assert other.statistics.cost == pytest.approx(found.statistics.cost, rel=1e-3)


def test_swings_that_overlap_keep_their_limits_and_their_order() -> None:
    gait = {"kind": "schedule", "HL": [[0.4, 1.1]], "FR": [[0.8, 1.6]], **TIMED}
    plan = rg.plan(stepping(horizon=2.2, gait=gait))
    assert plan.certificate().passed
    swings = [plan.schedule.node_times[[s.lift_off, s.touch_down]] for s in plan.schedule.swings()]
    assert all(0.4 - 1e-5 <= end - begin <= 1.5 + 1e-5 for begin, end in swings)
    (fr_begin, fr_end), (hl_begin, hl_end) = swings  # in the order of the legs
    assert hl_begin < fr_begin < hl_end < fr_end


def test_the_higher_the_price_of_time_the_sooner_it_is_over() -> None:
    horizons = []
    for price in (1.0, 100.0):
        priced = two_steps().with_values({"horizon": {"max": 6.0, "price": price}, "gait.timing.effort": 0.0})
        plan = rg.plan(priced)
        assert plan.certificate().passed
        horizons.append(plan.horizon)
    assert horizons[1] < horizons[0] <= 6.0


def test_effort_lengthens_swings(found: rg.Plan) -> None:
    plan = rg.plan(two_steps().with_values({"gait.timing": {"effort": 3.0}}))

    def shortest(of: rg.Plan) -> float:
        phases = Phases.of(of.scenario, of.schedule)
        return float(phases.lengths[phases.swings].min())

    assert shortest(plan) > shortest(found) + 0.02
    assert plan.scenario.weights.effort == 3.0


def test_a_goal_that_switches_stays_when_it_is() -> None:
    goal = {"x": 0.1, "then": [{"at": 1.5, "x": 0.0}]}
    plan = rg.plan(two_steps().with_values({"goal": goal, "gait.timing": TIMED["timing"]}))
    assert plan.certificate().passed
    assert np.abs(plan.schedule.node_times - 1.5).min() < 1e-6


@settings(deadline=None, max_examples=30)
@given(st.lists(st.floats(0.1, 3.0), min_size=5, max_size=5))
def test_phases_of_a_gait_at_other_times_are_these_phases(lengths: list[float]) -> None:
    scenario = two_steps()
    other = Phases.of(scenario, scenario.schedule).lasting(np.array(lengths))
    nodes = other.on_mesh(np.full(other.count, 4)).node_times
    gait = other.gait(scenario, nodes).model_dump(mode="json")
    again = scenario.with_values({"gait": gait, "horizon": float(nodes[-1])})
    phases = Phases.of(again, again.schedule)
    assert np.allclose(phases.borders, other.borders)
    assert (phases.contact == other.contact).all()


@pytest.mark.parametrize(
    ("values", "key"),
    [
        ({"gait.timing": {"swing": [1.0, 0.5]}}, "swing"),
        ({"gait.timing": {"stance_min": 0.0}}, "stance_min"),
        ({"horizon": {"max": 10.0}}, "horizon"),
        ({"horizon": {"max": 10.0, "prize": 1.0}}, "horizon"),
        ({"gait.nodes": [0.0, 1.0, 0.5]}, "nodes"),
        ({"gait.nodes": [0.0, 0.5, 1.0]}, "nodes"),
    ],
)
def test_what_is_wrong_is_named(values: dict[str, object], key: str) -> None:
    with pytest.raises(rg.InputError, match=key):
        two_steps().with_values(values).check()
