"""A page for a browser in one file: headings, sentences, tables and figures, without any script."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import Final

from matplotlib.figure import Figure

from rollgait.files import replacing
from rollgait.view.style import find_style

_STYLE: Final = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 60rem; margin: 2rem auto;
  color-scheme: light }
body { padding: 0 1rem }
h1 { font-size: 1.6rem } h2 { font-size: 1.2rem; margin-top: 2.2rem; border-bottom: 1px solid #ddd }
table { border-collapse: collapse; margin: .8rem 0; font-variant-numeric: tabular-nums }
th, td { text-align: left; padding: .15rem .9rem .15rem 0; border-bottom: 1px solid #eee }
th, td { white-space: nowrap }
th { color: #666; font-weight: 600 } td.number { text-align: right }
nav { display: flex; gap: 0 1.2rem; flex-wrap: wrap } nav a, summary { color: #0060a0 }
nav { position: sticky; top: 0; background: #fff; padding: .4rem 0; z-index: 1 }
h2 { scroll-margin-top: 4rem }
.wide { overflow-x: auto } summary { cursor: pointer }
.figures { display: grid; gap: 0 1.5rem }
.figures { grid-template-columns: repeat(auto-fit, minmax(min(26rem, 100%), 1fr)) }
figure { margin: 1rem 0 } figure > svg { display: block; max-height: 34rem; max-width: 100% }
figcaption { color: #666 } img { max-width: 100%; height: auto }
.verdict { font-weight: 600 } .fail { color: #B00020; font-weight: 600 } .pass { color: #00794a }
"""


@dataclass(frozen=True)
class Table:
    """A table: the first row is its head; columns in `right` are numbers."""

    rows: Sequence[Sequence[str]]
    right: Sequence[int] = ()

    def html(self) -> str:
        """As HTML."""
        head, *body = self.rows
        lines = [
            '<div class="wide"><table>',
            "<tr>" + "".join(f"<th>{escape(cell)}</th>" for cell in head) + "</tr>",
        ]
        for row in body:
            lines.append(
                "<tr>" + "".join(self._cell(place, cell) for place, cell in enumerate(row)) + "</tr>"
            )
        return "\n".join([*lines, "</table></div>"])

    def _cell(self, place: int, cell: str) -> str:
        kind = "number" if place in self.right else cell if cell in ("pass", "fail") else ""
        return f'<td class="{kind}">{escape(cell)}</td>' if kind else f"<td>{escape(cell)}</td>"


@dataclass(frozen=True)
class Picture:
    """A figure with its caption."""

    figure: Figure
    caption: str

    def html(self) -> str:
        """As HTML, with the picture inside."""
        stream = io.BytesIO()
        with find_style("screen").applied():
            self.figure.savefig(stream, format="svg", metadata={"Creator": None, "Date": None})
        data = base64.b64encode(stream.getvalue()).decode("ascii")
        caption = escape(self.caption)
        image = f'<img alt="{caption}" src="data:image/svg+xml;base64,{data}">'
        return f"<figure>{image}<figcaption>{caption}</figcaption></figure>"


@dataclass(frozen=True)
class Sentence:
    """A sentence; `verdict` makes it stand out."""

    text: str
    verdict: bool = False

    def html(self) -> str:
        """As HTML."""
        kind = ' class="verdict"' if self.verdict else ""
        return f"<p{kind}>{escape(self.text)}</p>"


@dataclass(frozen=True)
class Moving:
    """An SVG that moves by itself."""

    svg: str
    caption: str

    def html(self) -> str:
        """As HTML."""
        return f"<figure>{self.svg}<figcaption>{escape(self.caption)}</figcaption></figure>"


@dataclass(frozen=True)
class Folded:
    """What is shown when its title is clicked."""

    title: str
    parts: Sequence[Part]

    def html(self) -> str:
        """As HTML."""
        inner = "".join(part.html() for part in self.parts)
        return f"<details><summary>{escape(self.title)}</summary>{inner}</details>"


@dataclass(frozen=True)
class Pictures:
    """Pictures beside one another, where there is room."""

    pictures: Sequence[Picture]

    def html(self) -> str:
        """As HTML."""
        return f'<div class="figures">{"".join(each.html() for each in self.pictures)}</div>'


Part = Table | Picture | Sentence | Moving | Folded | Pictures


@dataclass
class Page:
    """A page: sections with a heading and parts, in this order."""

    title: str
    sections: list[tuple[str, list[Part]]] = field(default_factory=list)

    def add(self, heading: str, *parts: Part) -> None:
        """Adds a section."""
        self.sections.append((heading, list(parts)))

    def html(self) -> str:
        """The whole page."""
        title = escape(self.title)
        lines = [
            "<!doctype html>",
            f'<html lang="en"><head><meta charset="utf-8"><title>{title}</title>',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<style>{_STYLE}</style></head><body>",
            f"<h1>{title}</h1>",
        ]
        links = (
            f'<a href="#part{number}">{escape(heading)}</a>'
            for number, (heading, _) in enumerate(self.sections)
        )
        lines.append(f"<nav>{' '.join(links)}</nav>")
        for number, (heading, parts) in enumerate(self.sections):
            lines += [f'<h2 id="part{number}">{escape(heading)}</h2>', *(part.html() for part in parts)]
        return "\n".join([*lines, "</body></html>\n"])

    def save(self, path: str | Path) -> Path:
        """Writes the page; returns its path."""
        target = Path(path)
        with replacing(target) as temporary:
            temporary.write_text(self.html(), encoding="utf-8")
        return target
