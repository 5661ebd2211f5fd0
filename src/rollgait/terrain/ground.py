"""What a scenario says of its ground: the keys of `ground:`, and the terrain that they mean."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, Field, model_validator

from rollgait.config import Config, NonNegative, Number, Positive
from rollgait.errors import InputError
from rollgait.terrain.map_file import read_map
from rollgait.terrain.parts import Part
from rollgait.terrain.terrain import FRICTION_MAX, Terrain

GroundKind = Literal["flat", "parts", "map"]


def _not_zero(value: float) -> float:
    if value == 0.0:
        raise ValueError("must not be 0")
    return value


class MapKeys(Config):
    """A file of heights."""

    file: str
    """A .npy, a 16-bit .png, a GeoTIFF or a ROS 2 bag with a GridMap; from the scenario's folder, in it."""
    resolution: Positive | None = None
    """Distance of neighbouring values, m. For .npy and .png; the others say it themselves."""
    origin: tuple[Number, Number] | None = None
    """Place of the first value (of a picture: lower left pixel), m. Default: what the file says, or 0, 0."""
    scale: Annotated[Number, AfterValidator(_not_zero)] | None = None
    """By which values are multiplied to be metres. Default: 1; must be given for a .png."""
    offset: Number = 0.0
    """What is added then, m."""
    layer: str = "elevation"
    """Layer of a GridMap."""
    topic: str | None = None
    """Topic of a GridMap in a bag. Default: the only one."""
    fill: NonNegative = 0.0
    """Unknown holes up to so wide are filled from what is around them, m."""


class Ground(Config):
    """What the robot stands on: a plane, parts on it, a map, or parts on a map."""

    kind: GroundKind = Field(default="flat", exclude=True)
    """`flat`, `parts` or `map`: follows from the other keys and need not be said."""
    height: Number = 0.0
    """z of the plane, m; what the heights of a map are added to."""
    friction: Annotated[Positive, Field(le=FRICTION_MAX)] = 0.5
    """μ, coefficient of friction, where a part says no other."""
    parts: tuple[Part, ...] = ()
    """What lies on the plane or the map; later ones override earlier ones."""
    map: MapKeys | None = None
    """Measured heights in place of the plane."""

    @model_validator(mode="before")
    @classmethod
    def _kind_that_follows(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        follows = "map" if data.get("map") is not None else "parts" if data.get("parts") else "flat"
        said = data.get("kind", follows)
        if said in get_args(GroundKind) and said != follows:
            raise ValueError(f"has the kind {said!r}, but its other keys mean {follows!r}: leave it out")
        return {**data, "kind": said}

    def terrain(self, folder: Path | None = None) -> Terrain:
        """The ground itself; reads the file of the map, if there is one.

        Args:
            folder: of the scenario, where the map lies; None if the scenario came from no file.

        Raises:
            InputError: something contradicts itself, or a map has no folder to lie in.
            FileError: the map cannot be read.
        """
        raster = None
        if self.map is not None:
            if folder is None:
                rule = "needs a scenario in a file: a map is looked for in the folder of its scenario"
                raise InputError("ground.map.file", self.map.file, rule)
            keys: dict[str, Any] = self.map.model_dump(exclude={"file", "fill"})
            raster = read_map(folder, self.map.file, **keys).with_holes_filled(self.map.fill)
        return Terrain(self.height, self.friction, self.parts, raster)
