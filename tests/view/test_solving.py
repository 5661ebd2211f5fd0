"""The process behind the page: what it is handed is what it plans."""

from __future__ import annotations

from queue import Queue

import numpy as np
import pytest

import rollgait as rg
from rollgait.plan import Plan
from rollgait.view.solving import Outcome, Solving


@pytest.mark.slow
def test_a_map_goes_with_its_scenario() -> None:
    """It lies in no folder that the process knows."""
    ground = rg.Terrain.from_map(np.full((60, 60), 0.25), 0.05, (-1.5, -1.5))
    data = {"robot": "centauro", "goal": {"x": 0.2}, "horizon": 3.0}
    scenario = rg.Scenario.from_dict({**data, "ground": ground})
    done: Queue[Outcome] = Queue()
    solving = Solving(lambda _: None, done.put)
    try:
        assert solving.plan(scenario)
        outcome = done.get(timeout=300.0)
        assert outcome.file is not None, outcome.message
        plan = Plan.load(outcome.file)
    finally:
        solving.close()
    assert plan.scenario.terrain == scenario.terrain
    assert plan.sample(np.array([0.0])).foot_position[0, :, 2] == pytest.approx(0.25, abs=1e-6)
