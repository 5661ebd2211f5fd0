"""Steps as a list: what changes keep, and that a gait comes back as it was."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise
from math import factorial

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollgait.discover.steps import (
    Steps,
    in_pairs,
    one_by_one,
    one_more,
    orders,
    steps_of,
    with_steps,
    without,
)
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario import Scenario, find_scenario

CRAWL = find_scenario("hybrid-forward")


def crawl(steps: int) -> Scenario:
    return CRAWL.with_values({"gait": {"kind": "crawl", "steps": steps, "clearance": 0.07}})


def feet(steps: Steps) -> Counter[str]:
    return Counter(leg for step in steps for leg in step.legs)


def are_apart(steps: Steps) -> bool:
    """Whether each foot lands before it lifts off again."""
    times = {leg: [t for s in steps if leg in s.legs for t in (s.begin, s.end)] for leg in LEG_NAMES}
    return all(all(a < b for a, b in pairwise(t)) for t in times.values())


@given(st.integers(1, 12), st.sampled_from(["crawl", "trot", "pace"]))
def test_a_gait_comes_back_from_its_steps(count: int, kind: str) -> None:
    given_gait = CRAWL.with_values({"gait": {"kind": kind, "steps": count}})
    again = with_steps(given_gait, steps_of(given_gait))
    assert steps_of(again) == steps_of(given_gait)
    assert again.gait.clearance == given_gait.gait.clearance
    assert again.horizon == given_gait.horizon


def test_no_step_is_driving() -> None:
    assert with_steps(CRAWL, ()).gait.kind == "drive"
    assert steps_of(with_steps(CRAWL, ())) == ()


@given(st.integers(1, 8), st.data())
def test_what_is_left_out_is_one_step(count: int, data: st.DataObject) -> None:
    steps = steps_of(crawl(count))
    number = data.draw(st.integers(0, count - 1))
    assert set(steps) - set(without(steps, number)) == {steps[number]}


@given(st.integers(1, 8))
def test_one_more_step_has_room(count: int) -> None:
    steps = steps_of(crawl(count))
    more = one_more(steps, CRAWL.horizon)
    (added,) = set(more) - set(steps)
    assert len(added.legs) == 1
    assert all(added.end < step.begin or added.begin > step.end for step in steps)
    assert are_apart(more)


def test_where_there_is_no_room_none_is_put_in() -> None:
    packed = CRAWL.with_values(
        {"gait": {"kind": "crawl", "steps": 8, "pause_start": 0.1, "pause_end": 0.1, "swing_fraction": 1.0}}
    )
    assert one_more(steps_of(packed), packed.horizon) == ()


@pytest.mark.parametrize(("count", "expected"), [(1, 0), (2, 1), (3, 5), (4, factorial(4) - 1)])
def test_orders_are_all_orders(count: int, expected: int) -> None:
    steps = steps_of(crawl(count))
    found = list(orders(steps))
    assert len(found) == len(set(found)) == expected
    for other in found:
        assert feet(other) == feet(steps)
        assert [(s.begin, s.end) for s in other] == [(s.begin, s.end) for s in steps]


@given(st.integers(5, 6))
def test_no_order_has_a_foot_twice_in_a_row(count: int) -> None:
    found = list(orders(steps_of(crawl(count))))
    assert found
    assert all(are_apart(steps) for steps in found)
    assert all(a.legs != b.legs for steps in found for a, b in pairwise(steps))


@given(st.integers(1, 12))
def test_pairs_take_no_longer_and_come_apart_again(count: int) -> None:
    steps = steps_of(crawl(count))
    pairs = in_pairs(steps)
    assert sum(feet(pairs).values()) == count + count % 2
    assert pairs[0].begin >= steps[0].begin - 1e-6
    assert pairs[-1].end <= steps[-1].end + 1e-6
    assert are_apart(pairs)
    assert in_pairs(pairs) == ()
    single = one_by_one(pairs, CRAWL.horizon)
    assert feet(single) == feet(pairs)
    assert are_apart(single)
    assert one_by_one(single, CRAWL.horizon) == ()
