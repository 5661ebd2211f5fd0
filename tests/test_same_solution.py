"""Both transcriptions find the same motion: the paper's four, from the same guess, each by its solver."""

from __future__ import annotations

import numpy as np
import pytest

import rollgait as rg
from tests.library import FLAT

pytestmark = pytest.mark.slow

TOLERANCES = {
    "hybrid-forward": (1e-3, 1e-3),
    "hybrid-goback": (1e-3, 1e-3),
    "wheeled": (1e-3, 1e-3),
    # 2.2 mm: boxes of the feet hold at nodes in the one transcription, at collocation points in the other
    "legged-forward": (1e-3, 3e-3),
    "rolling-trot": (1e-3, 2e-3),  # 1.1 mm, the same
}
"""Of the cost, relative, and of the CoM, m."""


@pytest.mark.parametrize("name", FLAT)
def test_same_solution(name: str) -> None:
    cost_tolerance, com_tolerance = TOLERANCES[name]
    scenario = rg.find_scenario(name).with_values({"profile": "paper"})
    collocation = rg.plan(scenario, transcription="collocation", solver="ipopt")
    condensed = rg.plan(scenario, transcription="condensed", solver="fatrop")
    assert collocation.statistics.start == condensed.statistics.start == "kinematic"
    assert condensed.statistics.cost == pytest.approx(collocation.statistics.cost, rel=cost_tolerance)
    times = np.linspace(0.0, scenario.horizon, 500)
    found, wanted = (plan.sample(times).com_position for plan in (condensed, collocation))
    assert np.linalg.norm(found - wanted, axis=1).max() < com_tolerance
