"""The ground: parts, maps, and what a wheel can do on them. Knows no CasADi and no solver."""

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
