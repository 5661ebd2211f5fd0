"""What terms may ask when they give their numbers: protocols, so that terms know no problem that has them."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.footing.beneath import Beneath
from rollgait.footing.footing import Footing
from rollgait.robot.robot import Robot
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule

Array = NDArray[np.float64]


class Context(Protocol):
    """What a term may ask of planner and controller alike; one that asks nothing else serves both."""

    @property
    def robot(self) -> Robot:
        """The robot."""

    @property
    def schedule(self) -> ContactSchedule:
        """Which foot is on the ground when, and the intervals."""

    @property
    def goals(self) -> Array:
        """Wanted pose (x, y, z, yaw, pitch, roll) of each interval, (6, N), m and rad."""

    def friction_at(self, leg: int) -> ArrayLike:
        """μ that the force of a foot may use: one for all the horizon, or by interval, (N,)."""

    def bound(self, name: str) -> Any:
        """A bound by its key, as the scenario or the settings have it; None if there is none."""

    def speed_max(self, leg: int) -> float:
        """Limit of |v| of a foot in stance, m/s."""

    def steering_rate_max(self, leg: int) -> float:
        """Limit of |σ̇| of a foot, rad/s."""

    def steering_range(self, leg: int) -> tuple[float, float]:
        """Range of σ − θz of a foot, rad."""


class PlanContext(Context, Protocol):
    """What only the planner knows; `Problem` is one."""

    @property
    def scenario(self) -> Scenario:
        """What is asked."""

    @property
    def footing(self) -> Footing:
        """The ground under each foot in each interval."""

    @property
    def beneath(self) -> Beneath:
        """Where body and legs come near the ground."""

    @property
    def lift_rate(self) -> Array:
        """Vertical speed of the smooth lift at the height points, (points, 4, N), m/s."""
