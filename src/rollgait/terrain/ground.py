"""What a scenario says of its ground: the keys of `ground:`, and the terrain that they mean."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self, get_args

from pydantic import AfterValidator, BeforeValidator, Field, PrivateAttr, model_validator

from rollgait.config import Config, NonNegative, Number, Positive, validate
from rollgait.errors import MISSING, InputError
from rollgait.terrain.height_map import HeightMap
from rollgait.terrain.map_file import read_map
from rollgait.terrain.parts import Part
from rollgait.terrain.terrain import FRICTION_MAX, Terrain

NOISE_MAX: Final = 0.1
"""Largest noise, m: more is in another unit, and no ground can be told from it."""

GroundKind = Literal["flat", "parts", "map"]


def _not_zero(value: float) -> float:
    if value == 0.0:
        raise ValueError("must not be 0")
    return value


def _noise(value: Any) -> Any:
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if value != "auto" and not (number and 0.0 <= value <= NOISE_MAX):
        raise ValueError(f"must be a standard deviation from 0 to {NOISE_MAX:g} m, or auto")
    return value


Noise = Annotated[float | Literal["auto"], BeforeValidator(_noise)]


class MapKeys(Config):
    """A file of heights."""

    file: str | None = None
    """A .npy, a 16-bit .png, a GeoTIFF or a ROS 2 bag with a GridMap, in the folder of the scenario. Needed,
    but where the heights come from Python."""
    resolution: Positive | None = None
    """Distance of neighbouring values, m. For .npy and .png; the others say it themselves."""
    origin: tuple[Number, Number] | None = None
    """Place of the first value (of a picture: lower left pixel), m. Default: what the file says, or 0, 0."""
    scale: Annotated[Number, AfterValidator(_not_zero)] | None = None
    """By which values are multiplied to be metres. Default: 1; must be given for a .png."""
    offset: Number = 0.0
    """What is added then, m."""
    noise: Noise = 0.0
    """Standard deviation of the sensor's noise, m, or `auto`. It is taken out, edges are kept."""
    layer: str = "elevation"
    """Layer of a GridMap."""
    topic: str | None = None
    """Topic of a GridMap in a bag. Default: the only one."""
    fill: NonNegative = 0.0
    """Unknown holes up to so wide are filled from what is around them, m."""
    digest: str | None = None
    """SHA-256 of the heights that are meant, as plans state it; a file that holds others is refused."""

    def read(self, folder: Path | None) -> HeightMap:
        """The heights in the file.

        Args:
            folder: of the scenario; None if the scenario came from no file.

        Raises:
            InputError: there is no file or no folder, or the file holds other heights than are meant.
            FileError: the file cannot be read.
        """
        if self.file is None:
            rule = "must be given" if self.digest is None else "must be given: these heights are in no file"
            raise InputError("ground.map.file", MISSING, rule)
        if folder is None:
            rule = "needs a scenario in a file: a map is looked for in the folder of its scenario"
            raise InputError("ground.map.file", self.file, rule)
        keys: dict[str, Any] = self.model_dump(exclude={"file", "noise", "fill", "digest"})
        heights = read_map(folder, self.file, **keys).without_noise(self.noise).with_holes_filled(self.fill)
        self.check_digest(heights)
        return heights

    def lies_in(self, folder: Path | None) -> bool:
        """Whether its file is in a folder."""
        return folder is not None and self.file is not None and (folder / self.file).exists()

    def check_digest(self, heights: HeightMap) -> None:
        """Raises `InputError` unless these are the heights that are meant."""
        if self.digest is not None and self.digest != heights.digest:
            rule = f"is not that of the heights, {heights.digest}: they are not those that were meant"
            raise InputError("ground.map.digest", self.digest, rule)


@dataclass(frozen=True)
class _Source:
    """What a ground knows beside its keys.

    Attributes:
        heights: of its map, once they were read.
        folder: of the scenario, where files of maps lie. What the ground is does not depend on it.
    """

    heights: HeightMap | None = None
    folder: Path | None = field(default=None, compare=False)


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
    _source: _Source = PrivateAttr(default=_Source())

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

    # -- the heights of its map --

    @classmethod
    def of(cls, terrain: Terrain) -> Ground:
        """The keys that mean a terrain. Heights of a map go with them, but not into a YAML file."""
        heights = terrain.map
        data: dict[str, Any] = {
            "height": terrain.level,
            "friction": terrain.friction,
            "parts": [part.model_dump() for part in terrain.parts],
            "map": None if heights is None else {"digest": heights.digest},
        }
        ground = validate(cls, data, "ground")
        return ground if heights is None else ground.with_heights(heights)

    @property
    def heights(self) -> HeightMap | None:
        """The heights of its map; None if it has none, or they were not read yet."""
        return self._source.heights

    def with_heights(self, heights: HeightMap) -> Ground:
        """The same ground with the heights of its map. Raises `InputError` if they are not those meant."""
        if self.map is None:
            raise InputError("ground.map", MISSING, "must be given where there are heights")
        self.map.check_digest(heights)
        return self._with(_Source(heights, self._source.folder))

    def read(self, folder: Path | None) -> Ground:
        """The same ground with the heights in the file of its map, if it has one and they are not there yet.

        Args:
            folder: of the scenario, where the map lies; None if the scenario came from no file.

        Raises:
            InputError: a map has no folder to lie in, or is not the one that is meant.
            FileError: the map cannot be read.
        """
        heights = self.heights
        if heights is None and self.map is not None:
            heights = self.map.read(folder)
        return self._with(_Source(heights, folder))

    def read_like(self, earlier: Ground) -> Ground:
        """The same ground with the heights of an earlier one, or from where that one's lie if keys differ."""
        same = self.map is not None and self.map == earlier.map and earlier.heights is not None
        return self._with(earlier._source) if same else self.read(earlier._source.folder)

    def self_contained(self) -> Ground:
        """The same ground, which knows no folder any more and says which heights are meant."""
        heights = self.heights
        if self.map is None or heights is None:
            return self._with(_Source())
        stated = self.map.model_copy(update={"digest": heights.digest})
        return self.model_copy(update={"map": stated})._with(_Source(heights))

    def _with(self, source: _Source) -> Self:
        result = self.model_copy()
        result._source = source
        return result

    def terrain(self, folder: Path | None = None) -> Terrain:
        """The ground itself; reads the file of the map, if there is one that was not read yet.

        Args:
            folder: of the scenario, where the map lies; None if the scenario came from no file.

        Raises:
            InputError: something contradicts itself, or a map has no folder to lie in.
            FileError: the map cannot be read.
        """
        return Terrain(self.height, self.friction, self.parts, self.read(folder).heights)
