"""What terms may ask of a controller: the same as of a problem that is planned."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.mpc.settings import MpcSettings
from rollgait.robot.robot import Robot
from rollgait.scenario.mesh import Mesh
from rollgait.scenario.schedule import ContactSchedule

Array = NDArray[np.float64]


@dataclass
class LiveContext:
    """A `rollgait.ocp.term.Context` whose numbers change as time goes on.

    Attributes:
        robot: the robot.
        settings: of the controller.
        contact: which foot has ground under it in which interval of the horizon, (4, N).
        goals: reference pose (x, y, z, yaw, pitch, roll) of each interval, (6, N), m and rad.
    """

    robot: Robot
    settings: MpcSettings
    contact: NDArray[np.bool_] = field(init=False)
    goals: Array = field(init=False)

    def __post_init__(self) -> None:
        self.contact = np.ones((4, self.settings.intervals), dtype=bool)
        self.goals = np.zeros((6, self.settings.intervals))

    @property
    def schedule(self) -> ContactSchedule:
        """The contacts of the horizon, from now on."""
        return ContactSchedule(self.contact, Mesh.equal(self.settings.horizon, self.settings.intervals))

    def friction_at(self, leg: int) -> float:
        """μ that the force of a foot may use."""
        return self.settings.bounds.friction

    def bound(self, name: str) -> Any:
        """A bound of the settings by its key; None if they have none of that name."""
        return getattr(self.settings.bounds, name, None)

    def speed_max(self, leg: int) -> float:
        """Limit of |v| of a foot in stance, m/s."""
        return min(self.settings.bounds.speed_max, self.robot.leg_list[leg].speed_max)

    def steering_rate_max(self, leg: int) -> float:
        """Limit of |σ̇| of a foot, rad/s."""
        return min(self.settings.bounds.steering_rate_max, self.robot.leg_list[leg].steering_rate_max)

    def steering_range(self, leg: int) -> tuple[float, float]:
        """Range of σ − θz of a foot, rad."""
        low, high = self.robot.leg_list[leg].steering
        return float(low), float(high)
