"""The site has a place for every page and every public name."""

from __future__ import annotations

import re
from pathlib import Path

import rollgait

DOCS = Path(__file__).parents[2] / "docs"


def test_every_public_name_is_in_the_reference_once() -> None:
    text = "\n".join(page.read_text(encoding="utf-8") for page in (DOCS / "api").glob("*.md"))
    documented = re.findall(r"^\.\. auto(?:class|function):: (\w+)$", text, re.M)
    assert sorted(documented) == sorted(rollgait.__all__)


def test_every_page_is_in_the_index() -> None:
    entries = [
        line
        for block in re.findall(r"```\{toctree\}\n(.*?)```", (DOCS / "index.md").read_text("utf-8"), re.S)
        for line in block.splitlines()
        if line and not line.startswith(":")
    ]
    listed = {page for entry in entries for page in DOCS.glob(f"{entry}.md")}
    reference = set((DOCS / "api").glob("*.md"))
    assert set(DOCS.rglob("*.md")) - listed - reference == {DOCS / "index.md"}
