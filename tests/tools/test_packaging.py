"""What a package index shows, and which extras bring what."""

from __future__ import annotations

import io
import re
import tomllib
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from tools.package_page import PAGE, README, package_page

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = {
    name: [Requirement(line) for line in lines] for name, lines in PROJECT["optional-dependencies"].items()
}


def test_the_package_page_is_fresh_and_has_no_relative_link() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert page == package_page(README.read_text(encoding="utf-8")), "run: make tables"
    assert re.findall(r"\]\((?!https?:)", page) == []
    assert "CENTAURO" in page
    assert "rollgait[" not in page or "pip install" in page


def test_pictures_links_and_comments_go_but_addresses_stay() -> None:
    readme = "# A\n\n![b](c.png)\n\n<!-- d -->\n[e](f.md) [g](https://h.org)\n\n## Documentation\n\n[j](k)\n"
    assert package_page(readme).startswith("# A\n\ne [g](https://h.org)\n\n")
    assert "j" not in package_page(readme).partition("Documentation, examples")[0]


def test_the_package_page_renders() -> None:
    markdown = pytest.importorskip("readme_renderer.markdown", reason="readme-renderer is not installed")
    html = markdown.render(PAGE.read_text(encoding="utf-8"), stream=io.StringIO())
    assert html is not None
    assert "<table>" in html
    assert html.count("<pre") >= 3


def test_all_holds_the_extras_of_users_and_no_tools_of_developers() -> None:
    (all_of_them,) = EXTRAS["all"]
    assert all_of_them.extras == set(EXTRAS) - {"all", "dev", "docs"}
    tools = {requirement.name for name in ("dev", "docs") for requirement in EXTRAS[name]}
    brought = {requirement.name for name in all_of_them.extras for requirement in EXTRAS[name]}
    assert tools & brought == set()


def test_each_extra_is_on_the_page_that_tells_how_to_install() -> None:
    text = (ROOT / "docs" / "install.md").read_text(encoding="utf-8")
    assert {name for name in EXTRAS if f"| `{name}` |" not in text} == {"dev", "docs"}


def test_the_citation_is_of_this_version() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == PROJECT["version"]
    assert citation["license"] == PROJECT["license"]
