"""Robots on fixed wheels that may slip: they turn by skidding, and drive; the first way is certified."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rollgait as rg
from rollgait.discover.proposers import PROPOSERS
from rollgait.discover.reserves import driving
from rollgait.discover.search import proposed
from rollgait.discover.skidding import skidding
from rollgait.errors import NotSolvedError
from rollgait.footing.pace import poses_of
from tests.skidding import robot

X, Y, YAW = st.floats(-1.5, 1.5), st.floats(-1.0, 1.0), st.floats(-90.0, 90.0)
NARROW = 0.002
"""m; of legs that move in planes."""


def planar(slip_max: float | None = 0.05) -> rg.Robot:
    """A robot whose legs give no way sideways."""
    data = robot(slip_max).model_dump(mode="json")
    data["box"][1] = NARROW
    for leg in data["legs"].values():
        leg["box"] = None
    return rg.Robot.model_validate(data)


def to(body: rg.Robot, x: float = 0.0, y: float = 0.0, yaw: float = 0.0, **more: Any) -> rg.Scenario:
    goal = {"x": x, "y": y, "yaw_deg": yaw}
    return rg.Scenario.from_dict({"robot": body, "goal": goal, "gait": "discover", **more})


def driven(scenario: rg.Scenario) -> rg.Scenario:
    assert scenario.gait.kind == "discover"
    return driving(scenario, scenario.gait)


@given(X, Y, YAW)
def test_all_ways_lead_to_the_goal_in_time(x: float, y: float, yaw: float) -> None:
    base = driven(to(planar(), x, y, yaw))
    scores = []
    for candidate in skidding(base):
        asked = candidate.of(base)
        np.testing.assert_allclose(poses_of(asked)[-1], [x, y, np.radians(yaw)], atol=1e-5)
        assert asked.schedule.contact.all()
        scores.append(candidate.score)
    assert scores
    assert scores == sorted(scores)


def test_who_may_not_slip_does_not_skid() -> None:
    assert not list(skidding(driven(to(planar(None), 0.5, 0.2, 30.0))))
    with pytest.raises(NotSolvedError, match="slip_max"):
        next(proposed(driven(to(planar(None), 0.5, 0.2, 30.0))))


def test_later_goals_are_waited_for() -> None:
    goal = {"x": 0.4, "then": [{"at": 30.0, "x": 0.4, "y": 0.0, "yaw_deg": 30.0}]}
    (first, *_) = skidding(driven(to(planar(), goal=goal)))
    assert float(str(first.values["horizon"])) > 30.0
    assert first.of(driven(to(planar(), goal=goal))).goal.then[0].at == pytest.approx(30.0)


def test_the_horizon_is_a_limit() -> None:
    assert skidding in PROPOSERS
    with pytest.raises(NotSolvedError, match=r"takes .* s, the horizon is 3 s"):
        list(skidding(driven(to(planar(), yaw=80.0, horizon=3.0))))


@pytest.mark.parametrize("goal", [(0.4, 0.2, 20.0), (0.0, 0.0, -70.0)])
def test_what_is_discovered_is_certified(goal: tuple[float, float, float]) -> None:
    plan = rg.plan(to(planar(), *goal))
    assert plan.certificate().passed
    (tried,) = plan.statistics.discovery
    assert tried.name.startswith("skids")
