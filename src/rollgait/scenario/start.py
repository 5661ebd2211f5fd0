"""Where a motion begins: standing at a place, or in the middle of a motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from rollgait.angles import turned
from rollgait.config import Config, Number, Vector3

Array = NDArray[np.float64]
FourNumbers = tuple[Number, Number, Number, Number]
FourVectors = tuple[Vector3, Vector3, Vector3, Vector3]

SAME_PLACE: Final = 1e-6
"""By how much a place that is said twice may differ, m and degrees: rounding."""


class Headings(Config):
    """Headings of the wheels relative to the base, degrees."""

    FL: Number = 0.0
    """Front left, degrees."""
    FR: Number = 0.0
    """Front right, degrees."""
    HL: Number = 0.0
    """Hind left, degrees."""
    HR: Number = 0.0
    """Hind right, degrees."""


class Motion(Config):
    """A robot that moves, in the world; feet in the order FL, FR, HL, HR."""

    com_position: Vector3
    """CoM, m."""
    euler: Vector3
    """Yaw, pitch and roll of the base, rad."""
    com_velocity: Vector3 = (0.0, 0.0, 0.0)
    """Velocity of the CoM, m/s."""
    euler_rate: Vector3 = (0.0, 0.0, 0.0)
    """Rates of yaw, pitch and roll, rad/s."""
    foot_position: FourVectors
    """Lowest points of the feet, m."""
    foot_velocity: FourVectors = ((0.0, 0.0, 0.0),) * 4
    """Their velocities, m/s."""
    heading: FourNumbers
    """Headings of the wheels in the world, rad; not reduced."""
    speed: FourNumbers = (0.0, 0.0, 0.0, 0.0)
    """Speeds of the wheels along their headings, m/s."""
    force: FourVectors | None = None
    """Contact forces on the robot just before, N. Default: nobody knows them."""

    @property
    def feet(self) -> Array:
        """`foot_position` as an array, (4, 3), m."""
        return np.array(self.foot_position)

    @property
    def place(self) -> tuple[float, float, float]:
        """x and y of the CoM, m, and yaw, degrees."""
        return (self.com_position[0], self.com_position[1], math.degrees(self.euler[0]))


class Start(Config):
    """Where the robot is at t = 0: at rest, level, its feet at their nominal places, or in `motion`."""

    x: Number = 0.0
    """x of the CoM, m."""
    y: Number = 0.0
    """y of the CoM, m."""
    yaw_deg: Number = 0.0
    """Yaw of the base, degrees."""
    heading_deg: Headings = Headings()
    """σ − θz of the wheels, degrees."""
    motion: Motion | None = None
    """How it moves at t = 0; x, y and yaw are those of the motion then, and so are headings."""

    @model_validator(mode="before")
    @classmethod
    def _place_of_motion(cls, data: Any) -> Any:
        """Fills in the place of a motion, which need not be said twice, and refuses another one."""
        if not isinstance(data, Mapping) or data.get("motion") is None:
            return data
        motion = data["motion"]
        if not isinstance(motion, Motion):
            motion = Motion.model_validate(motion)
        own = dict(zip(("x", "y", "yaw_deg"), motion.place, strict=True))
        for name, value in own.items():
            given = data.get(name, value)
            if isinstance(given, int | float) and abs(given - value) > SAME_PLACE:
                raise ValueError(f"must have the {name} of its motion, {value:.6g}, or none, not {given:.6g}")
        return {**data, **own, "motion": motion}

    def feet(self, stance: Array) -> Array:
        """Places of the feet in the plane, (4, 2), m: of the motion, or the nominal ones of `stance`."""
        if self.motion is not None:
            return self.motion.feet[:, :2]
        return np.array([self.x, self.y]) + turned(stance, math.radians(self.yaw_deg))[:, :2]
