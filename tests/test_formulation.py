"""docs/formulation.md names what there is: every file, every name in it, every term."""

from __future__ import annotations

import re
from dataclasses import fields
from importlib import import_module
from pathlib import Path

import pytest

from rollgait.ocp.instant import Body, Foot, Instant
from rollgait.ocp.problem import make_problem
from rollgait.plan.samples import Samples
from rollgait.robot.library import find_robot
from rollgait.scenario.profile import PROFILES
from rollgait.scenario.scenario import Scenario
from tests.plan.builders import robot as simple_robot
from tests.skidding import robot as skidding

TEXT = (Path(__file__).parents[1] / "docs" / "formulation.md").read_text(encoding="utf-8")
ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")] for line in TEXT.splitlines() if line[:1] == "|"
]
PLACES = [(file, names) for row in ROWS for file, names in re.findall(r"`(\w+/\w+\.py)` (`.*)$", row[-1])]


@pytest.mark.parametrize(("file", "names"), PLACES, ids=lambda x: x.replace("`", ""))
def test_places_exist(file: str, names: str) -> None:
    module = import_module("rollgait." + file.removesuffix(".py").replace("/", "."))
    for name in re.findall(r"`(\w+)`", names):
        assert hasattr(module, name), f"{file} has no {name}"


def test_symbols_exist() -> None:
    owners = {"x.body": Body, "x": Instant, "foot": Foot}
    symbols = re.findall(r"`(x\.body|x|foot)\.(\w+)[`\[]", TEXT)
    assert len(symbols) > 20
    for owner, name in symbols:
        kind = owners[owner]
        assert name in {f.name for f in fields(kind)} | set(vars(kind)), f"{owner}.{name}"
    samples = {f.name for f in fields(Samples)}
    for row in ROWS:
        if len(row) == 6 and row[3].startswith("`"):
            assert row[3].strip("`") in samples


def test_every_term_has_its_row() -> None:
    robots = [simple_robot("steerable"), simple_robot("point"), skidding(), find_robot("centauro-2020")]
    problems = [
        make_problem(Scenario(robot=robot, goal={"x": 0.0}, profile=profile))
        for robot in robots
        for profile in ("paper", "executable")
    ]
    terms = {term.name for problem in problems for term in problem.terms}
    named = {name for row in ROWS for cell in row for name in re.findall(r"^`(\w+)`$", cell)}
    assert terms <= named, terms - named


def test_weights_are_those_of_the_profile() -> None:
    stated = {
        row[1].strip("`"): float(row[0].split(" · ")[0])
        for row in ROWS
        if len(row) == 3 and re.match(r"[\d.e-]+ · ", row[0])
    }
    assert stated == PROFILES["paper"]["weights"]
