"""Ways over ground that is not flat: what is refused before anything is solved, and why."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

import rollgait as rg
from rollgait.footing.on_terrain import find_ways, regions_for

REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "no step at all": ({"gait": "drive"}, r"FL cannot roll on from .* the gait has 0 steps of it"),
    "no step of one leg": ({"gait.HL": []}, r"HL cannot roll on from .* its way needs 1"),
    "higher than a leg": ({"ground.parts.0.height": 0.5}, r"FL gets as far as .* nothing on its way"),
    "deeper than a leg": ({"ground.parts.0.height": -0.5}, r"FL gets as far as .* nothing on its way"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_where_there_is_no_way_one_sentence_says_so(case: str) -> None:
    values, rule = REFUSED[case]
    scenario = rg.find_scenario("kerb").with_values(values)
    with pytest.raises(rg.NotSolvedError, match=rule) as error:
        rg.plan(scenario)
    assert "\n" not in str(error.value)
    place = [float(v) for v in re.findall(r"-?\d+\.\d+", str(error.value))[:2]]
    assert place[0] == pytest.approx(0.9, abs=0.2)  # before the edge, as far as a wheel keeps away


def test_feet_of_a_route_stand_where_they_can() -> None:
    for name in ("kerb", "stairs", "gap"):
        scenario = rg.find_scenario(name)
        route, schedule = find_ways(scenario, scenario.schedule).route, scenario.schedule
        for leg, regions in enumerate(regions_for(scenario)):
            inside = schedule.contact[leg, schedule.mesh.interval_at(route.times)]
            assert regions.free(route.feet[inside, leg]).mean() > 0.98  # a node belongs to both its intervals
        assert (np.diff(route.base[:, 0]) >= -1e-9).all()
