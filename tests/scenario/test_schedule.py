"""Laws of gaits and of the contact schedule on the mesh."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rollgait.errors import InputError
from rollgait.robot import LEG_NAMES
from rollgait.scenario import Crawl, Drive, Mesh, Schedule
from rollgait.scenario.schedule import MIN_SWING_INTERVALS, ContactSchedule, intervals_of, put_on_mesh

horizons = st.floats(4.0, 30.0)
intervals = st.floats(0.02, 0.12)
steps = st.integers(1, 16)
fractions = st.floats(0.3, 1.0)


def tenths(count: int) -> Mesh:
    """Intervals of 0.1 s."""
    return Mesh.equal(0.1 * count, count)


def crawl_on_mesh(gait: Crawl, horizon: float, interval: float) -> ContactSchedule:
    """The schedule, where the mesh is fine enough for the swings."""
    slot = (horizon - gait.pause_start - gait.pause_end) / gait.steps
    assume(slot * gait.swing_fraction > (MIN_SWING_INTERVALS + 1.5) * interval)
    return put_on_mesh(gait, horizon, interval)


@given(horizon=horizons, interval=intervals, count=steps, fraction=fractions)
def test_a_crawl_has_its_steps_in_their_order(
    horizon: float, interval: float, count: int, fraction: float
) -> None:
    gait = Crawl(steps=count, swing_fraction=fraction)
    schedule = crawl_on_mesh(gait, horizon, interval)
    swings = sorted(schedule.swings(), key=lambda swing: swing.lift_off)
    assert [LEG_NAMES[s.leg] for s in swings] == [gait.order[k % 4] for k in range(count)]
    assert np.all((~schedule.contact).sum(axis=0) <= 1)  # one foot at a time
    for before, after in pairwise(swings):
        assert before.touch_down <= after.lift_off


@given(horizon=horizons, interval=intervals, count=steps, fraction=fractions)
def test_a_crawl_has_its_durations(horizon: float, interval: float, count: int, fraction: float) -> None:
    """Slots of one length, of which the middle part is swing; on the mesh to the nearest node."""
    gait = Crawl(steps=count, swing_fraction=fraction)
    slot = (horizon - 2.0) / count
    exact = sorted(swing for leg in gait.swings(horizon).values() for swing in leg)
    for k, (begin, end) in enumerate(exact):
        assert end - begin == pytest.approx(fraction * slot)
        assert 0.5 * (begin + end) == pytest.approx(1.0 + (k + 0.5) * slot)
    schedule = crawl_on_mesh(gait, horizon, interval)
    for swing, (begin, end) in zip(sorted(schedule.swings(), key=lambda s: s.lift_off), exact, strict=True):
        lift_off, touch_down = schedule.node_times[[swing.lift_off, swing.touch_down]]
        assert abs(lift_off - begin) <= 0.5 * schedule.lengths[0] + 1e-9
        assert abs(touch_down - end) <= 0.5 * schedule.lengths[0] + 1e-9


@given(horizon=horizons, interval=intervals, count=steps)
def test_every_leg_takes_its_share_of_the_steps(horizon: float, interval: float, count: int) -> None:
    legs = [swing.leg for swing in crawl_on_mesh(Crawl(steps=count), horizon, interval).swings()]
    taken = [legs.count(leg) for leg in range(4)]
    assert sum(taken) == count
    assert max(taken) - min(taken) <= 1


@given(horizon=st.floats(6.0, 20.0), interval=intervals, start=st.floats(0.0, 2.0), end=st.floats(0.0, 2.0))
def test_all_feet_are_down_in_the_pauses(horizon: float, interval: float, start: float, end: float) -> None:
    schedule = crawl_on_mesh(Crawl(steps=4, pause_start=start, pause_end=end), horizon, interval)
    begins, ends = schedule.node_times[:-1], schedule.node_times[1:]
    assert schedule.contact[:, ends <= start].all()
    assert schedule.contact[:, begins >= horizon - end].all()


def test_the_papers_crawl() -> None:
    schedule = put_on_mesh(Crawl(), 10.0, 0.1)
    swings = sorted(schedule.swings(), key=lambda s: s.lift_off)
    assert [LEG_NAMES[s.leg] for s in swings] == ["HR", "FR", "HL", "FL"] * 2
    assert [(s.lift_off, s.touch_down) for s in swings] == [(11 + 10 * k, 19 + 10 * k) for k in range(8)]


@given(horizon=horizons, interval=intervals)
def test_driving_never_lifts_a_foot(horizon: float, interval: float) -> None:
    schedule = put_on_mesh(Drive(), horizon, interval)
    assert schedule.contact.all()
    assert schedule.node_contact.all()
    assert not list(schedule.swings())


@given(horizon=horizons, interval=intervals)
def test_the_mesh_fills_the_horizon_with_about_the_asked_interval(horizon: float, interval: float) -> None:
    schedule = put_on_mesh(Drive(), horizon, interval)
    assert schedule.horizon == pytest.approx(horizon)
    assert schedule.intervals == intervals_of(horizon, interval)
    assert schedule.mesh.is_equal
    assert abs(schedule.lengths[0] - interval) <= 0.5 * interval / schedule.intervals + 1e-9


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 40))
def test_swings_tell_the_whole_contact(seed: int, count: int) -> None:
    contact = np.random.default_rng(seed).random((4, count)) < 0.6
    schedule = ContactSchedule(contact, tenths(contact.shape[1]))
    again = np.ones_like(contact)
    for swing in schedule.swings():
        again[swing.leg, swing.lift_off : swing.touch_down] = False
        assert swing.lift_off <= swing.middle < swing.touch_down or swing.touch_down - swing.lift_off == 1
    np.testing.assert_array_equal(again, contact)


@given(lift_off=st.integers(0, 50), length=st.integers(MIN_SWING_INTERVALS, 30))
def test_the_middle_is_inside_the_swing(lift_off: int, length: int) -> None:
    contact = np.ones((4, 100), dtype=bool)
    contact[2, lift_off : lift_off + length] = False
    (swing,) = ContactSchedule(contact, tenths(contact.shape[1])).swings()
    assert lift_off < swing.middle < swing.touch_down
    assert abs(swing.middle - (lift_off + 0.5 * length)) <= 0.5


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 40))
def test_a_node_is_on_the_ground_where_an_interval_beside_it_is(seed: int, count: int) -> None:
    contact = np.random.default_rng(seed).random((4, count)) < 0.6
    at_nodes = ContactSchedule(contact, tenths(contact.shape[1])).node_contact
    assert at_nodes.shape == (4, count + 1)
    for node in range(count + 1):
        beside = [k for k in (node - 1, node) if 0 <= k < count]
        np.testing.assert_array_equal(at_nodes[:, node], contact[:, beside].any(axis=1))


@given(horizon=horizons, interval=intervals, count=steps)
def test_spelling_a_crawl_out_changes_nothing(horizon: float, interval: float, count: int) -> None:
    gait = Crawl(steps=count)
    schedule = crawl_on_mesh(gait, horizon, interval)
    spelled_out = put_on_mesh(Schedule(**gait.swings(horizon)), horizon, interval)
    np.testing.assert_array_equal(spelled_out.contact, schedule.contact)


@given(horizon=st.floats(2.0, 20.0), count=st.integers(1, 200))
def test_an_interval_that_divides_the_horizon_is_kept(horizon: float, count: int) -> None:
    assert put_on_mesh(Drive(), horizon, horizon / count).intervals == count


@pytest.mark.parametrize(
    ("gait", "horizon", "interval", "field", "rule"),
    [
        (Drive(), 1.0, 2.0, "interval", "must not be longer than the horizon of 1.0 s"),
        (Drive(), 1.0, 1e-9, "interval", "must cut the horizon of 1.0 s into at most"),
        (Crawl(), 2.0, 0.1, "gait", "needs a horizon longer than its two pauses"),
        (Crawl(steps=80), 10.0, 0.1, "gait.FL", "must last at least 2 intervals of 0.1 s"),
        (Schedule(FL=((1.0, 1.1),)), 5.0, 0.1, "gait.FL", "must last at least 2 intervals"),
        (Schedule(HR=((4.0, 5.5),)), 5.0, 0.1, "gait.HR", "must touch down within the horizon of 5.0 s"),
        (
            Schedule(FL=((1.0, 2.0),), FR=((1.5, 2.5),), HL=((1.7, 3.0),), HR=((0.5, 1.9),)),
            5.0,
            0.1,
            "gait",
            "has all four feet in the air",
        ),
    ],
)
def test_what_does_not_fit_the_mesh(
    gait: Any, horizon: float, interval: float, field: str, rule: str
) -> None:
    with pytest.raises(InputError, match=rule) as caught:
        put_on_mesh(gait, horizon, interval)
    assert caught.value.field == field
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("data", "rule"),
    [
        ({"FL": [[2.0, 1.0]]}, "before it touches down"),
        ({"FL": [[-2.0, -1.0]]}, "touch down after t = 0"),
        ({"FL": [[1.0, 2.0], [1.5, 3.0]]}, "in order and apart"),
        ({"FL": [[1.0, "two"]]}, "must be a number"),
        ({"LF": [[1.0, 2.0]]}, "LF"),
        ({"clearance": -0.1}, "must be greater than 0"),
    ],
)
def test_what_is_no_schedule(data: dict[str, Any], rule: str) -> None:
    with pytest.raises(InputError, match=rule) as caught:
        Schedule(**data)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("data", "rule"),
    [
        ({"order": []}, "must name at least one leg"),
        ({"order": ["FL", "LF"]}, "FL"),
        ({"order": ["FL", "FL", "HL", "HR"]}, "once, and names FL twice; valid: FL, FR, HL, HR"),
        ({"steps": 0}, "1"),
        ({"steps": 2.5}, "whole number"),
        ({"swing_fraction": 0.0}, "0"),
        ({"swing_fraction": 1.5}, "1"),
        ({"pause_end": -1.0}, "must not be negative"),
    ],
)
def test_what_is_no_crawl(data: dict[str, Any], rule: str) -> None:
    with pytest.raises(InputError, match=rule) as caught:
        Crawl(**data)
    assert "\n" not in str(caught.value)
