"""NOTICE names every dependency whose licence asks for more than attribution."""

from __future__ import annotations

import re
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement

NOTICE = Path(__file__).parents[2] / "NOTICE"
EXTRAS = {"whole-body", "video", "cluster", "view", "mcap", "ros", "foxglove"}
"""Those of users."""
MORE = re.compile(r"GPL|General Public|MPL|Mozilla|EPL|Eclipse|CeCILL|SSPL|any-OSI|Non-?Commercial", re.I)
"""In the name of a licence."""


def needed(name: str, extras: frozenset[str], found: dict[str, str]) -> dict[str, str]:
    """Every installed distribution that another one needs, and its licence as its metadata say it."""
    try:
        metadata, requirements = distribution(name).metadata, distribution(name).requires or []
    except PackageNotFoundError:  # an extra that is not installed here
        return found
    classifiers = [c for c in metadata.get_all("Classifier") or [] if c.startswith("License ::")]
    named = [metadata.get("License-Expression") or "", (metadata.get("License") or "").partition("\n")[0]]
    found[name.lower()] = " ".join([*named, *classifiers])
    for requirement in map(Requirement, requirements):
        marker = requirement.marker
        wanted = marker is None or any(marker.evaluate({"extra": extra}) for extra in extras | {""})
        if wanted and requirement.name.lower() not in found:
            needed(requirement.name, frozenset(requirement.extras), found)
    return found


def test_notice_names_every_dependency_that_asks_for_more_than_attribution() -> None:
    found = needed("rollgait", frozenset(EXTRAS), {})
    asking = {name for name, licence in found.items() if MORE.search(licence)}
    assert "casadi" in asking
    notice = NOTICE.read_text(encoding="utf-8").lower()
    assert {name for name in asking if name not in notice} == set()
    assert "ffmpeg" in notice  # a binary inside a wheel, of which no metadata speak
