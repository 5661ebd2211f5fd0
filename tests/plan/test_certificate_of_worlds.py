"""Plans over steps, gaps and ramps are certified, and only where the ground is as it was planned for."""

from __future__ import annotations

from typing import Any

import pytest

import rollgait as rg
from rollgait.plan.certificate import certify
from tests.plan.slopes import on

STEPPING = {"kind": "schedule", "FL": [[2, 3]], "FR": [[3.4, 4.4]], "HL": [[5.6, 6.6]], "HR": [[7.0, 8.0]]}
STEP = {"goal": {"x": 2.0}, "horizon": 10, "gait": STEPPING}
RAMP = {"goal": {"x": 2.5}, "horizon": 8}
WORLDS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "up 0.15": (STEP, {"kind": "step", "x": 0.9, "height": 0.15}),
    "down 0.20": (STEP, {"kind": "step", "x": 0.9, "height": -0.2}),
    "gap 0.3": (STEP, {"kind": "gap", "x": 0.9, "length": 0.3}),
    "ramp 15": (RAMP, {"kind": "ramp", "x": 0.8, "length": 3, "slope_deg": 15}),
}


@pytest.mark.slow
@pytest.mark.parametrize("world", WORLDS)
def test_a_plan_over_the_world_is_certified(world: str) -> None:
    motion, part = WORLDS[world]
    scenario = rg.Scenario.from_dict({"robot": "centauro", "ground": {"parts": [part]}, **motion})
    plan = rg.plan(scenario, diagnose=False)
    assert plan.certificate().passed, "\n".join(map(str, plan.certificate().failures))
    elsewhere = rg.Terrain.from_parts([part | {"x": part["x"] + 0.15}])
    assert not certify(on(plan, elsewhere)).passed  # it is judged by where the ground is
