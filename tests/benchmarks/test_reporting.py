"""Laws of the page of results."""

from __future__ import annotations

import platform
import sys
from pathlib import Path
from types import ModuleType

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture
def reporting(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The module as the benchmarks see it: from the folder in which they are."""
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import reporting

    monkeypatch.delitem(sys.modules, "reporting")
    return reporting


def test_a_section_is_kept_once_and_leaves_the_rest(reporting: ModuleType, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("# Title\n\nwords\n", encoding="utf-8")
    reporting.keep("a", "first a \\1", page)
    reporting.keep("b", "only b", page)
    reporting.keep("a", "second a \\1", page)
    text = page.read_text(encoding="utf-8")
    assert text.startswith("# Title\n\nwords\n")
    assert "first a" not in text
    assert text.count("second a \\1") == text.count("only b") == 1
    assert text.index("second a") < text.index("only b")
    reporting.keep("a", "second a \\1", page)
    assert page.read_text(encoding="utf-8") == text


def test_a_table_has_a_cell_for_each_column(reporting: ModuleType) -> None:
    lines = reporting.table(("name", "s"), [("x", 1), ("y", 2)]).splitlines()
    assert [line.count("|") for line in lines] == [3] * 4


def test_words_about_the_machine_name_no_host_and_no_path(reporting: ModuleType) -> None:
    words = reporting.machine()
    assert "/" not in words
    assert not platform.node() or platform.node() not in words
