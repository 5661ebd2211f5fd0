"""Laws of the gait that takes the steps its ground asks for."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rollgait.discover.serial import stepping_gait
from rollgait.discover.timing import SHIFT, SWING, Pace
from rollgait.scenario import Scenario

STEP = {"kind": "step", "x": 0.9, "height": 0.15}
STAIRS = {"kind": "stairs", "x": 0.9, "steps": 2, "rise": 0.1, "tread": 0.4}
GAP = {"kind": "gap", "x": 0.9, "length": 0.3}
RAMP = {"kind": "ramp", "x": 0.8, "length": 4.0, "slope_deg": 12.0}


def driving(parts: list[dict[str, object]], goal: float = 2.4, **more: object) -> Scenario:
    data = {"robot": "centauro", "goal": {"x": goal}, "horizon": 60.0, "gait": {"kind": "drive"}}
    return Scenario.from_dict({**data, "ground": {"parts": parts}, **more})


@pytest.mark.parametrize(("part", "edges"), [(STEP, 1), (STAIRS, 2), (GAP, 1), (RAMP, 0)])
def test_each_foot_steps_once_over_each_edge(part: dict[str, object], edges: int) -> None:
    schedule = stepping_gait(driving([part])).schedule
    assert [sum(swing.leg == leg for swing in schedule.swings()) for leg in range(4)] == 4 * [edges]


@pytest.mark.parametrize("part", [STEP, STAIRS, GAP])
def test_one_foot_at_a_time_with_time_to_shift_between(part: dict[str, object]) -> None:
    scenario = stepping_gait(driving([part]))
    swings = sorted(s for legs in scenario.gait.swings(scenario.horizon).values() for s in legs)
    assert all(end - begin == pytest.approx(SWING) for begin, end in swings)
    assert all(later[0] - earlier[1] >= SHIFT - 1e-5 for earlier, later in pairwise(swings))
    assert swings[-1][1] < scenario.horizon


@given(st.floats(0.9, 1.6), st.sampled_from([-0.2, 0.1, 0.25]))
@settings(max_examples=8)
def test_no_step_where_no_foot_comes_to_an_edge(x: float, height: float) -> None:
    """Far from the goal it drives, and a farther edge makes nothing earlier."""
    there = [{"kind": "step", "x": x, "height": height}]
    assert stepping_gait(driving(there, goal=0.1)).gait.kind == "drive"
    near, far = (stepping_gait(driving([{**there[0], "x": place}])) for place in (x, x + 0.1))
    first = [
        min(s[0] for legs in scenario.gait.swings(scenario.horizon).values() for s in legs)
        for scenario in (near, far)
    ]
    assert first[1] >= first[0] - 1e-6


def test_a_slower_pace_takes_longer_and_the_rest_is_as_asked() -> None:
    asked = driving([STEP], interval=0.1)
    usual, slow = stepping_gait(asked), stepping_gait(asked, Pace(speed=0.2, swing=1.5))
    assert slow.horizon > usual.horizon
    np.testing.assert_array_equal(usual.ground.parts, asked.ground.parts)
    assert usual.with_values({"gait": "drive", "horizon": 60.0}) == asked
