"""`rg.record` and `rg.view`: from Python as from the command line, and inside a notebook."""

from __future__ import annotations

import http.client
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

import rollgait as rg
from tests.view.builders import motion_plan


class Frames(HTMLParser):
    """Attributes of the first tag."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tag = ""
        self.attributes: dict[str, str | None] = {}
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if not self.tag:
            self.tag, self.attributes = tag, dict(attrs)


def test_a_recording_in_a_notebook_is_the_page_that_is_written(tmp_path: Path) -> None:
    plan = motion_plan(rg.find_scenario("wheeled"))
    written = rg.record(plan, tmp_path / "motion.html")
    frame = Frames(written._repr_html_())
    assert frame.tag == "iframe"
    assert frame.attributes["sandbox"] == "allow-scripts"  # it reaches nothing of the notebook
    assert frame.attributes["srcdoc"] == (tmp_path / "motion.html").read_text(encoding="utf-8")
    in_memory = rg.record(plan)
    assert in_memory.path is None
    assert abs(len(in_memory.data) - len(written.data)) < 0.01 * len(written.data)
    assert "not written" in repr(in_memory)


def test_a_film_in_a_notebook_holds_the_film(tmp_path: Path) -> None:
    recording = rg.record(motion_plan(rg.find_scenario("wheeled")), tmp_path / "motion.gif")
    assert recording.data[:4] == b"GIF8"
    picture = Frames(recording._repr_html_())
    assert (picture.tag, str(picture.attributes["src"])[:22]) == ("img", "data:image/gif;base64,")


def test_what_cannot_be_recorded_is_said(tmp_path: Path) -> None:
    with pytest.raises(rg.InputError, match=r"path: 'motion\.txt' must end in a format that is known"):
        rg.record(motion_plan(rg.find_scenario("wheeled")), tmp_path / "motion.txt")
    with pytest.raises(rg.InputError, match="motion: 'int' must be a plan, joints"):
        rg.record(3)
    assert not list(tmp_path.iterdir())


def ancestors(viewer: Any) -> tuple[str | None, str | None]:
    """Which pages may hold the viewer in a frame, as its answer says, in both ways that browsers know."""
    connection = http.client.HTTPConnection("127.0.0.1", viewer.server.get_port())
    connection.request("HEAD", "/")
    headers = connection.getresponse().headers
    connection.close()
    return headers["X-Frame-Options"], headers["Content-Security-Policy"]


def test_a_viewer_in_a_notebook_is_its_page_and_a_link() -> None:
    viewer = rg.view(motion_plan(rg.find_scenario("wheeled")))
    try:
        assert ancestors(viewer) == ("DENY", "frame-ancestors 'none'")
        html = viewer._repr_html_()
        option, policy = ancestors(viewer)
    finally:
        viewer.close()
    assert f'href="{viewer.url}"' in html
    frame = Frames(html)
    assert (frame.tag, frame.attributes["src"]) == ("iframe", viewer.url)
    assert option is None
    hosts = (policy or "").removeprefix("frame-ancestors ").split()
    assert {urlsplit(host.removesuffix(":*")).hostname for host in hosts} == {"localhost", "127.0.0.1"}


def test_a_viewer_that_others_reach_is_a_link_in_a_notebook() -> None:
    viewer = rg.view(motion_plan(rg.find_scenario("wheeled")), host="0.0.0.0")
    try:
        html = viewer._repr_html_()
    finally:
        viewer.close()
    assert "<iframe" not in html
    assert 'href="' in html
