"""The gait in continuous time: no swing is ever cut, whatever is asked for and when."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rollgait.errors import UnknownNameError
from rollgait.mpc.clock import GaitClock
from rollgait.mpc.gaits import GAITS

STEP = 0.01
names = st.sampled_from(sorted(GAITS))
requests = st.lists(st.tuples(st.floats(0.0, 6.0), names), max_size=6)
moving = st.sampled_from([name for name, gait in GAITS.items() if gait.swing > 0.0])


def seen(first: str, asked: list[tuple[float, str]], duration: float = 10.0) -> tuple[np.ndarray, np.ndarray]:
    """Times and contacts as a controller sees them that asks in every period."""
    clock, waiting = GaitClock(first), sorted(asked)
    times, contacts = STEP * np.arange(round(duration / STEP)), []
    for time in times:
        while waiting and waiting[0][0] <= time:
            clock.request(waiting.pop(0)[1], time)
        clock.advance(time)
        contacts.append(clock.contact(time))
    return times, np.array(contacts)


def flights(contact: np.ndarray) -> list[int]:
    """Lengths of all swings of a leg that end, in periods."""
    change = np.diff(np.concatenate([[True], contact]).astype(int))
    begins, ends = np.flatnonzero(change == -1), np.flatnonzero(change == 1)
    return [end - begin for begin, end in zip(begins, ends, strict=False)]


@given(names, requests)
def test_every_swing_has_its_full_length_whatever_is_asked_for(first: str, asked: list) -> None:
    _, contacts = seen(first, asked)
    lengths = {round(gait.swing / STEP) for gait in GAITS.values()}
    for leg in range(4):
        for length in flights(contacts[:, leg]):
            assert min(abs(length - full) for full in lengths) <= 1


@given(moving, names, st.floats(0.0, 8.0), st.floats(0.0, 1.0))
def test_a_swing_that_has_begun_goes_on_as_it_was_planned(
    first: str, then: str, time: float, later: float
) -> None:
    clock = GaitClock(first)
    clock.advance(time)
    begun = [swing for swing in clock.swings(time, time + 1e-9) if swing.lift_off <= time]
    clock.request(then, time)
    assert all(swing in clock.swings(time, time + 5.0) for swing in begun)
    clock.request(first, time + later)
    assert all(swing in clock.swings(time, time + 5.0) for swing in begun if swing.touch_down > time + later)


@given(moving, names, st.floats(0.0, 8.0))
def test_what_has_not_begun_waits_until_the_weight_can_shift(first: str, then: str, time: float) -> None:
    clock = GaitClock(first)
    clock.request(then, time)
    new = [swing for swing in clock.swings(time, time + 20.0) if swing.lift_off > time]
    if then == first:
        return
    landed = max((s.touch_down for s in clock.swings(time, time + 1e-9)), default=time)
    assert all(swing.lift_off >= landed + 0.1 for swing in new)
    assert bool(new) == (GAITS[then].swing > 0.0)


@given(names, requests)
def test_a_leg_is_in_one_swing_at_a_time(first: str, asked: list) -> None:
    clock = GaitClock(first)
    for time, name in sorted(asked):
        clock.request(name, time)
        for leg in range(4):
            swings = sorted(
                (s.lift_off, s.touch_down) for s in clock.swings(time - 1.0, time + 12.0) if s.leg == leg
            )
            assert all(a[1] <= b[0] + 1e-9 for a, b in pairwise(swings))


@given(moving, st.floats(0.0, 5.0), st.floats(0.02, 0.3))
def test_the_share_of_stance_is_the_integral_of_the_contact(gait: str, begin: float, length: float) -> None:
    clock = GaitClock(gait)
    edges = begin + length * np.arange(11)
    share = clock.stance_share(edges)
    fine = 400
    middles = begin + length * (np.arange(10)[:, None] + (np.arange(fine) + 0.5) / fine)
    contact = np.array([[clock.contact(time) for time in row] for row in middles[:, ::10]])
    np.testing.assert_allclose(share, contact.mean(axis=1), atol=2.5 * 10 / fine)
    assert np.all((share >= 0.0) & (share <= 1.0))


@given(moving, names, st.floats(0.0, 6.0))
def test_the_lift_is_zero_in_stance_and_its_rate_is_its_derivative(
    first: str, then: str, time: float
) -> None:
    clock = GaitClock(first)
    clock.request(then, time)
    times = time + np.linspace(0.0, 4.0, 501)
    height, rate = clock.lift(times)
    contact = np.array([clock.contact(t) for t in times])
    assert np.all(height[contact] == 0.0)
    assert np.all(rate[contact] == 0.0)
    assert np.all(height >= 0.0)
    assert height.max() <= max(gait.clearance for gait in GAITS.values()) + 1e-12
    h = 1e-5
    before, after = clock.lift(times - h)[0], clock.lift(times + h)[0]
    inside = times > time + h
    np.testing.assert_allclose(((after - before) / (2 * h))[inside], rate[inside], atol=2e-3)


@given(moving, st.floats(0.0, 50.0))
def test_a_gait_repeats_itself(name: str, begin: float) -> None:
    clock, gait = GaitClock(name), GAITS[name]
    begin += 2.0 * gait.period
    times = begin + np.linspace(0.0, gait.period, 50)
    now, later = clock.lift(times)[0], clock.lift(times + gait.period)[0]
    np.testing.assert_allclose(now, later, atol=1e-6)


@given(names, names, st.lists(st.floats(0.0, 0.05), min_size=2, max_size=30))
def test_requests_in_quick_succession(a: str, b: str, gaps: list[float]) -> None:
    assume(a != b)
    clock, time = GaitClock(a), 3.0
    for number, gap in enumerate(gaps):
        time += gap
        clock.request(b if number % 2 == 0 else a, time)
    assert clock.gait == GAITS[b if len(gaps) % 2 else a]
    in_the_air = ~clock.contact(time)
    assert in_the_air.sum() <= 2
    landed = max((swing.touch_down for swing in clock.swings(time, time + 1e-9)), default=time)
    assert clock.contact(landed + 0.3).all()  # while the weight shifts


def test_asking_for_the_gait_that_is_changes_nothing() -> None:
    clock, same = GaitClock("crawl"), GaitClock("crawl")
    for time in (0.3, 1.1, 2.9):
        clock.request("crawl", time)
    assert clock.swings(0.0, 20.0) == same.swings(0.0, 20.0)


def test_an_unknown_gait_is_named_and_changes_nothing() -> None:
    clock = GaitClock("trot")
    before = clock.swings(0.0, 9.0)
    with pytest.raises(UnknownNameError, match=r"gallop.*valid: "):
        clock.request("gallop", 1.0)
    assert clock.swings(0.0, 9.0) == before


@pytest.mark.parametrize("name", sorted(GAITS))
def test_time_may_go_on_for_ever(name: str) -> None:
    clock = GaitClock(name)
    for hour in range(1, 20):
        clock.advance(3600.0 * hour)
        now = clock.swings(3600.0 * hour - 1.0, 3600.0 * hour + 1.0)
        assert len(now) <= 24
        assert len(clock._done) <= 3600.0 / max(GAITS[name].period, 1e-3) * 4 + 8
    for _ in range(1000):
        clock.advance(clock._time + 0.01)
    assert len(clock._done) <= 24


@given(names, st.floats(0.0, 8.0))
def test_locked_wheels_lock_when_they_have_braked(first: str, time: float) -> None:
    clock = GaitClock(first)
    clock.request("walk", time)
    clock.advance(time)
    if first != "walk":
        assert not clock.locked(time)
        assert clock.brakes
    swings = [swing for swing in clock.swings(time, time + 20.0) if swing.lift_off > time]
    assert all(clock.locked(swing.lift_off) for swing in swings)
    clock.request("drive", time + 10.0)
    assert not clock.locked(time + 10.0)
