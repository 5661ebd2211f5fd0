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


def crawling(part: dict[str, Any], goal: float) -> rg.Scenario:
    """CENTAURO on point feet, a few steps."""
    gait = {"kind": "crawl", "steps": 8, "wheels": "locked"}
    data = {
        "robot": "centauro",
        "goal": {"x": goal},
        "horizon": 18.0,
        "gait": gait,
        "ground": {"parts": [part]},
    }
    return rg.Scenario.from_dict(data)


@pytest.mark.parametrize(
    "scenario",
    [
        crawling({"kind": "step", "x": 0.62, "height": 0.2}, 0.05),
        crawling({"kind": "ramp", "x": 0.45, "length": 2.0, "slope_deg": 15.0}, 0.4),
        *map(rg.find_scenario, ("kerb", "gap", "ramp")),
    ],
    ids=["before a step", "onto a ramp", "kerb", "gap", "ramp"],
)
def test_a_foot_in_the_air_is_in_a_region_or_above_all_on_its_way(scenario: rg.Scenario) -> None:
    """So that nothing stands beside it wherever in its region it goes."""
    schedule = scenario.schedule
    found = find_ways(scenario, schedule)
    nodes = np.searchsorted(found.route.times, schedule.node_times - 1e-12)
    for swing in found.footing.swings:
        regions, phases = found.ways.regions[swing.leg], found.ways.phases[swing.leg]
        path = found.route.feet[nodes, swing.leg][[swing.lift_off, swing.touch_down]]
        way = path[0] + np.linspace(0.0, 1.0, 50)[:, None] * (path[1] - path[0])
        for k in range(swing.lift_off, swing.touch_down):
            region = phases[k].region
            if region is None:
                assert (
                    found.footing.model[swing.leg, k, 2] >= np.nanmax(regions.surface.height(*way.T)) - 2e-3
                )
            else:
                corners = region.vertices
                inside = corners.mean(axis=0) + 0.999 * (corners - corners.mean(axis=0))
                assert regions.free(inside).all()


def test_a_swing_across_a_kink_goes_over_it() -> None:
    """The ground of either foothold, gone on with straight, would be too low for it."""
    scenario = crawling({"kind": "ramp", "x": 0.45, "length": 2.0, "slope_deg": 15.0}, 0.4)
    found = find_ways(scenario, scenario.schedule)
    crossing = [s for s in found.footing.swings if s.before == 0.0 < s.after]
    assert crossing
    assert all(s.over and s.top >= s.after for s in crossing)
    assert not found.footing.is_curved
    assert found.footing.is_sloped
