"""The ground: parts, a map, or parts on a map. Exact queries; frozen; saves and loads itself."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import BaseModel

from rollgait.archive import ArchiveFormat
from rollgait.config import Config, Number, Positive, validate
from rollgait.errors import InputError
from rollgait.npz import Layout
from rollgait.terrain.facet import Facet, Facets, square, visible
from rollgait.terrain.height_map import MAX_CELLS, HeightMap, relaxed
from rollgait.terrain.parts import BasePart, Part
from rollgait.terrain.polygons import Array, convex_hull, distance_to_hull, plane_of

MAX_FACETS: Final = 400
"""Most planar pieces that the parts of a ground have: each is cut by all later ones."""
FRICTION_MAX: Final = 10.0
"""Largest coefficient of friction: more is a slip of the pen."""
FEET_MARGIN: Final = 0.3
"""So far beyond the hull of its feet a robot stands in the way of its own sensors, m."""

STANDS_ON: Final = 0.05
"""So far about the hull of its feet the ground is their plane, m: beyond it goes over into what is known."""
RING: Final = 0.2
"""So much wider is the ring from which the ground under a robot is concluded, m."""


class _Parts(Config):
    """The parts as a list that can be checked, so that a message says where in it something is wrong."""

    parts: tuple[Part, ...]


@dataclass(frozen=True, eq=False)
class Terrain:
    """The ground.

    Build it from parts, from an array of heights, or both:

    >>> stairs = Terrain.from_parts([{"kind": "stairs", "x": 0.8, "steps": 3, "rise": 0.12, "tread": 0.4}])
    >>> float(stairs.height(1.0, 0.0))
    0.12

    Attributes:
        level: height of the plane that the parts lie on, m; what a map's heights are added to.
        friction: μ where no part says another one.
        parts: later ones override earlier ones, and the map.
        map: heights measured, in place of the plane; the ground off the map is not known.

    Raises:
        InputError: on construction, if something is out of range.
    """

    level: float = 0.0
    friction: float = 0.5
    parts: tuple[BasePart, ...] = ()
    map: HeightMap | None = None

    def __post_init__(self) -> None:
        if not (0.0 < self.friction <= FRICTION_MAX):
            rule = f"must be greater than 0 and at most {FRICTION_MAX:g}"
            raise InputError("ground.friction", self.friction, rule)
        if not np.isfinite(self.level):
            raise InputError("ground.height", self.level, "must be a finite number")
        for k, part in enumerate(self.parts):
            if part.friction is not None and part.friction > FRICTION_MAX:
                rule = f"must be at most {FRICTION_MAX:g}"
                raise InputError(f"ground.parts.{k}.friction", part.friction, rule)
        if len(self._laid) > MAX_FACETS:
            rule = f"must have at most {MAX_FACETS} planar pieces all together, not {len(self._laid)}"
            raise InputError("ground.parts", f"{len(self.parts)} parts", rule)

    # -- construction --

    @classmethod
    def from_parts(
        cls, parts: Iterable[BasePart | Mapping[str, Any]], height: float = 0.0, friction: float = 0.5
    ) -> Terrain:
        """A plane with parts on it.

        Args:
            parts: `Ramp`, `Step`, `Stairs`, `Gap`, `Block`, or mappings as in a scenario's `ground.parts`.
            height: of the plane, m.
            friction: μ where a part says none.

        Raises:
            InputError: a part breaks a rule.
        """
        return cls(height, friction, _checked(parts))

    @classmethod
    def from_map(
        cls,
        heights: ArrayLike,
        resolution: float,
        origin: ArrayLike = (0.0, 0.0),
        *,
        yaw: float = 0.0,
        scale: float = 1.0,
        offset: float = 0.0,
        noise: float | Literal["auto"] = 0.0,
        fill: float = 0.0,
        friction: float = 0.5,
        parts: Iterable[BasePart | Mapping[str, Any]] = (),
    ) -> Terrain:
        """Measured ground, with parts on it if there are any.

        Args:
            heights: (nx, ny), m after scale and offset; value [i, j] at origin + (i, j) · resolution, turned
                by yaw about the origin. NaN where the ground is not known.
            resolution: m.
            origin: place of value [0, 0], (2,), m.
            yaw: of the grid, rad.
            scale: by which the values are multiplied.
            offset: which is added then, m.
            noise: standard deviation of the sensor's noise, which is taken out, m; "auto" estimates it.
            fill: unknown holes up to so wide are filled, m.
            friction: μ where a part says none.
            parts: as in `from_parts`; they count their heights from z = 0.

        Raises:
            InputError: this is no map of ground, or a part breaks a rule.
        """
        try:
            values = np.asarray(heights, dtype=float) * scale + offset
        except (TypeError, ValueError):
            raise InputError("ground.map", type(heights).__name__, "must be an array of numbers") from None
        raster = HeightMap(values, resolution, np.asarray(origin), yaw)
        raster.require_metres()
        raster = raster.without_noise(noise).with_holes_filled(fill)
        return cls(0.0, friction, _checked(parts), raster)

    # -- queries --

    def height(self, x: ArrayLike, y: ArrayLike) -> Array:
        """z of the ground at places that broadcast together, their shape, m; NaN where it is not known.

        On an edge between two parts it is the height of the later one.
        """
        points, shape = as_points(x, y)
        z = np.full(len(points), np.nan)
        if self.map is not None:
            z = self.level + self.map.height(points)
        for number, index in self._ground_facets.under(points):
            z[index] = self._ground_facets.all[number].z(points[index])
        return z.reshape(shape)

    def slope(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Gradient (∂z/∂x, ∂z/∂y), shape (…, 2); NaN where the ground is not known."""
        points, shape = as_points(x, y)
        result = np.full((len(points), 2), np.nan)
        if self.map is not None:
            result = self.map.slope(points)
        for number, index in self._ground_facets.under(points):
            result[index] = self._ground_facets.all[number].slope
        return result.reshape(*shape, 2)

    def normal(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Unit normal of the ground, upwards, shape (…, 3); NaN where the ground is not known."""
        return normal_of(self.slope(x, y))

    def friction_at(self, x: ArrayLike, y: ArrayLike) -> Array:
        """μ at places that broadcast together, their shape."""
        points, shape = as_points(x, y)
        mu = np.full(len(points), self.friction)
        for number, index in self._ground_facets.under(points):
            mu[index] = self._ground_facets.all[number].friction
        return mu.reshape(shape)

    def known(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.bool_]:
        """Where the ground is known."""
        return ~np.isnan(self.height(x, y))

    @property
    def is_flat(self) -> bool:
        """Whether it is one level plane: there are neither parts nor a map."""
        return self.map is None and not self.parts

    @property
    def planar(self) -> bool:
        """Whether it is made of planes alone: there is no map."""
        return self.map is None

    @cached_property
    def planes(self) -> tuple[Facet, ...]:
        """The planar pieces that are seen from above. They do not overlap; without a map they are all."""
        return visible(self._ground_facets.all)

    @cached_property
    def _laid(self) -> tuple[Facet, ...]:
        """The facets of the parts, in the order in which they lie over one another."""
        return tuple(
            facet for k, part in enumerate(self.parts) for facet in part.facets(self.level, self.friction, k)
        )

    @cached_property
    def _ground_facets(self) -> Facets:
        """All facets: without a map, first the plane that the parts lie on."""
        plane = () if self.map is not None else (square(self.level, self.friction),)
        return Facets((*plane, *self._laid))

    @cached_property
    def seen(self) -> Facets:
        """`planes` as facets that can be asked which of them are where."""
        return Facets(self.planes)

    # -- other grounds made of it --

    def turned(self, yaw: float, about: ArrayLike = (0.0, 0.0)) -> Terrain:
        """The same world turned about a vertical axis.

        Args:
            yaw: rad.
            about: where the axis stands, (2,), m.
        """
        c, s = np.cos(yaw), np.sin(yaw)
        R, pivot = np.array([[c, -s], [s, c]]), np.asarray(about, dtype=float)
        parts = []
        for part in self.parts:
            x, y = pivot + R @ (np.array([part.x, part.y]) - pivot)
            turn = {"x": float(x), "y": float(y), "yaw_deg": part.yaw_deg + float(np.degrees(yaw))}
            parts.append(part.model_copy(update=turn))
        raster = self.map
        if raster is not None:
            origin = pivot + R @ (raster.origin - pivot)
            raster = HeightMap(raster.values, raster.resolution, origin, raster.yaw + yaw)
        return replace(self, parts=tuple(parts), map=raster)

    def raster(self, resolution: float, low: ArrayLike, high: ArrayLike) -> Terrain:
        """The same ground measured at the nodes of a grid, friction of the parts left out.

        Args:
            resolution: m.
            low: smallest x and y, (2,), m.
            high: largest x and y, (2,), m.

        Raises:
            InputError: the grid would be too large.
        """
        corner, far = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
        count = np.round((far - corner) / resolution).astype(int) + 1
        if np.prod(count.astype(float)) > MAX_CELLS:
            raise InputError("resolution", resolution, f"must leave at most {MAX_CELLS} cells")
        x, y = (c + resolution * np.arange(n) for c, n in zip(corner, count, strict=True))
        heights = HeightMap(self.height(x[:, None], y[None, :]), resolution, corner)
        return Terrain(friction=self.friction, map=heights)

    def filled_under(self, feet: ArrayLike) -> Terrain:
        """A copy that knows the ground under a robot, where its own sensors could not see it.

        Unknown nodes of the map within `STANDS_ON` of the hull of the feet get the plane through the feet,
        the best one if there are more than three. From there to `FEET_MARGIN` what is missing goes over into
        what is known around: the plane, with as much of the difference as neighbours have on average. What
        is left of a hole then is filled if it is small.

        Args:
            feet: where the standing feet touch the ground, (n, 3) with n ≥ 1, m.
        """
        touch = np.asarray(feet, dtype=float)
        if touch.ndim != 2 or touch.shape[1] != 3 or not len(touch) or not np.isfinite(touch).all():
            raise InputError("feet", touch.shape, "must be finite points where feet touch the ground, (n, 3)")
        if self.map is None:
            return self
        nodes = self.map.nodes()
        away = distance_to_hull(convex_hull(touch[:, :2]), nodes.reshape(-1, 2)).reshape(nodes.shape[:2])
        where = (away <= FEET_MARGIN) & np.isnan(self.map.values)
        if not where.any():
            return self
        centre, height, slope = plane_of(touch)
        plane = height + (nodes - centre) @ slope - self.level
        under = where & (away <= STANDS_ON)
        beside = where & ~under
        above = np.where(under, 0.0, self.map.values - plane)
        heights = plane + (relaxed(above, beside) if beside.any() else above)
        return replace(self, map=self.map.with_values_at(where, heights[where]).with_rests_filled(where))

    def filled_around(self, feet: ArrayLike) -> Terrain:
        """`filled_under` where only the places of the feet are known: from the ground around them.

        The heights of the feet are those of the plane on which most of what is known within `FEET_MARGIN` and
        `RING` of their hull lies. Where nothing is known there, nothing is filled.

        Args:
            feet: where the standing feet are from above, (n, 2) with n ≥ 1, m.
        """
        from rollgait.terrain.hidden import plane_around

        places = np.asarray(feet, dtype=float)
        if self.map is None or not np.isnan(self.map.values).any():
            return self
        distance = distance_to_hull(convex_hull(places), self.map.nodes().reshape(-1, 2))
        heights = self.map.values.ravel()
        known = (distance <= FEET_MARGIN + RING) & ~np.isnan(heights)
        around = np.column_stack([self.map.nodes().reshape(-1, 2)[known], heights[known]])
        centre = places.mean(axis=0)
        found = plane_around(centre, around)
        if found is None:
            return self
        height, slope = found
        z = self.level + height + (places - centre) @ slope
        return self.filled_under(np.column_stack([places, z]))

    # -- kept in files --

    def to_dict(self) -> dict[str, Any]:
        """All but the heights of the map, as plain data; with `arrays` it is the whole ground."""
        data: dict[str, Any] = {
            "height": self.level,
            "friction": self.friction,
            "parts": [part.model_dump(mode="json") for part in self.parts],
        }
        if self.map is not None:
            data["map"] = self.map.place()
        return data

    def arrays(self) -> dict[str, Array]:
        """Heights of the map, if there is one: `heights`, (nx, ny), m."""
        return {} if self.map is None else {"heights": self.map.values}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], arrays: Mapping[str, Array]) -> Terrain:
        """The inverse of `to_dict` and `arrays`. Raises KeyError, TypeError or ValueError if they do not."""
        grid = data.get("map")
        raster = None
        if grid is not None:
            origin = np.asarray(grid["origin"], dtype=float)
            raster = HeightMap(arrays["heights"], float(grid["resolution"]), origin, float(grid["yaw"]))
        return cls(float(data["height"]), float(data["friction"]), _checked(data["parts"]), raster)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of all that it is, as hexadecimal digits: equal grounds have equal ones."""
        text = json.dumps(self.to_dict(), sort_keys=True)
        heights = "" if self.map is None else self.map.digest
        return hashlib.sha256((text + heights).encode()).hexdigest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Terrain) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def save(self, path: str | Path) -> Path:
        """Writes it as one .npz file (the suffix is added if it is missing); returns its path."""
        return _FILE.write(path, self.to_dict(), self.arrays())

    @classmethod
    def load(cls, path: str | Path) -> Terrain:
        """Reads what `save` wrote; runs no code from the file. Raises `FileError`."""
        header, arrays = _FILE.read(path)
        with _FILE.damage_told(path):
            return cls.from_dict(header.model_dump(mode="json"), arrays)


class MapHeader(Config):
    """Where the heights of a map stand, as `HeightMap` says it."""

    resolution: Positive
    origin: tuple[Number, Number]
    yaw: Number


class TerrainHeader(BaseModel):
    """What the header of a ground's file holds."""

    height: Number
    friction: Positive
    parts: tuple[Part, ...]
    map: MapHeader | None = None


def terrain_layout(header: TerrainHeader) -> Layout:
    """The arrays of a ground's file."""
    return {} if header.map is None else {"heights": ("f", ("nx", "ny"))}


_FILE = ArchiveFormat(
    "rollgait-terrain", 1, "ground", "is not a ground that rollgait saved", TerrainHeader, terrain_layout
)


def normal_of(slope: Array) -> Array:
    """Unit normals (…, 3), upwards, of surfaces of gradient (…, 2)."""
    up = np.concatenate([-slope, np.ones((*slope.shape[:-1], 1))], axis=-1)
    return np.asarray(up / np.linalg.norm(up, axis=-1, keepdims=True))


def as_points(x: ArrayLike, y: ArrayLike) -> tuple[Array, tuple[int, ...]]:
    """Places that broadcast together as points (n, 2), and their shape."""
    a, b = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
    return np.column_stack([a.ravel(), b.ravel()]), a.shape


def _checked(parts: Iterable[BasePart | Mapping[str, Any]]) -> tuple[BasePart, ...]:
    plain = [part.model_dump() if isinstance(part, BasePart) else part for part in parts]
    return validate(_Parts, {"parts": plain}, "ground").parts
