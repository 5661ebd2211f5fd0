"""A brief scenario says the same as the full one."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollgait.config import parse_yaml
from rollgait.scenario import Scenario, find_scenario, scenario_names

changes = st.fixed_dictionaries(
    {},
    optional={
        "goal.yaw_deg": st.floats(-90.0, 90.0),
        "horizon": st.floats(8.0, 12.0),
        "profile": st.sampled_from(["paper", "executable"]),
        "gait.clearance": st.floats(0.02, 0.2),
        "weights.acc": st.floats(0.0, 10.0),
        "bounds.force_min": st.floats(1.0, 50.0),
        "ground.friction": st.floats(0.3, 1.0),
        "start.yaw_deg": st.floats(-90.0, 90.0),
        "robot.mass": st.floats(80.0, 150.0),
        "description": st.text(st.characters(categories=("L", "N", "P")), max_size=30),
    },
)


def read_again(scenario: Scenario) -> Scenario:
    return Scenario.from_dict(parse_yaml(scenario.to_yaml(brief=True), "text"))


@given(changes)
def test_nothing_that_was_asked_is_lost(values: dict[str, Any]) -> None:
    scenario = find_scenario("hybrid-forward").with_values(values)
    for asked in (scenario, scenario.resolved(), scenario.self_contained()):
        assert read_again(asked).self_contained() == asked.self_contained()


@pytest.mark.parametrize("name", scenario_names())
def test_a_scenario_of_the_library_is_short_also_once_spelled_out(name: str) -> None:
    scenario = find_scenario(name)
    assert read_again(scenario.self_contained()).self_contained() == scenario.self_contained()
    brief, full = (len(scenario.self_contained().to_yaml(brief=b).splitlines()) for b in (True, False))
    assert brief < 0.4 * full
