"""A refusal is true: the named cause, removed by the stated amount, gives a certified plan."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import rollgait as rg
from rollgait.discover.refusals import up
from rollgait.errors import NotSolvedError
from rollgait.scenario import Scenario
from tests.discover.worlds import Part, candidates, world

PATIENT = {"kind": "discover", "search": {"seconds": 600.0}}
HIGH = 0.42


def kerb(less: float) -> Part:
    return {"kind": "step", "x": 0.9, "height": HIGH - less}


def drop(less: float) -> Part:
    return {"kind": "step", "x": 0.9, "height": less - HIGH}


def pit(less: float) -> Part:
    return {"kind": "gap", "x": 1.0, "length": 0.9 - less}


def thin(less: float) -> Part:
    return {"kind": "block", "x": 1.4, "length": 0.15, "width": 30.0, "height": HIGH - less}


def thick(less: float) -> Part:
    return {"kind": "block", "x": 1.4, "length": 0.6, "width": 30.0, "height": HIGH - less}


def opening(width: float, y: float = 0.0) -> list[Part]:
    """A wall across the way, open for some width about y."""
    sides = [y + side * (15.0 + 0.5 * width) for side in (1.0, -1.0)]
    wall = {"kind": "block", "x": 1.4, "length": 0.15, "width": 30.0, "height": 1.0}
    return [{**wall, "y": side} for side in sides]


def stairs(tread: float) -> Part:
    return {"kind": "stairs", "x": 0.9, "steps": 4, "rise": 0.15, "tread": tread}


def sentence(*parts: Part, x: float = 2.8) -> str:
    with pytest.raises(NotSolvedError) as refused:
        candidates(world(parts, {"x": x}), 1)
    return str(refused.value)


def on_map(folder: Path, unknown: float) -> Scenario:
    """Flat ground as a map that is unknown across the way from x = 1.3 m on, for some length (m)."""
    resolution = 0.05
    x = -3.0 + resolution * np.arange(161)
    heights = np.zeros((161, 121))
    heights[(x > 1.3 - 1e-9) & (x < 1.3 + unknown - 1e-9)] = np.nan
    np.save(folder / "map.npy", heights)
    ground = {"map": {"file": "map.npy", "resolution": resolution, "origin": [-3.0, -3.0]}}
    data = {"robot": "centauro", "goal": {"x": 2.8}, "gait": PATIENT, "ground": ground}
    return Scenario.from_dict(data, folder)


def amount(text: str) -> float:
    found = re.search(r"(\d+\.\d\d) m (?:more than|less than the robot)", text)
    assert found is not None, text
    return float(found[1])


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (kerb, "the ground rises by 0.42 m"),
        (drop, "the ground falls by 0.42 m"),
        (pit, "more than a step"),
        (thin, "more than a leg steps over"),
        (thick, "more than a leg steps over"),
    ],
)
def test_the_cause_is_named_and_without_it_there_is_a_gait(made: Callable[[float], Part], words: str) -> None:
    text = sentence(made(0.0))
    assert words in text
    more = amount(text)
    assert candidates(world([made(more)], {"x": 2.8}), 1)
    assert amount(sentence(made(more - 0.05))) == pytest.approx(0.05, abs=0.011)  # and not much less will do


@pytest.mark.slow
@pytest.mark.parametrize("made", [kerb, drop, pit, thin, thick])
def test_without_the_cause_there_is_a_certified_plan(made: Callable[[float], Part]) -> None:
    more = amount(sentence(made(0.0)))
    plan = rg.plan(world([made(more)], {"x": 2.8}, gait=PATIENT))
    assert plan.certificate().passed


@pytest.mark.parametrize(("width", "y"), [(0.6, 0.0), (0.6, 0.13), (0.75, -0.32)])
def test_an_opening_that_is_too_narrow_is_named_with_its_place_and_width(width: float, y: float) -> None:
    text = sentence(*opening(width, y))
    found = re.search(r"the opening at \[(.*), (.*)\] m is (\d\.\d\d) m wide", text)
    assert found is not None, text
    place = [float(found[1]), float(found[2])]
    np.testing.assert_allclose(place, [1.4, y], atol=0.1)
    assert float(found[3]) == pytest.approx(width, abs=0.021)
    more = amount(text)
    for middle in (y, y + 0.5 * more, y - 0.5 * more):  # wider to both sides, or to one alone
        assert candidates(world(opening(width + more, middle), {"x": 2.8}), 1)


def test_a_closed_wall_has_no_opening() -> None:
    assert "the opening" not in sentence(thick(-0.5))


@pytest.mark.slow
@pytest.mark.parametrize("y", [0.0, 0.13])
def test_through_an_opening_that_is_so_much_wider_there_is_a_certified_plan(y: float) -> None:
    more = amount(sentence(*opening(0.6, y)))
    plan = rg.plan(world(opening(0.6 + more, y), {"x": 2.8}, gait=PATIENT))
    assert plan.certificate().passed


def test_treads_are_to_be_long_enough_for_the_wheel_and_for_the_robot() -> None:
    two = {**stairs(0.17), "steps": 2}
    assert "shorter than the wheel needs" in sentence(two)
    assert "shorter than the robot needs" in sentence(stairs(0.17))


@pytest.mark.slow
def test_on_treads_that_are_so_much_longer_there_is_a_certified_plan() -> None:
    text = sentence(stairs(0.17))
    more = float(text.split("the tread is ")[1].split(" cm")[0]) / 100.0
    plan = rg.plan(world([stairs(0.17 + more)], {"x": 2.05 + 3 * (0.17 + more)}, gait=PATIENT))
    assert plan.certificate().passed


def test_unknown_ground_across_the_way_is_named_with_its_place(tmp_path: Path) -> None:
    length = 0.8
    with pytest.raises(NotSolvedError) as refused:
        candidates(on_map(tmp_path, length), 1)
    text = str(refused.value)
    assert "the ground there is not known" in text
    found = re.search(r"between x = (\d\.\d\d) and (\d\.\d\d) m", text)
    assert found is not None, text
    begins, ends = float(found[1]), float(found[2])
    assert begins == pytest.approx(1.3, abs=0.25)  # a wheel stops before it
    assert ends == pytest.approx(1.3 + length, abs=0.06)


@pytest.mark.slow
def test_where_the_ground_is_known_there_is_a_certified_plan(tmp_path: Path) -> None:
    assert rg.plan(on_map(tmp_path, 0.0)).certificate().passed


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
