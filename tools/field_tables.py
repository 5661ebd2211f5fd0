"""Writes the tables of keys in docs/ from the classes they describe, or checks that they are fresh (--check).

A table stands between `<!-- keys of rollgait.scenario.scenario.Goal -->` and `<!-- end -->`; meaning and unit
are the field's docstring, the default that of the field, or of the profiles if the field leaves it to them.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import sys
import textwrap
from itertools import pairwise
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from rollgait.scenario.profile import PROFILES

DOCS = Path(__file__).parent.parent / "docs"
PLACE = re.compile(r"<!-- keys of (?P<name>[\w.]+) -->\n.*?<!-- end -->", re.S)
GROUPS = {"Weights": "weights", "Bounds": "bounds"}


def table_of(model: type[BaseModel]) -> str:
    """The keys of a model as a Markdown table: key, default, meaning with unit."""
    rows = ["| key | default | meaning |", "|---|---|---|"]
    meanings = _docstrings(model)
    for name, field in model.model_fields.items():
        meaning = " ".join(meanings.get(name, "").split()).replace("|", "\\|")
        if not meaning:
            raise ValueError(f"{model.__name__}.{name} has no docstring")
        rows.append(f"| `{name}` | {_default(model, name, field)} | {meaning} |")
    return "\n".join(rows)


def _docstrings(model: type[BaseModel]) -> dict[str, str]:
    """What stands below each field of a class or of its bases. (Pydantic would look at each import.)"""
    found: dict[str, str] = {}
    for base in reversed(model.__mro__[: model.__mro__.index(BaseModel)]):
        body = ast.parse(textwrap.dedent(inspect.getsource(base))).body[0].body
        for field, text in pairwise(body):
            match field, text:
                case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(
                    value=ast.Constant(value=str(meaning))
                ):
                    found[name] = meaning
    return found


def _default(model: type[BaseModel], name: str, field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True)
    group = GROUPS.get(model.__name__)
    if value is None and group is not None:
        own = {profile: table[group].get(name) for profile, table in PROFILES.items()}
        if len(set(own.values())) == 1:
            return "–" if None in own.values() else _shown(next(iter(own.values())))
        return ", ".join(f"{_shown(v)} ({profile})" for profile, v in own.items())
    return _shown(value)


def _shown(value: Any) -> str:
    if value is None:
        return "–"
    if isinstance(value, BaseModel):
        kind = getattr(value, "kind", None)
        return f"`{kind}`" if kind else "see below"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, tuple):
        return "`[" + ", ".join(_plain(v) for v in value) + "]`"
    return f"`{_plain(value)}`" if value != "" else "empty"


def _plain(value: Any) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def filled(text: str) -> str:
    """A page with all its tables written anew."""

    def fill(match: re.Match[str]) -> str:
        module, _, name = match["name"].rpartition(".")
        model = getattr(importlib.import_module(module), name)
        return f"<!-- keys of {match['name']} -->\n{table_of(model)}\n<!-- end -->"

    return PLACE.sub(fill, text)


def main(check: bool) -> int:
    """Writes or checks all pages; 1 if a page is stale."""
    stale = []
    for page in sorted(DOCS.glob("*.md")):
        text = page.read_text(encoding="utf-8")
        new = filled(text)
        if new != text:
            stale.append(page.name)
            if not check:
                page.write_text(new, encoding="utf-8")
    if check and stale:
        print(f"error: the tables in {', '.join(stale)} are stale; run: make tables", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main("--check" in sys.argv[1:]))
