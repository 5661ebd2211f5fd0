"""Ground as a raster of heights."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.errors import InputError
from rollgait.terrain.polygons import Array

MAX_CELLS: Final = 4_000_000
"""Largest map: 20 m × 20 m at 1 cm."""
RESOLUTION_MIN: Final = 1.0e-3
"""Finest map, m: no sensor measures ground more finely, and a smaller number is a wrong unit."""
STEEPNESS_MAX: Final = 2.0
"""Largest span of heights over the longer side of a map: more is a wrong unit (mm for m), not ground."""
REST: Final = 0.15
"""So wide may be what is left of a hole that was filled for the greater part, m."""


@dataclass(frozen=True, eq=False)
class HeightMap:
    """Heights at the nodes of a square grid, bilinear in between; NaN is ground that nobody knows.

    Attributes:
        values: heights, (nx, ny), m: value [i, j] at origin + Rz(yaw) (i, j) · resolution.
        resolution: distance of neighbouring nodes, m.
        origin: of node [0, 0] in the world, (2,), m.
        yaw: of the grid in the world, rad.

    Raises:
        InputError: on construction, if it is no map of ground.
    """

    values: Array
    resolution: float
    origin: Array = field(default_factory=lambda: np.zeros(2))
    yaw: float = 0.0

    def __post_init__(self) -> None:
        try:
            values = np.array(self.values, dtype=float)
            origin = np.array(self.origin, dtype=float)
        except (TypeError, ValueError):
            raise InputError(
                "ground.map", type(self.values).__name__, "must be an array of numbers"
            ) from None
        _check(values, self.resolution, origin, self.yaw)
        values.flags.writeable = origin.flags.writeable = False
        for name, value in (("values", values), ("origin", origin)):
            object.__setattr__(self, name, value)

    @property
    def size(self) -> Array:
        """Lengths of its sides, (2,), m."""
        return self.resolution * (np.array(self.values.shape) - 1.0)

    @property
    def corners(self) -> Array:
        """Its corners in the world, counter-clockwise, (4, 2), m."""
        return self.to_world(self.size * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]))

    def require_metres(self) -> None:
        """Raises `InputError` if its heights span more than ground does: they are in another unit.

        A question to maps as they come: a cliff fills a small part of a map with more than that.
        """
        span, side = float(np.nanmax(self.values) - np.nanmin(self.values)), float(self.size.max())
        if span > STEEPNESS_MAX * side:
            raise InputError(
                "ground.map",
                f"{span:.6g} m",
                f"is too much between its lowest and its highest point for a map of {side:.4g} m: heights "
                "must be in m, or scale must turn them into m (0.001 for mm)",
            )

    def to_world(self, local: Array) -> Array:
        """Points (…, 2) in the axes of the grid, from its node [0, 0], as points of the world, m."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        return np.asarray(self.origin + local @ np.array([[c, s], [-s, c]]))

    def to_local(self, points: Array) -> Array:
        """The inverse of `to_world`."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        return np.asarray((points - self.origin) @ np.array([[c, -s], [s, c]]))

    def nodes(self) -> Array:
        """Places of all nodes in the world, (nx, ny, 2), m."""
        i, j = np.meshgrid(*(np.arange(n, dtype=float) for n in self.values.shape), indexing="ij")
        return self.to_world(self.resolution * np.stack([i, j], axis=-1))

    def place(self) -> dict[str, Any]:
        """All but the values, as plain data: resolution, origin, yaw."""
        return {"resolution": self.resolution, "origin": self.origin.tolist(), "yaw": self.yaw}

    def height(self, points: Array) -> Array:
        """Heights at points (n, 2) of the world, (n,), m; NaN off the map and where it is not known."""
        i, j, a, b = self._cell(points)
        z = self.values
        with np.errstate(invalid="ignore"):
            mixed = (
                _share(1 - a, 1 - b, z[i, j])
                + _share(a, 1 - b, z[i + 1, j])
                + _share(1 - a, b, z[i, j + 1])
                + _share(a, b, z[i + 1, j + 1])
            )
        return np.where(self.covers(points), mixed, np.nan)

    def slope(self, points: Array) -> Array:
        """Gradients at points (n, 2) of the world, (n, 2); NaN where the cell around is not all known."""
        i, j, a, b = self._cell(points)
        z = self.values
        along = (1 - b) * (z[i + 1, j] - z[i, j]) + b * (z[i + 1, j + 1] - z[i, j + 1])
        across = (1 - a) * (z[i, j + 1] - z[i, j]) + a * (z[i + 1, j + 1] - z[i + 1, j])
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        gradient = np.stack([along, across], axis=-1) @ np.array([[c, s], [-s, c]]) / self.resolution
        return np.where(self.covers(points)[:, None], gradient, np.nan)

    def covers(self, points: Array) -> NDArray[np.bool_]:
        """Which points (n, 2) of the world lie on the map, known or not."""
        local = self.to_local(points)
        slack = 1e-9 * (1.0 + np.abs(self.origin).max())  # rounding of coordinates, of UTM too
        return np.asarray(((local >= -slack) & (local <= self.size + slack)).all(axis=-1))

    def refined(self, count: int) -> HeightMap:
        """The same surface on a grid `count` times as fine."""
        if count == 1:
            return self
        shape = [count * (n - 1) + 1 for n in self.values.shape]
        i, j = np.meshgrid(*(np.arange(n) / count for n in shape), indexing="ij")
        points = self.to_world(self.resolution * np.stack([i, j], axis=-1))
        values = self.height(points.reshape(-1, 2)).reshape(points.shape[:2])
        return HeightMap(values, self.resolution / count, self.origin, self.yaw)

    def without_noise(self, noise: float | Literal["auto"]) -> HeightMap:
        """A copy without the noise of a sensor, of standard deviation `noise` (m); edges stay where they are.

        With `auto` it is estimated from the heights. What is not known stays so.
        """
        if noise == 0.0:
            return self
        from rollgait.terrain.noise import noise_of, without_noise  # here: it needs SciPy

        sigma = noise_of(self.values) if noise == "auto" else noise
        return HeightMap(without_noise(self.values, sigma), self.resolution, self.origin, self.yaw)

    def with_holes_filled(self, width: float) -> HeightMap:
        """A copy in which unknown holes up to `width` (m) across are filled from what is around them.

        A hole is a connected group of unknown nodes; how far across is the larger side of the box around it.
        Its nodes take the mean of their neighbours, over and over until nothing moves (Laplace's equation).
        Holes at the border of the map stay.
        """
        from scipy import ndimage  # here: a plan on flat ground loads none of it

        unknown = np.isnan(self.values)
        labels, _ = ndimage.label(unknown, structure=np.ones((3, 3)))
        fill = np.zeros_like(unknown)
        for k, box in enumerate(ndimage.find_objects(labels), start=1):
            sides = [self.resolution * (part.stop - part.start) for part in box]
            at_border = any(p.start == 0 or p.stop == n for p, n in zip(box, self.values.shape, strict=True))
            if max(sides) <= width * (1.0 + 1e-9) and not at_border:
                fill[box] |= labels[box] == k
        return self.with_values_at(fill, relaxed(self.values, fill)[fill]) if fill.any() else self

    def with_rests_filled(self, filled: NDArray[np.bool_]) -> HeightMap:
        """A copy in which what a filling (mask) left of holes is filled, where it is at most `REST` across.

        Single values that a sensor missed beside a large hole belong to it, and would stay as its rest.
        """
        from scipy import ndimage

        unknown = np.isnan(self.values)
        labels, _ = ndimage.label(unknown | filled, structure=np.ones((3, 3)))
        rest = unknown & np.isin(labels, labels[filled])
        whole = self.with_holes_filled(REST)
        return self.with_values(np.where(rest, whole.values, self.values))

    def with_values(self, values: Array) -> HeightMap:
        """The same grid with other heights, (nx, ny), m."""
        return HeightMap(values, self.resolution, self.origin, self.yaw)

    def with_values_at(self, where: NDArray[np.bool_], heights: ArrayLike) -> HeightMap:
        """A copy with other heights (m) at some nodes, given as a mask of the shape of `values`."""
        values = self.values.copy()
        values[where] = heights
        return HeightMap(values, self.resolution, self.origin, self.yaw)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of heights and places, as hexadecimal digits: equal maps have equal ones."""
        plain = np.where(np.isnan(self.values), np.nan, self.values + 0.0)  # one kind of NaN, and of 0
        place = np.array([self.resolution, *self.origin, self.yaw]) + 0.0
        result = hashlib.sha256(f"heights {plain.shape}".encode())
        for numbers in (place, plain):
            result.update(np.ascontiguousarray(numbers, dtype="<f8").tobytes())
        return result.hexdigest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, HeightMap) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def _cell(self, points: Array) -> tuple[NDArray[np.intp], NDArray[np.intp], Array, Array]:
        """The first node of the cell around each point, and where in the cell it lies, 0 to 1."""
        place = self.to_local(points) / self.resolution
        last = np.array(self.values.shape) - 2
        place = np.clip(np.nan_to_num(place), 0.0, last + 1.0)
        # A node reached by rounding is that node: its unknown neighbours have no say in its height.
        nearest = np.round(place)
        place = np.where(np.abs(place - nearest) < 1e-6, nearest, place)
        node = np.minimum(place.astype(np.intp), last)
        share = place - node
        return node[..., 0], node[..., 1], share[..., 0], share[..., 1]


def _share(a: Array, b: Array, z: Array) -> Array:
    """a b z, where a node of no weight counts nothing even if it is not known."""
    weight = a * b
    return np.where(weight == 0.0, 0.0, weight * z)


def relaxed(values: Array, fill: NDArray[np.bool_]) -> Array:
    """Values with the marked nodes at rest between their neighbours."""
    from scipy import ndimage

    known = ~np.isnan(values)
    nearest = ndimage.distance_transform_edt(~known, return_distances=False, return_indices=True)
    result = np.where(fill, values[tuple(nearest)], values)
    cross = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    usable = known | fill
    count = ndimage.convolve(usable.astype(float), cross, mode="constant")
    for _ in range(200):  # small holes: Gauss-Seidel on a few nodes is at rest long before
        total = ndimage.convolve(np.where(usable, result, 0.0), cross, mode="constant")
        after = np.where(fill, total / np.maximum(count, 1.0), result)
        change = np.abs(after[fill] - result[fill]).max()
        result = after
        if change < 1e-6:
            break
    return result


def _check(values: Array, resolution: float, origin: Array, yaw: float) -> None:
    if values.ndim != 2 or min(values.shape) < 2:
        raise InputError("ground.map", values.shape, "must be a grid of at least 2 × 2 heights")
    if values.size > MAX_CELLS:
        raise InputError("ground.map", values.shape, f"must have at most {MAX_CELLS} cells")
    if not (np.isfinite(resolution) and resolution >= RESOLUTION_MIN):
        raise InputError(
            "ground.map.resolution", resolution, f"must be a number of metres, at least {RESOLUTION_MIN:g}"
        )
    if origin.shape != (2,) or not np.isfinite(origin).all() or not np.isfinite(yaw):
        raise InputError("ground.map.origin", origin.tolist(), "must be two finite numbers, m")
    if np.isinf(values).any():
        raise InputError(
            "ground.map", "inf", "must have finite heights, or NaN where the ground is not known"
        )
    if np.isnan(values).all():
        raise InputError(
            "ground.map", values.shape, "must know the ground somewhere: all its heights are NaN"
        )
