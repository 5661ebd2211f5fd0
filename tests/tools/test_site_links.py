"""Dead links of a site are found, and how many clicks a page is away."""

from pathlib import Path

import pytest
from tools.site_links import dead_links, main, reached, read_site

PAGES = {
    "index.html": '<article><a href="a.html#there">a</a><img src="p.png"></article><a href="c.html">c</a>',
    "a.html": '<article><h1 id="there">A</h1><a href="b/">b</a><a href="https://example.org/x">x</a></article>',
    "b/index.html": '<article><a href="../c.html">c</a></article>',
    "c.html": "<article></article>",
    "p.png": "",
}


@pytest.fixture
def site(tmp_path: Path) -> Path:
    for name, text in PAGES.items():
        file = tmp_path / name
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)
    return tmp_path


def test_a_whole_site_has_no_dead_link(site: Path) -> None:
    assert list(dead_links(site, read_site(site))) == []


@pytest.mark.parametrize(
    ("page", "text", "said"),
    [
        ("c.html", '<a href="d.html">', "no such file"),
        ("c.html", '<a href="a.html#here">', "no such heading"),
        ("c.html", '<a href="#here">', "no such heading"),
        ("c.html", '<img src="q.png">', "no such file"),
    ],
)
def test_a_dead_link_is_named(site: Path, page: str, text: str, said: str) -> None:
    (site / page).write_text(text)
    (sentence,) = dead_links(site, read_site(site))
    assert sentence.startswith(f"{page}: ")
    assert said in sentence


def test_clicks_are_those_of_the_text(site: Path) -> None:
    pages = read_site(site)
    assert reached(site, pages, 0) == {"index.html"}
    assert reached(site, pages, 1) == {"index.html", "a.html"}
    assert reached(site, pages, 3) == {"index.html", "a.html", "b/index.html", "c.html"}


def test_what_is_wanted_and_too_far_is_an_error(site: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(site) == 1
    assert "install.html: is not within 2 clicks" in capsys.readouterr().err
