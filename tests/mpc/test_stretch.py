"""Deadlines count in simulated time: how a loop finds out how slowly that goes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollgait.mpc.stretch import STRETCH_MAX, Stretch

PERIOD = 0.01


def after(seconds: list[float]) -> float:
    """The factor after periods that took so long."""
    now = iter([0.0, *(sum(seconds[: k + 1]) for k in range(len(seconds)))])
    stretch = Stretch(PERIOD, lambda: next(now))
    for _ in range(len(seconds) + 1):
        factor = stretch.update()
    return factor


@given(st.floats(0.0, 1e6))
def test_a_steady_pace_is_found(factor: float) -> None:
    found = after([factor * PERIOD] * 500)
    assert found == pytest.approx(min(max(factor, 1.0), STRETCH_MAX), rel=1e-2)


@given(st.lists(st.floats(0.0, 10.0), max_size=20))
def test_time_never_shrinks(seconds: list[float]) -> None:
    assert 1.0 <= after(seconds) <= STRETCH_MAX


def test_one_hiccup_is_soon_forgotten() -> None:
    assert after([PERIOD] * 100 + [1.0] + [PERIOD] * 500) == pytest.approx(1.0, abs=1e-2)
