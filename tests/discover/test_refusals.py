"""A refusal is true: the named cause, removed by the stated amount, gives a certified plan."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest

import rollgait as rg
from rollgait.discover.refusals import up
from rollgait.errors import NotSolvedError
from tests.discover.worlds import Part, candidates, world

PATIENT = {"kind": "discover", "search": {"seconds": 600.0}}
HIGH = 0.42


def kerb(less: float) -> Part:
    return {"kind": "step", "x": 0.9, "height": HIGH - less}


def drop(less: float) -> Part:
    return {"kind": "step", "x": 0.9, "height": less - HIGH}


def pit(less: float) -> Part:
    return {"kind": "gap", "x": 1.0, "length": 0.9 - less}


def sentence(part: Part) -> str:
    with pytest.raises(NotSolvedError) as refused:
        candidates(world([part], {"x": 2.8}), 1)
    return str(refused.value)


def amount(text: str) -> float:
    found = re.search(r"(\d+\.\d\d) m more than", text)
    assert found is not None, text
    return float(found[1])


@pytest.mark.parametrize(
    ("made", "words"),
    [(kerb, "the ground rises by 0.42 m"), (drop, "the ground falls by 0.42 m"), (pit, "more than a step")],
)
def test_the_cause_is_named_and_without_it_there_is_a_gait(made: Callable[[float], Part], words: str) -> None:
    text = sentence(made(0.0))
    assert words in text
    more = amount(text)
    assert candidates(world([made(more)], {"x": 2.8}), 1)
    assert amount(sentence(made(more - 0.05))) == pytest.approx(0.05, abs=0.011)  # and not much less will do


@pytest.mark.slow
@pytest.mark.parametrize("made", [kerb, pit])
def test_without_the_cause_there_is_a_certified_plan(made: Callable[[float], Part]) -> None:
    more = amount(sentence(made(0.0)))
    plan = rg.plan(world([made(more)], {"x": 2.8}, gait=PATIENT))
    assert plan.certificate().passed


@pytest.mark.slow
def test_four_steep_stairs_are_climbed_with_the_margin() -> None:
    stairs = {"kind": "stairs", "x": 0.9, "steps": 4, "rise": 0.15, "tread": 0.32}
    plan = rg.plan(world([stairs], {"x": 3.01}, gait=PATIENT))
    certificate = plan.certificate()
    assert certificate.passed
    rows = {row.name: row for row in certificate.rows}
    assert rows["com_margin"].worst >= plan.scenario.bounds.com_margin - 1e-3
    swings = list(plan.schedule.swings())
    assert [sum(swing.leg == leg for swing in swings) for leg in range(4)] == [4, 4, 4, 4]
    end = plan.sample(np.array([plan.horizon]))
    np.testing.assert_allclose(end.foot_position[0, :, 2], 0.6, atol=1e-3)


def test_amounts_are_written_so_that_they_are_enough() -> None:
    assert up(0.111) == 0.12
    assert up(0.12) == 0.12
    assert up(0.1200000001) == 0.12
