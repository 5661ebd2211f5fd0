"""Plans for nearly the same are found, and serve as starts."""

from __future__ import annotations

import pytest

import rollgait as rg


def test_a_row_is_nearest_to_itself_and_distance_is_where_it_goes(library: rg.Dataset) -> None:
    scenario = library.scenario(1)
    (first, *others) = library.nearest(scenario, 5)
    assert first == (1, pytest.approx(0.0, abs=1e-9))
    assert len(others) == 4
    goal = scenario.goal
    for row, apart in others:
        other = library.scenario(row).goal
        assert apart == pytest.approx(((goal.x - other.x) ** 2 + (goal.y - other.y) ** 2) ** 0.5)
    assert [apart for _, apart in others] == sorted(apart for _, apart in others)
    assert library.nearest("hybrid-forward") == []  # another robot, another gait


def test_a_plan_nearby_is_a_start(library: rg.Dataset) -> None:
    scenario = library.scenario(1)
    (_, (row, _)) = library.nearest(scenario, 2)
    warm = rg.plan(scenario, warm_start=library.plan(row))
    assert warm.statistics.start == "warm start"
    assert warm.statistics.cost == pytest.approx(library.record(1)["cost"], rel=1e-3)
