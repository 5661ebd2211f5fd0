"""The ground: parts, maps, and what a wheel can do on them. Knows no CasADi and no solver."""

from typing import TYPE_CHECKING

from rollgait.lazy import lazy_names

if TYPE_CHECKING:
    from rollgait.terrain.convex_region import ConvexRegion
    from rollgait.terrain.ground import Ground
    from rollgait.terrain.height_map import HeightMap
    from rollgait.terrain.local_model import LocalModel
    from rollgait.terrain.parts import Block, Gap, Ramp, Stairs, Step
    from rollgait.terrain.references import BaseReference, base_reference
    from rollgait.terrain.regions import Regions, regions_of
    from rollgait.terrain.standing import require_standing
    from rollgait.terrain.terrain import Terrain
    from rollgait.terrain.wheel_surface import WheelSurface

__all__ = [
    "BaseReference",
    "Block",
    "ConvexRegion",
    "Gap",
    "Ground",
    "HeightMap",
    "LocalModel",
    "Ramp",
    "Regions",
    "Stairs",
    "Step",
    "Terrain",
    "WheelSurface",
    "base_reference",
    "regions_of",
    "require_standing",
]

if not TYPE_CHECKING:  # every scenario has a ground; what needs SciPy is loaded where the ground is not flat
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "BaseReference": "references",
            "Block": "parts",
            "ConvexRegion": "convex_region",
            "Gap": "parts",
            "Ground": "ground",
            "HeightMap": "height_map",
            "LocalModel": "local_model",
            "Ramp": "parts",
            "Regions": "regions",
            "Stairs": "parts",
            "Step": "parts",
            "Terrain": "terrain",
            "WheelSurface": "wheel_surface",
            "base_reference": "references",
            "regions_of": "regions",
            "require_standing": "standing",
        },
    )
