"""A ground in numbers: how large it is, how high and steep, and how much of it a wheel can stand on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from rollgait.terrain.facet import FAR
from rollgait.terrain.polygons import Array
from rollgait.terrain.regions import Regions
from rollgait.terrain.terrain import Terrain

AROUND: Final = 1.0
"""So far around its parts a ground without a map is looked at, m."""
CELLS: Final = 400
"""Places along the longer side at which it is looked at."""


@dataclass(frozen=True)
class GroundFacts:
    """What one asks of a ground, over a rectangle.

    Attributes:
        low: smallest x and y, m.
        high: largest x and y, m.
        height_min, height_max: m; NaN where nothing is known.
        slope_median, slope_max: of the ground itself, risers left out, degrees.
        known: share that is known.
        standable: share of what is known on which a foot may stand.
        regions: into how many it falls between which the wheel cannot roll.
        radius: of the wheel, m.
    """

    low: tuple[float, float]
    high: tuple[float, float]
    height_min: float
    height_max: float
    slope_median: float
    slope_max: float
    known: float
    standable: float
    regions: int
    radius: float

    def to_dict(self) -> dict[str, Any]:
        """As plain data, lengths in m, angles in degrees."""
        size = [b - a for a, b in zip(self.low, self.high, strict=True)]
        return {
            "low": list(self.low),
            "high": list(self.high),
            "size": size,
            "height": {"min": self.height_min, "max": self.height_max},
            "slope_deg": {"median": self.slope_median, "max": self.slope_max},
            "known": self.known,
            "standable": self.standable,
            "regions": self.regions,
            "wheel_radius": self.radius,
        }


def extent_of(terrain: Terrain) -> tuple[Array, Array]:
    """The rectangle in which something is to be seen: smallest and largest (x, y), (2,) each, m.

    Of a map all of it; of parts all that ends somewhere, with some ground around.
    """
    if terrain.map is not None:
        corners = terrain.map.corners
        return corners.min(axis=0), corners.max(axis=0)
    places = [np.zeros((1, 2))]
    for part in terrain.parts:
        ends = [s for begin, length, *_ in part.pieces() for s in (begin, begin + length) if abs(s) < FAR]
        sides = np.array([-0.5, 0.5]) * (part.across if part.across < FAR else 0.0)
        along, across = (part.yaw + turn for turn in (0.0, 0.5 * np.pi))
        local = np.stack(np.meshgrid(ends, sides), axis=-1).reshape(-1, 2)
        axes = np.array([[np.cos(along), np.sin(along)], [np.cos(across), np.sin(across)]])
        places.append(np.array([part.x, part.y]) + local @ axes)
    every = np.concatenate(places)
    return every.min(axis=0) - AROUND, every.max(axis=0) + AROUND


def facts_of(regions: Regions, low: Array, high: Array) -> GroundFacts:
    """Looks at the ground in a rectangle.

    Args:
        regions: of the wheel.
        low: smallest x and y, (2,), m.
        high: largest x and y, (2,), m.
    """
    step = float((high - low).max()) / CELLS
    x, y = (np.arange(a + 0.5 * step, b, step) for a, b in zip(low, high, strict=True))
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    height = regions.terrain.height(*points.T)
    slope = np.degrees(np.arctan(np.linalg.norm(regions.terrain.slope(*points.T), axis=-1)))
    labels = regions.label(points)
    known = np.isfinite(height)
    measured = slope[np.isfinite(slope)]
    return GroundFacts(
        low=(float(low[0]), float(low[1])),
        high=(float(high[0]), float(high[1])),
        height_min=float(height[known].min()) if known.any() else float("nan"),
        height_max=float(height[known].max()) if known.any() else float("nan"),
        slope_median=float(np.median(measured)) if measured.size else float("nan"),
        slope_max=float(measured.max()) if measured.size else float("nan"),
        known=float(known.mean()),
        standable=float((labels[known] >= 0).mean()) if known.any() else 0.0,
        regions=len(np.unique(labels[labels >= 0])),
        radius=regions.surface.radius,
    )
