"""The iterate of the controller moves on in time without losing anything."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollgait.mpc.iterate import Iterate
from rollgait.mpc.mpc import Mpc


@pytest.fixture(scope="module")
def empty(built: Mpc) -> Iterate:
    return Iterate(built._problem)


def fill(it: Iterate, line: bool, seed: int = 0) -> None:
    """Random numbers, or numbers that grow by the same step from node to node."""
    random = np.random.default_rng(seed)
    for rows in (it.states, it.inputs):
        rows[:] = random.normal(size=rows.shape)
        if line:
            rows[:] = rows[0] + np.arange(rows.shape[0])[:, None] * rows[1]
    it.previous[:] = random.normal(size=it.previous.shape)


@given(st.integers(0, 1000), st.integers(0, 4))
def test_a_shift_by_whole_intervals_moves_the_rows(empty: Iterate, seed: int, steps: int) -> None:
    fill(empty, line=False, seed=seed)
    states, inputs = empty.states.copy(), empty.inputs.copy()
    empty.shift(float(steps))
    np.testing.assert_allclose(empty.states[: states.shape[0] - steps], states[steps:])
    np.testing.assert_allclose(empty.inputs[: inputs.shape[0] - steps], inputs[steps:])
    np.testing.assert_allclose(
        empty.inputs[inputs.shape[0] - 1 - steps :], inputs[-1:] + 0 * inputs[: steps + 1]
    )


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_shifts_add_up_where_the_motion_is_a_line(empty: Iterate, a: float, b: float) -> None:
    fill(empty, line=True)
    empty.shift(a)
    empty.shift(b)
    twice = empty.states.copy()
    fill(empty, line=True)
    empty.shift(a + b)
    np.testing.assert_allclose(empty.states, twice, atol=1e-9)


def test_no_shift_changes_nothing_and_a_shift_by_far_stays_finite(empty: Iterate) -> None:
    fill(empty, line=False)
    states = empty.states.copy()
    empty.shift(0.0)
    np.testing.assert_array_equal(empty.states, states)
    empty.shift(1000.0)
    assert np.isfinite(empty.variables()).all()


@given(st.integers(0, 1000))
def test_variables_and_back(empty: Iterate, seed: int) -> None:
    fill(empty, line=False, seed=seed)
    states, inputs, w = empty.states.copy(), empty.inputs.copy(), empty.variables().copy()
    fill(empty, line=False, seed=seed + 1)
    empty.take(w)
    np.testing.assert_array_equal(empty.inputs, inputs)
    np.testing.assert_array_equal(empty.states[1:], states[1:])
