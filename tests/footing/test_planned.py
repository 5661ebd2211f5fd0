"""Motions over ground that is not flat: laws that they keep whatever the ground."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import rollgait as rg
from rollgait.dynamics.ground import FootGround
from rollgait.footing.on_terrain import find_ways, regions_for
from rollgait.terrain import WheelSurface

Array = NDArray[np.float64]

KERB = {
    "robot": "centauro",
    "goal": {"x": 2.2},
    "horizon": 10.0,
    "gait": {
        "kind": "schedule",
        "FL": [[1.1, 2.1]],
        "FR": [[2.5, 3.5]],
        "HL": [[4.5, 5.5]],
        "HR": [[5.9, 6.9]],
    },
    "ground": {"parts": [{"kind": "step", "x": 0.9, "height": 0.15}]},
}
RAMP = {
    "robot": "centauro",
    "goal": {"x": 2.2},
    "horizon": 7.0,
    "ground": {"parts": [{"kind": "ramp", "x": 0.8, "length": 4.0, "slope_deg": 12.0}]},
}
TASKS = {"kerb": KERB, "ramp": RAMP}
YAW = 0.7
"""rad, by which a world is turned."""


def turned(task: dict[str, Any]) -> rg.Scenario:
    """The same task in a world turned about the origin."""
    plain = rg.Scenario.from_dict(task)
    x, y = plain.goal.x * np.cos(YAW), plain.goal.x * np.sin(YAW)
    degrees = float(np.degrees(YAW))
    start, goal = {"yaw_deg": degrees}, {"x": float(x), "y": float(y), "yaw_deg": degrees}
    return rg.Scenario.from_dict({**task, "start": start, "goal": goal, "ground": plain.terrain.turned(YAW)})


@cache
def planned(name: str) -> rg.Plan:
    return rg.plan(rg.Scenario.from_dict(TASKS[name]), diagnose=False)


def surfaces(scenario: rg.Scenario) -> list[WheelSurface]:
    return [region.surface for region in regions_for(scenario)]


@pytest.mark.parametrize("name", TASKS)
def test_feet_stand_on_the_surface_of_their_wheels_and_swing_above_it(name: str) -> None:
    plan = planned(name)
    s = plan.sample(np.linspace(0.0, plan.horizon, 1001))
    for leg, surface in enumerate(surfaces(plan.scenario)):
        above = s.foot_position[:, leg, 2] - surface.height(*s.foot_position[:, leg, :2].T)
        stands = s.contact[:, leg]
        assert np.abs(above[stands]).max() < 1e-3
        assert above[~stands].min(initial=0.0) > -1e-3


@pytest.mark.parametrize("name", TASKS)
def test_a_foot_moves_as_its_velocity_says(name: str) -> None:
    plan, h = planned(name), 1e-5
    middles = plan.schedule.mesh.middles
    before, at, after = (plan.sample(middles + d) for d in (-h, 0.0, h))
    slope = (after.foot_position - before.foot_position) / (2.0 * h)
    np.testing.assert_allclose(at.foot_velocity, slope, atol=2e-4)


@pytest.mark.parametrize("name", TASKS)
def test_no_foot_jumps(name: str) -> None:
    plan, h = planned(name), 1e-7
    nodes = plan.schedule.node_times[1:-1]
    before, after = (plan.sample(nodes + d) for d in (-h, h))
    assert np.abs(after.foot_position - before.foot_position).max() < 5e-4  # where ground is fitted, it may


def test_a_turned_world_turns_the_plan() -> None:
    plan = planned("kerb")
    other = rg.plan(turned(KERB), diagnose=False)
    times = np.linspace(0.0, plan.horizon, 101)
    c, s = np.cos(YAW), np.sin(YAW)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(
        other.sample(times).com_position, plan.sample(times).com_position @ R.T, atol=2e-3
    )
    assert other.statistics.cost == pytest.approx(plan.statistics.cost, rel=1e-4)


def test_small_slopes_tend_to_the_flat_plan() -> None:
    flat = rg.plan(rg.Scenario.from_dict({**RAMP, "ground": {}}), diagnose=False)
    times = np.linspace(0.0, flat.horizon, 101)
    apart = []
    for degrees in (2.0, 0.02):
        ground = {"parts": [{"kind": "ramp", "x": -3.0, "length": 9.0, "slope_deg": degrees}]}
        ground["height"] = -3.0 * np.tan(np.radians(degrees))
        plan = rg.plan(rg.Scenario.from_dict({**RAMP, "ground": ground}), diagnose=False)
        apart.append(np.abs(plan.sample(times).com_position - flat.sample(times).com_position).max())
    assert apart[1] < 5e-3
    assert apart[1] < 0.2 * apart[0]


def test_a_finer_mesh_has_the_same_ground_at_the_same_times() -> None:
    scenario = rg.Scenario.from_dict(KERB)
    found = find_ways(scenario, scenario.schedule)
    finer = scenario.schedule.refined(np.arange(20, 40), 2)
    plan = planned("kerb")
    coarse = found.around(plan.sample(scenario.schedule.node_times))
    fine = found.on(finer).around(plan.sample(finer.node_times))
    k = scenario.schedule.mesh.interval_at(finer.mesh.middles)
    xy = plan.sample(finer.mesh.middles).foot_position[..., :2]
    np.testing.assert_allclose(fine.height(np.arange(fine.count), xy), coarse.height(k, xy), atol=1e-9)
    np.testing.assert_array_equal(fine.friction, coarse.friction[:, k])


def test_where_the_ground_changes_height_above_it_changes_by_as_much() -> None:
    scenario = rg.Scenario.from_dict(KERB)
    footing = find_ways(scenario, scenario.schedule).footing
    rng = np.random.default_rng(0)
    for leg in range(4):
        for k in range(footing.count - 1):
            p = rng.uniform(-1.0, 2.0, 2)
            here, there = (footing.foot_ground(leg, np.array([i])).height(p) for i in (k, k + 1))
            leave = FootGround([*footing.model[leg, k, :2], *footing.leave[leg, k]], [0.0, 0.0], 0.0).height(
                p
            )
            stays = scenario.schedule.contact[leg, k : k + 2].all()
            assert leave == pytest.approx(0.0 if stays else float(here[0] - there[0]), abs=1e-12)
