"""What a notebook shows: a card for each kind, safe HTML with its picture inside, and a short text."""

from __future__ import annotations

from html.parser import HTMLParser

import pytest

import rollgait as rg
from tests.view.builders import motion_plan

REPR_MAX = 200
"""Characters that a cell of a notebook may show of a plan."""


class Reader(HTMLParser):
    """Text, tags that are open, and what a browser would fetch."""

    def __init__(self) -> None:
        super().__init__()
        self.text = ""
        self.open: list[str] = []
        self.tags: set[str] = set()
        self.fetched: list[str] = []

    def handle_data(self, data: str) -> None:
        self.text += data

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        if tag != "img":
            self.open.append(tag)
        self.fetched += [value or "" for name, value in attributes if name in ("src", "href")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def read(html: str) -> Reader:
    reader = Reader()
    reader.feed(html)
    assert not reader.open
    assert reader.tags <= {"div", "span", "b", "img", "table", "tr", "td"}
    assert all(url.startswith("data:image/png;base64,") for url in reader.fetched)
    return reader


@pytest.fixture(scope="module")
def plan() -> rg.Plan:
    return motion_plan(rg.find_scenario("wheeled"))


def test_every_kind_has_a_card_with_a_picture(plan: rg.Plan) -> None:
    hills = rg.find_scenario("stairs")
    things = (plan, plan.scenario, hills, plan.robot, rg.find_robot("centauro-2020").with_feet("point"))
    for thing in things:
        assert len(read(thing._repr_html_()).fetched) == 1
    assert plan.robot.name in read(plan._repr_html_()).text
    bars = read(plan.certificate()._repr_html_())
    assert "table" in bars.tags


def test_the_verdict_is_the_certificates(plan: rg.Plan) -> None:
    failures = plan.certificate().failures
    text = read(plan._repr_html_()).text
    assert ("not certified" in text) == bool(failures)
    assert all(row.name in text for row in failures)
    assert "not solved" in read(motion_plan(plan.scenario, solved=False)._repr_html_()).text


def test_an_outcome_is_its_plan_or_says_why_there_is_none(plan: rg.Plan) -> None:
    assert len(read(rg.Outcome("good", plan)._repr_html_()).fetched) == 1
    text = read(rg.Outcome("bad", error=rg.InputError("goal.x", 99, "is far"))._repr_html_()).text
    assert "bad" in text
    assert "goal.x: 99 is far" in text


def test_text_of_users_stays_text(plan: rg.Plan) -> None:
    evil = "<script>alert(1)</script>"
    scenario = plan.scenario.with_values({"description": evil})
    assert evil in read(scenario._repr_html_()).text
    robot = plan.robot.with_values({"name": evil, "description": evil})
    assert evil in read(robot._repr_html_()).text
    assert evil in read(rg.Outcome(evil, error=rg.RollgaitError(evil))._repr_html_()).text


def test_a_plan_in_text_is_one_short_line(plan: rg.Plan) -> None:
    for thing in (plan, plan.certificate(), rg.Outcome("name", plan)):
        assert len(repr(thing)) <= REPR_MAX
        assert "\n" not in repr(thing)
    assert plan.robot.name in repr(plan)
