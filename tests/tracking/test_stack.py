"""Strict priorities: laws that hold for any tasks."""

import numpy as np
import pytest

pytest.importorskip("daqp", reason="needs the extra whole-body")
pytest.importorskip("piqp", reason="needs the extra whole-body")

from hypothesis import given, settings
from hypothesis import strategies as st

from rollgait.tracking import stack

N = 9
UNLIMITED = np.full(N, np.inf)
seeds = st.integers(0, 10_000)


def levels(rng: np.random.Generator, *rows: int) -> list[stack.Level]:
    return [(rng.normal(size=(m, N)), rng.normal(size=m)) for m in rows]


def residuals(found: list[stack.Level], x: np.ndarray) -> np.ndarray:
    return np.array([np.linalg.norm(A @ x - b) for A, b in found])


@given(seeds)
def test_an_upper_level_is_served_as_if_it_were_alone(seed: int) -> None:
    rng = np.random.default_rng(seed)
    both = levels(rng, 4, 8)  # 12 rows in 9 unknowns: they conflict
    alone = stack.solve(both[:1], -UNLIMITED, UNLIMITED).x
    x = stack.solve(both, -UNLIMITED, UNLIMITED).x
    assert np.allclose(both[0][0] @ x, both[0][0] @ alone, atol=1e-9)
    assert residuals(both, x)[1] > 1e-6


@settings(max_examples=30)
@given(seeds)
def test_a_lower_level_never_moves_a_higher_one_under_bounds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    found, bound = levels(rng, 3, 4, 5), np.full(N, 0.4)
    for count in (1, 2):
        upper = stack.solve(found[:count], -bound, bound).x
        x = stack.solve(found, -bound, bound).x
        for A, _ in found[:count]:
            assert np.allclose(A @ x, A @ upper, atol=1e-5)


@settings(max_examples=30)
@given(seeds)
def test_bounds_hold(seed: int) -> None:
    rng = np.random.default_rng(seed)
    lower, upper = -rng.uniform(0.0, 0.5, N), rng.uniform(0.0, 0.5, N)
    step = stack.solve(levels(rng, 4, 6), lower, upper)
    assert not step.failed
    assert np.all(step.x >= lower - 1e-9)
    assert np.all(step.x <= upper + 1e-9)


@settings(max_examples=30)
@given(seeds)
def test_programs_find_what_decompositions_find(seed: int) -> None:
    rng = np.random.default_rng(seed)
    found = levels(rng, 3, 3, N)
    wide = np.full(N, 100.0)
    assert np.allclose(stack._bounded(found, -wide, wide).x, stack._unbounded(found, N), atol=1e-5)


def test_conflicting_tasks_follow_their_order() -> None:
    first, second = (np.eye(N)[:1], np.ones(1)), (np.eye(N)[:1], -np.ones(1))
    assert stack.solve([first, second], -UNLIMITED, UNLIMITED).x[0] == pytest.approx(1.0)
    assert stack.solve([second, first], -UNLIMITED, UNLIMITED).x[0] == pytest.approx(-1.0)


def test_rows_that_say_the_same_twice_do_no_harm() -> None:
    A = np.vstack([np.eye(N)[:2], np.eye(N)[:2]])
    step = stack.solve([(A, np.ones(4)), (np.eye(N), np.full(N, 2.0))], -UNLIMITED, UNLIMITED)
    assert np.allclose(step.x, [1.0, 1.0] + [2.0] * (N - 2))


@pytest.mark.parametrize("solver", [stack._daqp, stack._piqp])
def test_both_solvers_find_the_minimum(solver) -> None:
    rng = np.random.default_rng(1)
    A = rng.normal(size=(5, 4))
    H, f, C, bound = A.T @ A, rng.normal(size=4), np.eye(4), np.full(4, 0.2)
    y = solver(H, f, C, -bound, bound)
    # the gradient pushes outward exactly where a bound holds it
    gradient = H @ y + f
    assert np.all(np.abs(y) <= 0.2 + 1e-6)
    free = np.abs(y) < 0.2 - 1e-5
    assert np.allclose(gradient[free], 0.0, atol=1e-5)
    assert np.all(gradient[~free] * y[~free] <= 1e-6)


def test_a_level_that_no_solver_serves_falls_back() -> None:
    nan = (np.full((2, N), 1e200), np.full(2, 1e200))
    bound = np.full(N, 0.1)
    with np.errstate(all="ignore"):
        step = stack._bounded([(np.eye(N)[:1], np.ones(1)), nan], -bound, bound)
    assert step.failed == (1,)
    assert step.x[0] == pytest.approx(0.1)
