"""Checks the built site: no dead link inside it, and what newcomers look for within two clicks.

    .venv/bin/python tools/site_links.py build/docs

Links to other sites are not followed: that needs the network (`make links`).
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from html.parser import HTMLParser
from pathlib import Path
from typing import Final
from urllib.parse import unquote, urlsplit

WANTED: Final = ("install.html", "tutorial.html", "howto/own-robot.html", "terrain.html")
"""Pages that a reader must find within `CLICKS` of index.html."""
CLICKS: Final = 2
LEFT_OUT: Final = ("genindex.html", "search.html", "py-modindex.html")
"""Pages without links of ours."""


class _Page(HTMLParser):
    """Links, pictures and anchors of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.body_links: list[str] = []
        self.anchors: set[str] = set()
        self._depth = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        if identifier := values.get("id"):
            self.anchors.add(identifier)
        if tag == "article":
            self._depth += 1
        for name in ("href", "src"):
            if (link := values.get(name)) is not None and tag != "link":
                self.links.append(link)
                if self._depth and tag == "a":
                    self.body_links.append(link)

    def handle_endtag(self, tag: str) -> None:
        if tag == "article":
            self._depth -= 1


def read_site(root: Path) -> dict[Path, _Page]:
    """All pages of a site."""
    pages = {}
    for file in sorted(root.rglob("*.html")):
        pages[file.resolve()] = page = _Page()
        page.feed(file.read_text(encoding="utf-8"))
    return pages


def _target(page: Path, link: str) -> tuple[Path, str] | None:
    """File and anchor that a link within the site leads to; None for other sites."""
    parts = urlsplit(link)
    if parts.scheme or parts.netloc or link.startswith("#!"):
        return None
    path = (page.parent / unquote(parts.path)).resolve() if parts.path else page
    return path / "index.html" if path.is_dir() else path, unquote(parts.fragment)


def dead_links(root: Path, pages: Mapping[Path, _Page]) -> Iterator[str]:
    """Sentences about links that lead nowhere."""
    for file, page in pages.items():
        if file.name in LEFT_OUT:
            continue
        for link in page.links:
            found = _target(file, link)
            if found is None:
                continue
            path, anchor = found
            name = file.relative_to(root.resolve())
            if not path.is_file():
                yield f"{name}: {link}: there is no such file"
            elif anchor and path in pages and anchor not in pages[path].anchors:
                yield f"{name}: {link}: there is no such heading"


def reached(root: Path, pages: Mapping[Path, _Page], clicks: int) -> set[str]:
    """Pages within some clicks of index.html, by links of the text itself, not of the bar beside it."""
    start = (root / "index.html").resolve()
    seen = here = {start}
    for _ in range(clicks):
        here = {
            found[0]
            for file in here
            for link in pages[file].body_links
            if (found := _target(file, link)) is not None and found[0] in pages
        } - seen
        seen = seen | here
    return {str(file.relative_to(root.resolve())) for file in seen}


def main(root: Path) -> int:
    """Says what is wrong with a site; 1 if anything is."""
    pages = read_site(root)
    wrong = list(dead_links(root, pages))
    near = reached(root, pages, CLICKS)
    wrong += [f"{name}: is not within {CLICKS} clicks of index.html" for name in WANTED if name not in near]
    for sentence in wrong:
        print(f"error: {sentence}", file=sys.stderr)
    if not wrong:
        links = sum(len(page.links) for page in pages.values())
        print(f"{root}: {len(pages)} pages, {links} links, none dead")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
