"""The ground about a robot for all its wheels: rasters that are renewed as it moves on."""

from __future__ import annotations

import threading
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.mpc.ground.raster import KINDS, Raster
from rollgait.robot.robot import Robot
from rollgait.terrain.regions import regions_of
from rollgait.terrain.terrain import Terrain

Array = NDArray[np.float64]

RENEWED_AT: Final = 1.8
"""A raster is renewed when the robot is so near to its border, m: it takes half a second."""


class GroundAround:
    """What is known of the ground about a robot, at first about the origin.

    Args:
        terrain: the ground.
        robot: whose wheels.

    Attributes:
        radius: of the wheels, or of the balls of point feet, (4,), m.
    """

    def __init__(self, terrain: Terrain, robot: Robot) -> None:
        radii = [leg.wheel_radius or 0.0 for leg in robot.leg_list]
        self.radius: Array = np.array(radii)
        kinds = sorted(set(radii))
        self._regions = [regions_of(terrain, radius) for radius in kinds]
        self._kind = [kinds.index(radius) for radius in radii]
        self._coming: list[Raster] = []
        self._worker: threading.Thread | None = None
        self._rasters = self._made(np.zeros(2))

    def _made(self, centre: Array) -> list[Raster]:
        return [Raster.around(regions, centre) for regions in self._regions]

    def begin(self, place: Array) -> None:
        """Knows the ground about a place (2,), however long that takes."""
        if self._rasters[0].room_to_border(place) < RENEWED_AT:
            self._rasters = self._made(place)

    def follow(self, place: Array) -> None:
        """Has the ground about a place looked up by another thread, where what is known ends soon."""
        if self._worker is not None:
            if not self._worker.is_alive():
                self._worker, self._rasters = None, self._coming or self._rasters
        elif self._rasters[0].room_to_border(place) < RENEWED_AT:
            self._coming = []
            self._worker = threading.Thread(target=self._make_coming, args=(place.copy(),), daemon=True)
            self._worker.start()

    def _make_coming(self, place: Array) -> None:
        self._coming = self._made(place)

    def look(self, xy: Array) -> Array:
        """What is known under places (n, 4, 2) of the feet, (n, 4, 6); see `Raster.look`."""
        if len(self._rasters) == 1:
            return self._rasters[0].look(xy)
        result = np.empty((*xy.shape[:-1], KINDS))
        for leg in range(len(self._kind)):
            result[:, leg] = self.of(leg).look(xy[:, leg])
        return result

    def of(self, leg: int) -> Raster:
        """The raster for the foot of a leg."""
        return self._rasters[self._kind[leg]]
