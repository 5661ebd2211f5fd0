"""What a robot carries and what pulls at it, as plan, certificate, controller and simulated world know it.

Places are in the base frame of the robot without its loads: its origin at the CoM of that robot, standing in
its nominal stance. So they do not depend on what else is carried. What no plan knows is a disturbance
(`rollgait.plant.disturbances`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from rollgait.config import Config, NonNegative, Number, Positive, PositiveVector3, Vector3

Array = NDArray[np.float64]

Frame = Literal["world", "base"]
"""Axes in which a wrench stays the same: those of the world, or those of the base, with which it turns."""


class Load(Config):
    """A mass that is fixed to the base and carried all the time."""

    mass: Positive
    """kg."""
    at: Vector3 = (0.0, 0.0, 0.0)
    """Its centre, in the base frame of the robot without its loads (origin at that robot's CoM), m."""
    size: PositiveVector3 | None = None
    """Edges of a box of even density along the base axes, m; a point if not given."""

    def inertia(self) -> Array:
        """About its own centre, base axes, (3, 3), kg·m²."""
        square = np.square(self.size if self.size is not None else (0.0, 0.0, 0.0))
        return np.asarray(self.mass / 12.0 * np.diag(square.sum() - square))


class Wrench(Config):
    """A force and a torque on the base, constant for a while: a cart that is pulled, an arm that pushes."""

    force: Vector3 = (0.0, 0.0, 0.0)
    """On the robot, N."""
    torque: Vector3 = (0.0, 0.0, 0.0)
    """On the robot, beside that of the force, N·m."""
    at: Vector3 = (0.0, 0.0, 0.0)
    """Where the force acts, fixed to the base, from the CoM of the robot without its loads, base axes, m."""
    frame: Frame = "world"
    """Axes of force and torque: `world`, or `base`, with which they turn."""
    start: NonNegative = 0.0
    """From when on it acts, s; a plan takes the nearest node of its mesh."""
    end: Positive | None = None
    """Until when, s, likewise; to the end and beyond if not given."""

    @model_validator(mode="after")
    def _acts(self) -> Wrench:
        if not any((*self.force, *self.torque)):
            raise ValueError("must have a force or a torque that is not zero")
        if self.end is not None and self.end <= self.start:
            raise ValueError(f"must end after it starts: {self.end:g} s is not after {self.start:g} s")
        return self

    def acts_at(self, times: Any) -> Any:
        """Whether it acts at times, s, any shape."""
        return (times >= self.start) & (times < (np.inf if self.end is None else self.end))

    def share_of(self, begins: Array, ends: Array) -> Array:
        """Which part of each stretch of time it acts in, (n,), from 0 to 1."""
        last = np.inf if self.end is None else self.end
        overlap = np.minimum(ends, last) - np.maximum(begins, self.start)
        return np.asarray(np.clip(overlap / (ends - begins), 0.0, 1.0))


class Loads(Config):
    """What the robot carries, and what pulls at it."""

    payload: tuple[Load, ...] = ()
    """What is fixed to the base: one mapping, or a list of them."""
    wrench: tuple[Wrench, ...] = ()
    """Forces and torques on the base: one mapping, or a list of them; they add up."""
    posture: dict[str, Number] = Field(default_factory=dict)
    """Angles of joints of no leg, as arms have, by their names in the URDF, rad; needs the whole body."""

    @field_validator("payload", "wrench", mode="before")
    @classmethod
    def _one_is_a_list(cls, value: Any) -> Any:
        return (value,) if isinstance(value, Mapping | Load | Wrench) else value

    def __hash__(self) -> int:
        return hash((self.payload, self.wrench, frozenset(self.posture.items())))


def steiner(offset: Array) -> Array:
    """Inertia of 1 kg at an offset, (3, 3), m²."""
    return np.asarray(offset @ offset * np.eye(3) - np.outer(offset, offset))


def com_offset(mass: float, loads: Iterable[Load]) -> Array:
    """From the CoM of a robot without its loads to that with them, base axes, (3,), m.

    Args:
        mass: of all together, kg.
        loads: what is carried.
    """
    return np.asarray(sum((load.mass / mass * np.array(load.at) for load in loads), start=np.zeros(3)))
