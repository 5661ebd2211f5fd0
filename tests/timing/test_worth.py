"""dJ/dT by multipliers: as finite differences say, and none to gain where timing is free."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import rollgait as rg
from rollgait.attempts import Method, Ready
from rollgait.ocp.costs import ForceChange
from rollgait.ocp.problem import make_problem
from rollgait.scenario import ContactSchedule
from rollgait.scenario.mesh import Mesh
from rollgait.starts import from_plan
from rollgait.timing.phases import Phases
from tests.timing.test_timing import two_steps

STEP = 2e-3
"""s, by which phases are stretched to see what it costs."""


@pytest.fixture(scope="module")
def plan() -> rg.Plan:
    """With lengths of intervals that differ a little, so that no two limits meet in one point."""
    scenario = two_steps()
    phases = Phases.of(scenario, scenario.schedule)
    phases = phases.lasting(phases.lengths * np.array([1.02, 0.98, 1.05, 1.01, 0.97]))
    nodes = phases.on_mesh(phases.fine(0.1)).node_times
    gait = phases.gait(scenario, nodes).model_dump(mode="json")
    return rg.plan(scenario.with_values({"gait": gait, "horizon": float(nodes[-1])}))


def cost(plan: rg.Plan, lengths: np.ndarray) -> float:
    """The optimal cost with intervals of other lengths, where jumps cost what they do in the plan."""
    problem = make_problem(plan.scenario, (), plan.schedule)
    terms = tuple(
        ForceChange(term.weight, plan.schedule.mesh) if isinstance(term, ForceChange) else term
        for term in problem.terms
    )
    schedule = ContactSchedule(plan.schedule.contact, Mesh(lengths))
    ready = Ready(Method.of(None, None, True), replace(problem, terms=terms, schedule=schedule))
    guess = ready.transcribed.encode(from_plan(ready.problem, plan))
    solution = ready.solver.solve(guess, None, warm=True)
    assert solution.solved
    return solution.cost


def test_multipliers_say_what_finite_differences_say(plan: rg.Plan) -> None:
    phases = Phases.of(plan.scenario, plan.schedule)
    number = np.searchsorted(phases.borders, plan.schedule.mesh.middles) - 1
    worth = rg.timing_gradient(plan)
    assert [phase.swings for phase in worth] == [(), (2,), (), (1,), ()]
    slopes = []
    for k in range(phases.count):
        stretched = [
            plan.schedule.lengths * np.where(number == k, 1.0 + step / phases.lengths[k], 1.0)
            for step in (STEP, -STEP)
        ]
        slopes.append((cost(plan, stretched[0]) - cost(plan, stretched[1])) / (2.0 * STEP))
    size = np.abs(slopes).max()
    assert [phase.cost_per_second for phase in worth] == pytest.approx(slopes, abs=0.03 * size)


def test_where_times_are_free_a_shift_of_time_saves_nothing(plan: rg.Plan) -> None:
    found = rg.plan(two_steps().with_values({"gait.timing": {"effort": 3.0}}))
    phases = Phases.of(found.scenario, found.schedule)
    limits = np.where(phases.swings, 0.4, 0.1)
    interior = phases.lengths > limits + 1e-3
    assert interior.sum() >= 3
    slopes = np.array([phase.cost_per_second for phase in rg.timing_gradient(found)])
    before = np.array([phase.cost_per_second for phase in rg.timing_gradient(plan)])
    assert np.ptp(slopes[interior]) < 0.1 * np.ptp(before)
    # who is at the shortest that is allowed would rather be shorter
    assert (slopes[~interior] > slopes[interior].mean()).all()
