"""Estimators: trust is a share of the gap, a delay is made up for, noise has its size, messages get lost."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollgait.mpc.estimator import Blended, Delayed, Dropping, Noisy, Trust, Truth, corrected
from rollgait.plant.state import RobotState
from tests.mpc.builders import assert_equal, random_state, states

PERIOD = 0.01
shares = st.floats(0.0, 1.0)


@given(states, states)
def test_full_trust_is_the_measurement_and_none_is_the_expectation(
    measured: RobotState, expected: RobotState
) -> None:
    assert_equal(corrected(expected, expected, measured, Trust()), measured)
    nothing = corrected(expected, expected, measured, Trust(0.0, 0.0, 0.0))
    assert_equal(nothing, expected, but=("speed",))


@given(states, states, shares, shares)
def test_what_was_expected_needs_no_correction(
    expected: RobotState, base: RobotState, place: float, posture: float
) -> None:
    result = corrected(base, expected, expected, Trust(place, posture, 0.5))
    assert_equal(result, base, but=("speed",))


@given(states, st.floats(-0.2, 0.2), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_a_robot_that_slid_and_turned_as_a_whole_is_a_matter_of_place_alone(
    expected: RobotState, turn: float, x: float, y: float
) -> None:
    c, s = np.cos(turn), np.sin(turn)
    R, shift = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), np.array([x, y, 0.0])
    measured = replace(
        expected,
        com_position=R @ expected.com_position + shift,
        com_velocity=R @ expected.com_velocity,
        euler=expected.euler + np.array([turn, 0.0, 0.0]),
        foot_position=expected.foot_position @ R.T + shift,
        heading=expected.heading + turn,
    )
    followed = corrected(expected, expected, measured, Trust(place=1.0, posture=0.0, motion=0.0))
    assert_equal(followed, measured, atol=1e-9)
    ignored = corrected(expected, expected, measured, Trust(place=0.0, posture=1.0, motion=0.0))
    assert_equal(ignored, expected, atol=1e-9)


@given(states, st.integers(0, 5))
def test_the_age_of_a_message_is_made_up_for(start: RobotState, periods: int) -> None:
    estimator = Blended(Trust(), Delayed(periods), lag=periods)
    true, known = start, None
    for k in range(3 * periods + 5):
        expected = None if known is None else moved(known)
        known = estimator(true, expected)
        assert known is not None
        assert_equal(known, true, atol=1e-9)
        assert known.time == true.time
        true = moved(true).at(start.time + (k + 1) * PERIOD)


@given(states, st.integers(0, 6))
def test_a_push_is_known_of_when_its_message_comes_and_corrected_once(
    start: RobotState, periods: int
) -> None:
    estimator = Blended(Trust(), Delayed(periods), lag=periods)
    true, known, pushed = start, None, 7
    for k in range(30):
        if k == pushed:
            true = replace(true, com_position=true.com_position + np.array([0.05, 0.0, 0.0]))
        known = estimator(true, None if known is None else moved(known))
        assert known is not None
        error = np.abs(known.com_position - true.com_position).max()
        late = pushed <= k < pushed + periods
        np.testing.assert_allclose(error, 0.05 if late else 0.0, atol=1e-9)
        true = moved(true)


@given(shares)
def test_a_share_of_a_gap_that_stays_is_believed_again_and_again(share: float) -> None:
    estimator, true = Blended(Trust(share, share, share)), random_state(1)
    expected: RobotState | None = replace(true, com_position=true.com_position + np.array([0.0, 0.0, 0.1]))
    for k in range(1, 20):
        expected = estimator(true, expected)
        assert expected is not None
        gap = expected.com_position[2] - true.com_position[2]
        np.testing.assert_allclose(gap, 0.1 * (1.0 - share) ** k, atol=1e-12)


def test_noise_has_its_size_and_repeats_by_seed() -> None:
    true, noisy, again = random_state(2), Noisy(seed=5), Noisy(seed=5)
    drawn = [noisy(true, None) for _ in range(2000)]
    assert_equal(drawn[0], again(true, None))  # type: ignore[arg-type]
    for name, scale in (("com_position", noisy.position), ("euler", noisy.angle), ("euler_rate", noisy.rate)):
        gaps = np.array([getattr(state, name) - getattr(true, name) for state in drawn])
        np.testing.assert_allclose(gaps.std(), scale, rtol=0.1)
        assert abs(gaps.mean()) < 0.1 * scale


def test_messages_get_lost_where_they_shall() -> None:
    dropping = Dropping({1, 3, 4}, Truth())
    found = [dropping(random_state(0), None) is None for _ in range(6)]
    assert found == [False, True, False, True, True, False]


@pytest.mark.parametrize("lag", [0, 2])
def test_one_message_that_no_robot_sends_leaves_nothing_behind(lag: int) -> None:
    estimator, true = Blended(Trust(0.1, 0.02, 0.05), lag=lag), random_state(4)
    estimator(true, None)
    for k in range(12):
        off = 1e4 if k == 5 else 0.0
        seen = replace(true, com_position=true.com_position + np.array([off, 0.0, 0.0]))
        known = estimator(seen, true)  # the controller goes on with what it expected
        assert known is not None
        if k != 5:
            assert_equal(known, true, atol=1e-9)


def test_no_message_stays_none_and_numbers_that_are_none_pass_through() -> None:
    true = random_state(3)
    assert Blended(Trust(0.5, 0.5, 0.5), Dropping({0}, Truth()))(true, true) is None
    bad = replace(true, euler=np.array([np.nan, 0.0, 0.0]))
    seen = Blended(Trust(0.5, 0.5, 0.5))(bad, true)
    assert seen is not None
    assert not seen.is_finite()  # it is the controller that says so


def moved(state: RobotState) -> RobotState:
    """One period on, at constant velocity; the feet go with the CoM."""
    step = PERIOD * state.com_velocity
    return replace(
        state,
        time=state.time + PERIOD,
        com_position=state.com_position + step,
        foot_position=state.foot_position + step * [1.0, 1.0, 0.0],
    )
