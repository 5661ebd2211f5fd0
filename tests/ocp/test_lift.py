"""Laws of the smooth lift."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rollgait.ocp.lift import lift, minimum_jerk
from rollgait.scenario.gait import Crawl, Schedule
from rollgait.scenario.schedule import put_on_mesh

CLEARANCE = 0.08
GAIT = Schedule(FL=((0.4, 1.0),), HR=((0.3, 0.6), (1.2, 1.9)))
SCHEDULE = put_on_mesh(GAIT, 2.0, 0.1)


@given(st.floats(-1.0, 2.0))
def test_minimum_jerk_rises_from_0_to_1_and_is_symmetric(s: float) -> None:
    (value, mirrored), (slope, _) = minimum_jerk(np.array([s, 1.0 - s]))
    assert 0.0 <= value <= 1.0
    assert slope >= 0.0
    np.testing.assert_allclose(value + mirrored, 1.0, atol=1e-12)


def test_minimum_jerk_begins_and_ends_at_rest() -> None:
    np.testing.assert_array_equal(minimum_jerk(np.array([-1.0, 0.0]))[0], 0.0)
    np.testing.assert_array_equal(minimum_jerk(np.array([1.0, 3.0]))[0], 1.0)
    np.testing.assert_array_equal(minimum_jerk(np.array([-1.0, 0.0, 1.0, 2.0]))[1], 0.0)


def test_rate_is_the_derivative_of_the_height() -> None:
    times, step = np.linspace(0.01, 1.99, 397), 1e-6
    difference = (lift(SCHEDULE, CLEARANCE, times + step)[0] - lift(SCHEDULE, CLEARANCE, times - step)[0]) / (
        2 * step
    )
    np.testing.assert_allclose(lift(SCHEDULE, CLEARANCE, times)[1], difference, atol=1e-4)


def test_feet_are_up_only_in_swing_and_highest_at_its_middle_node() -> None:
    times = np.linspace(0.0, 2.0, 401)
    height, rate = lift(SCHEDULE, CLEARANCE, times)
    assert height.min() >= 0.0
    assert height.max() <= CLEARANCE + 1e-12
    in_air = np.zeros_like(height, dtype=bool)
    for swing in SCHEDULE.swings():
        in_air[:, swing.leg] |= (times > swing.lift_off * 0.1 + 1e-9) & (
            times < swing.touch_down * 0.1 - 1e-9
        )
        (top,), (still,) = lift(SCHEDULE, CLEARANCE, np.array([swing.middle * 0.1]))
        np.testing.assert_allclose([top[swing.leg], still[swing.leg]], [CLEARANCE, 0.0], atol=1e-12)
    np.testing.assert_allclose(height[~in_air], 0.0, atol=1e-12)
    np.testing.assert_allclose(rate[~in_air], 0.0, atol=1e-12)
    assert np.all(height[in_air] > 0.0)


@given(st.sets(st.integers(0, 19)), st.integers(2, 4))
def test_on_any_mesh_it_is_highest_at_a_node_and_at_rest_where_the_swing_ends(
    which: set[int], parts: int
) -> None:
    schedule = SCHEDULE.refined(list(which), parts)
    for swing in schedule.swings():
        begin, middle, end = schedule.node_times[[swing.lift_off, swing.middle, swing.touch_down]]
        height, rate = lift(schedule, CLEARANCE, np.array([begin, middle, end]))
        np.testing.assert_allclose(height[:, swing.leg], [0.0, CLEARANCE, 0.0], atol=1e-12)
        np.testing.assert_allclose(rate[:, swing.leg], 0.0, atol=1e-12)
        # cut intervals move the middle node by no more than the mesh is coarse
        assert abs(middle - 0.5 * (begin + end)) <= 0.5 * 0.1 + 1e-9


@given(st.integers(1, 12), st.floats(0.3, 1.0))
def test_each_lift_comes_down_again(steps: int, fraction: float) -> None:
    schedule = put_on_mesh(Crawl(steps=steps, swing_fraction=fraction), 10.0, 0.1)
    times = np.linspace(0.0, 10.0, 2001)
    height, rate = lift(schedule, CLEARANCE, times)
    np.testing.assert_allclose(height[[0, -1]], 0.0, atol=1e-12)
    np.testing.assert_allclose(np.trapezoid(rate, times, axis=0), 0.0, atol=1e-3)
