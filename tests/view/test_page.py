"""A report page is one file that needs nothing else, and says what it is given."""

from html.parser import HTMLParser
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from rollgait.view.page import Page, Picture, Sentence, Table

texts = st.text(st.characters(min_codepoint=32, exclude_categories=("Cs",)), min_size=1)


class Reader(HTMLParser):
    """All text, and what a browser would fetch."""

    def __init__(self) -> None:
        super().__init__()
        self.text: list[str] = []
        self.fetched: list[str] = []

    def handle_data(self, data: str) -> None:
        self.text.append(data)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.fetched += [value or "" for name, value in attributes if name in ("src", "href")]


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
