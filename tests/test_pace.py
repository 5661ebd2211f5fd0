"""Real time: waits when it is early, makes small delays good, slows down instead of jumping."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollgait.pace import BACKLOG, Pace

PERIOD = 0.01


class Wall:
    """A clock on the wall that goes on while somebody works or sleeps."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        assert seconds >= 0.0
        self.now += seconds


def run(works: list[float]) -> tuple[float, Pace]:
    """Wall time of rounds that work so long, and the pace."""
    wall = Wall()
    pace = Pace(PERIOD, wall, wall.sleep)
    for work in works:
        wall.now += work
        pace.wait()
    return wall.now - 100.0, pace


def test_rounds_of_less_than_a_period_keep_the_time() -> None:
    seconds, pace = run([0.004] * 300)
    assert seconds == pytest.approx(3.0)
    assert pace.rate == pytest.approx(100.0)
    assert pace.factor == pytest.approx(1.0)


def test_a_small_delay_is_made_good() -> None:
    seconds, _ = run([0.004] * 100 + [BACKLOG] + [0.004] * 99)
    assert seconds == pytest.approx(2.0)


def test_a_long_delay_is_lost_and_not_made_good_in_a_jump() -> None:
    seconds, _ = run([0.004] * 100 + [2.0] + [0.004] * 99)
    assert seconds == pytest.approx(4.0 - BACKLOG - PERIOD, abs=PERIOD)


def test_who_cannot_keep_up_is_slow() -> None:
    seconds, pace = run([0.02] * 200)
    assert seconds == pytest.approx(4.0)
    assert pace.factor == pytest.approx(0.5)


@given(st.lists(st.floats(0.0, 0.1), min_size=2, max_size=100))
def test_time_never_goes_faster_than_the_wall_but_for_the_backlog(works: list[float]) -> None:
    seconds, _ = run(works)
    assert len(works) * PERIOD <= seconds + BACKLOG + 1e-9


def test_after_a_restart_nothing_is_made_good() -> None:
    wall = Wall()
    pace = Pace(PERIOD, wall, wall.sleep)
    wall.now += 5.0
    pace.restart()
    begin = wall.now
    for _ in range(10):
        pace.wait()
    assert wall.now - begin == pytest.approx(0.1)
