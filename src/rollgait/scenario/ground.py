"""What the robot stands on. Terrain will be further kinds beside `flat`."""

from __future__ import annotations

from typing import Literal

from rollgait.config import Config, Number, Positive


class FlatGround(Config):
    """A horizontal plane."""

    kind: Literal["flat"] = "flat"
    """Kind of the ground."""
    height: Number = 0.0
    """z of the plane in the world, m."""
    friction: Positive = 0.5
    """μ, coefficient of friction."""


Ground = FlatGround
