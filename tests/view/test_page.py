"""A report page is one file that needs nothing else, and says what it is given."""

from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from rollgait.scenario import find_scenario
from rollgait.view.moving_picture import RATE, moving_picture
from rollgait.view.page import Folded, Page, Picture, Sentence, Table
from tests.view.builders import motion_plan

texts = st.text(st.characters(min_codepoint=32, exclude_categories=("Cs",)), min_size=1)


class Reader(HTMLParser):
    """All text, and what a browser would fetch."""

    def __init__(self) -> None:
        super().__init__()
        self.text: list[str] = []
        self.fetched: list[str] = []
        self.places: list[str] = []
        self.jumps: list[str] = []

    def handle_data(self, data: str) -> None:
        self.text.append(data)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        links = [value or "" for name, value in attributes if name in ("src", "href")]
        self.fetched += [link for link in links if not link.startswith("#")]
        self.places += [value or "" for name, value in attributes if name == "id"]
        self.jumps += [link[1:] for link in links if link.startswith("#")]


@given(texts, texts, texts)
def test_text_stays_text(title: str, cell: str, sentence: str) -> None:
    page = Page(title)
    page.add("heading", Table([("name",), (cell,)]), Sentence(sentence, verdict=True))
    reader = Reader()
    reader.feed(page.html())
    assert cell in reader.text
    assert sentence in reader.text
    assert reader.text.count(title) >= 2
    assert reader.fetched == []


def test_pictures_are_inside(tmp_path: Path) -> None:
    figure = Figure()
    figure.subplots().plot([0.0, 1.0])
    page = Page("page")
    page.add("figure", Picture(figure, "a <line>"))
    path = page.save(tmp_path / "folder" / "page.html")
    reader = Reader()
    reader.feed(path.read_text(encoding="utf-8"))
    assert len(reader.fetched) == 1
    assert reader.fetched[0].startswith("data:image/svg+xml;base64,")
    assert "a <line>" in reader.text


def test_the_contents_lead_to_every_section() -> None:
    page = Page("page")
    for heading in ("Plan", "Plan", "<Physics>"):  # twice the same heading
        page.add(heading, Folded("more", [Sentence("inside")]))
    reader = Reader()
    reader.feed(page.html())
    assert reader.jumps == reader.places
    assert len(set(reader.places)) == 3
    assert "inside" in reader.text


def test_a_moving_picture_takes_the_time_of_its_plan_and_needs_nothing() -> None:
    plan = motion_plan(find_scenario("hybrid-forward"))
    root = ElementTree.fromstring(moving_picture(plan))
    animations = [node for node in root.iter() if node.tag.endswith("animate")]
    assert animations
    frames = len(plan.sample_every(RATE).time)
    for each in animations:
        assert each.get("dur") == f"{plan.horizon:g}s"
        assert len(each.get("values", "").split(";")) == frames
    bodies = [node for node in root.iter() if node.tag.endswith("polygon") and len(node)]
    assert len(bodies) == 2
    _, _, width, height = map(float, str(root.get("viewBox")).split())
    for body in bodies:
        values = body[0].get("values", "").split(";")
        points = np.array([[point.split(",") for point in each.split()] for each in values], dtype=float)
        assert (points >= 0.0).all()
        assert (points <= [width, height]).all()
        moved = points[-1].mean(axis=0) - points[0].mean(axis=0)
        assert moved[0] > 0.0  # forward is to the right
