"""What every plant is for who controls it."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rollgait.plant.control import Control
from rollgait.plant.state import RobotState

Array = NDArray[np.float64]


class Plant(Protocol):
    """What is controlled: a model, a simulated robot, a recording. Time passes only in `step`."""

    name: str

    @property
    def state(self) -> RobotState:
        """The true state now."""

    @property
    def fallen(self) -> bool:
        """Whether the robot has fallen; it stays so."""

    def step(self, control: Control) -> None:
        """Lets one period pass under a control."""

    def push(self, force: Array, duration: float) -> None:
        """From now on a force on the base, (3,), N, world, for a time, s."""
