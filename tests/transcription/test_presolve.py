"""The presolve propagates what is known; here it is held against looking at every row again and again."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from rollgait.transcription import TRANSCRIPTION_NAMES, transcribe
from rollgait.transcription.code import RowGroup, StageCode
from rollgait.transcription.nlp import Block
from rollgait.transcription.presolve import FIXED_TOLERANCE, Presolve
from rollgait.transcription.stage import Stage
from tests.transcription.problems import CASES, problem_of

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass
class Known:
    """What looking at every row again and again finds."""

    low: Array
    high: Array
    kept: list[Mask]
    rounds: int


def round_by_round(blocks: list[Block], rows: list[Mask], total: int, initial: Array) -> Known:
    """All rows of one free variable, linear in it, are bounds; again, until there is none."""
    low, high = np.full(total, -np.inf), np.full(total, np.inf)
    low[: initial.size] = high[: initial.size] = initial
    kept, rounds = [mask.copy() for mask in rows], 0
    slopes = [_slopes(block) for block in blocks]
    while True:
        rounds += 1
        fixed = high - low <= FIXED_TOLERANCE
        known = np.zeros(total + 1)
        known[:-1][fixed] = 0.5 * (low[fixed] + high[fixed])
        free, found = np.append(~fixed, False), []
        for block, keep, slope in zip(blocks, kept, slopes, strict=True):
            f, stage = block.function, block.stage
            for k in range(stage.count):
                reads = free[block.variables[f.jacobian_cols, k]] & (slope[:, k] != 0.0)
                values = np.asarray(f.value(known[block.variables[:, k]], stage.parameters[:, k])[1]).ravel()
                for row in np.flatnonzero(keep[:, k]):
                    entries = np.flatnonzero(reads & (f.jacobian_rows == row))
                    if entries.size == 1 and f.linear[entries[0]]:
                        limits = np.array([stage.lower[row, k], stage.upper[row, k]])
                        ends = (limits - values[row]) / slope[entries[0], k]
                        ends = ends if slope[entries[0], k] > 0.0 else ends[::-1]
                        found.append((block.variables[f.jacobian_cols[entries[0]], k], *ends))
                        keep[row, k] = False
        for variable, lower, upper in found:
            low[variable], high[variable] = max(low[variable], lower), min(high[variable], upper)
        if not found:
            break
    for block, keep, slope in zip(blocks, kept, slopes, strict=True):
        f = block.function
        reads = free[block.variables[f.jacobian_cols]] & (slope != 0.0)
        for row, k in zip(*np.nonzero(keep), strict=True):
            keep[row, k] = reads[f.jacobian_rows == row, k].any()
    return Known(low, high, kept, rounds)


def _slopes(block: Block) -> Array:
    place = np.random.default_rng(1).uniform(0.5, 1.5, block.variables.shape[0])
    columns = [np.asarray(block.function.jacobian(place, p)).ravel() for p in block.stage.parameters.T]
    return np.stack(columns, axis=1)


def assert_same(found: Presolve, known: Known) -> None:
    np.testing.assert_array_equal(found.low, known.low)
    np.testing.assert_array_equal(found.high, known.high)
    for here, there in zip(found.kept, known.kept, strict=True):
        np.testing.assert_array_equal(here, there)


def limited(block: Block) -> Mask:
    stage = block.stage
    return np.asarray(stage.holds & (np.isfinite(stage.lower) | np.isfinite(stage.upper)))


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("name", TRANSCRIPTION_NAMES)
def test_problems_are_presolved_as_round_by_round(name: str, case: str) -> None:
    nlp = transcribe(name, problem_of(case)).nlp
    blocks, rows = list(nlp.blocks), [limited(block) for block in nlp.blocks]
    initial = nlp.constants[: nlp.free[0]]  # the beginning of the state from which the motion starts
    known = round_by_round(blocks, rows, nlp.total, initial)
    assert known.rounds > 2, "something follows from something"
    assert_same(Presolve(blocks, rows, nlp.total, initial), known)


# -- chains --------------------------------------------------------------------------------------------------


@lru_cache
def code_of_chains(bend: float) -> StageCode:
    y, p = ca.SX.sym("y", 3), ca.SX.sym("p")
    rows = ca.vertcat(y[2] - p * y[0] - y[1], y[1] + bend * y[0] ** 2)
    jacobian = ca.jacobian(rows, y)
    row, column = (np.array(part, dtype=np.intp) for part in jacobian.sparsity().get_triplet())
    nothing = ca.Function("nothing", [y, p], [0])
    return StageCode(
        value=ca.Function("value", [y, p], [0, rows]),
        gradient=nothing,
        jacobian=ca.Function("jacobian", [y, p], [jacobian.nz[:]]),
        hessian=nothing,
        costs=nothing,
        jacobian_rows=row,
        jacobian_cols=column,
        hessian_rows=row[:0],
        hessian_cols=row[:0],
        linear=~np.array(ca.which_depends(jacobian.nz[:], y, 1, True), dtype=bool),
        parameters=(("slope", 1),),
        groups=(RowGroup("rows", "rows", None, "", "", False, 2),),
        cost_names=(),
    )


def chain(slopes: Array, limits: Array, bend: float) -> Block:
    """x_(k + 1) = a_k x_k + u_k, l_k ≤ u_k (+ bend x_k²) ≤ h_k; variables x_0 u_0 x_1 u_1 … x_N."""
    count = slopes.size
    zero = np.zeros(count)
    stage = Stage(
        code_of_chains(bend),
        slopes[None, :],
        np.stack([zero, limits[0]]),
        np.stack([zero, limits[1]]),
        np.ones((2, count), dtype=bool),
        1.0,
    )
    return Block(stage, 2 * np.arange(count) + np.arange(3)[:, None])


@settings(max_examples=40, deadline=None)
@given(data=st.data(), count=st.integers(1, 12), bend=st.sampled_from([0.0, 0.3]))
def test_chains_are_presolved_as_round_by_round(data: st.DataObject, count: int, bend: float) -> None:
    """Inputs that are fixed, bounded, free or asked for what cannot be, in any order."""
    number = st.sampled_from([-1.0, 0.0, 0.5, 2.0])
    limit = st.sampled_from([(0.25, 0.25), (-1.0, 1.0), (-np.inf, 2.0), (-np.inf, np.inf), (1.0, -1.0)])
    slopes = np.array(data.draw(st.lists(number, min_size=count, max_size=count)))
    limits = np.array(data.draw(st.lists(limit, min_size=count, max_size=count))).T
    initial = np.array(data.draw(st.lists(number, max_size=1)))
    block = chain(slopes, limits, bend)
    rows, total = [limited(block)], 2 * count + 1
    assert_same(Presolve([block], rows, total, initial), round_by_round([block], rows, total, initial))


def test_a_chain_of_any_length_is_followed_to_its_end() -> None:
    count = 400
    limits = np.full((2, count), 0.5)
    found = Presolve(
        [chain(np.ones(count), limits, 0.1)], [np.ones((2, count), dtype=bool)], 801, np.zeros(1)
    )
    u, x = 0.5, 0.0
    for k in range(count):
        assert found.low[2 * k] == pytest.approx(x, rel=1e-9)
        u = 0.5 - 0.1 * x**2
        x += u
    assert not found.kept[0].any()
    assert not found.contradictions


def test_limits_that_cross_are_told_with_their_place() -> None:
    limits = np.array([[0.0, 2.0, 0.0], [1.0, 1.0, 1.0]])
    found = Presolve([chain(np.ones(3), limits, 0.0)], [np.ones((2, 3), dtype=bool)], 7, np.empty(0))
    assert [item[:3] for item in found.contradictions] == [(0, 1, 1)]
    assert found.contradictions[0][3] == pytest.approx(1.0)
