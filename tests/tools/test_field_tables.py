"""The tables in docs/ say what the code says."""

from tools.field_tables import DOCS, filled, table_of

from rollgait.scenario.weights import Bounds, Weights


def test_pages_are_fresh() -> None:
    pages = [page for page in DOCS.glob("*.md") if "<!-- keys of" in page.read_text(encoding="utf-8")]
    assert {page.name for page in pages} == {
        "scenario.md",
        "robot.md",
        "terrain.md",
        "whole-body.md",
        "dataset.md",
        "discover.md",
        "loads.md",
        "timing.md",
    }
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert filled(text) == text, "run: make tables"


def test_a_table_names_every_key_once() -> None:
    for model in (Weights, Bounds):
        rows = table_of(model).splitlines()[2:]
        assert [row.split("`")[1] for row in rows] == list(model.model_fields)


def test_defaults_of_the_profiles_are_told() -> None:
    assert "| `force_min` | `0` (paper), `40` (executable) |" in table_of(Bounds)
