"""Ground that is level under each foot, and what the controller asks of any ground."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.ground import FootGround
from rollgait.mpc.clock import GaitClock

Array = NDArray[np.float64]

UP = np.tile([0.0, 0.0, 1.0], (4, 1))
"""Normals of level ground, (4, 3)."""


class GroundUnderfoot(Protocol):
    """The ground under the feet as a step of the controller needs it."""

    def begin(self, xy: Array) -> None:
        """A robot begins anew, its feet at places (4, 2), m."""

    def foot_heights(self, clock: GaitClock, times: Array, xy: Array) -> tuple[Array, Array]:
        """z of the lowest points of the feet, (n, 4), m, and how fast they rise over the ground, m/s.

        Args:
            clock: which foot is in the air when.
            times: (n,), s.
            xy: their places, (n, 4, 2) or (4, 2), m.
        """

    def under(self, clock: GaitClock, time: float, xy: Array, z: Array) -> Sequence[FootGround] | None:
        """The ground of each foot at a time at places (4, 2) and heights (4,); None where it is level."""

    def normals(self, contact: NDArray[np.bool_], xy: Array) -> Array:
        """Unit normals where feet stand at places (4, 2), upwards elsewhere, (4, 3)."""

    def touch(self, contact: NDArray[np.bool_], xy: Array, heading: Array) -> tuple[Array, Array] | None:
        """Where forces act, from the lowest points of the rims, (4, 3), m, and the ways of wheels along the
        ground over those in the plane, (4,), where feet stand at places (4, 2); None where it is level."""

    def tilt(self, xy: Array, yaw: float) -> tuple[float, float]:
        """Pitch and roll that it asks of a base with feet at places (4, 2), rad."""


class LevelGround:
    """Ground that is level under each foot, of any height.

    Attributes:
        height: under each foot, (4,), m: change it at any time.
    """

    def __init__(self, height: Array | None = None) -> None:
        self.height: Array = np.zeros(4) if height is None else height

    def begin(self, xy: Array) -> None:
        pass

    def foot_heights(self, clock: GaitClock, times: Array, xy: Array) -> tuple[Array, Array]:
        height, rate = clock.lift(times)
        return self.height + height, rate

    def under(self, clock: GaitClock, time: float, xy: Array, z: Array) -> Sequence[FootGround] | None:
        return None

    def normals(self, contact: NDArray[np.bool_], xy: Array) -> Array:
        return UP

    def touch(self, contact: NDArray[np.bool_], xy: Array, heading: Array) -> tuple[Array, Array] | None:
        return None

    def tilt(self, xy: Array, yaw: float) -> tuple[float, float]:
        return (0.0, 0.0)
