"""The maps of heights that come with the package, known by their digests."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from rollgait.config import parse_yaml, validate
from rollgait.terrain.ground import Ground
from rollgait.terrain.height_map import HeightMap


def heights_of_the_library(digest: str) -> HeightMap | None:
    """The map of a scenario of the library, if one has this digest."""
    folder = resources.files(__package__).joinpath("library")
    for file in folder.iterdir():
        if not file.name.endswith(".yaml"):
            continue
        data = parse_yaml(file.read_text(encoding="utf-8"), file.name)
        ground = data.get("ground") if isinstance(data, dict) else None
        if not isinstance(ground, dict) or "map" not in ground:
            continue
        heights = validate(Ground, ground).read(Path(str(folder))).heights
        if heights is not None and heights.digest == digest:
            return heights
    return None
