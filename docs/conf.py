"""How Sphinx builds this folder into a site, as `make docs` does.

Pages are Markdown, the reference comes from docstrings.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import rollgait

project = "rollgait"
author = "The rollgait developers"
copyright = "2026 The rollgait developers"
release = version = rollgait.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx.ext.napoleon"]
exclude_patterns = ["conf.py"]
nitpicky = False

myst_enable_extensions = ["deflist"]
myst_heading_anchors = 4
"""Links such as `terrain.md#ground` lead to headings down to this level."""
nb_execution_mode = "cache"
nb_execution_cache_path = str(Path(__file__).parents[1] / "build" / "notebooks-cache")
nb_execution_in_temp = True
nb_execution_timeout = 600  # s, for one cell on a busy machine
nb_execution_raise_on_error = True
"""Notebooks are kept without what they print, executed for the site, and again only when they change."""

suppress_warnings = ["ref.python"]
"""Fields of several classes have one name (`kind`): a type that names it may lead to any of them."""

default_role = "code"
"""In docstrings `name` is code."""
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
autodoc_class_signature = "mixed"
autosummary_generate = False
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 90
toc_object_entries_show_parents = "hide"
napoleon_numpy_docstring = False

html_theme = "furo"
html_title = f"rollgait {release}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False

linkcheck_timeout = 20  # s
linkcheck_retries = 2


def _without_empty_patterns(app: Any, page: str, source: list[str]) -> None:
    """Entries of index.md such as `dataset*` stand for pages that may be there; of none Sphinx would warn."""
    if page == "index":
        here = Path(app.srcdir)
        source[0] = "".join(
            line
            for line in source[0].splitlines(keepends=True)
            if not re.fullmatch(r"\w+\*\n", line) or any(here.glob(f"{line.strip()}.md"))
        )


def _as_it_is_meant(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """|v| is no substitution, and what stands before the first colon of a field's meaning is not its type."""
    lines[:] = [line.replace("|", r"\|") for line in lines]
    if what in ("attribute", "property"):
        lines[:0] = ["..", ""]  # an empty comment is the line that may have a type


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.connect("source-read", _without_empty_patterns)
    app.connect("autodoc-process-docstring", _as_it_is_meant, priority=400)  # before napoleon's, 500
