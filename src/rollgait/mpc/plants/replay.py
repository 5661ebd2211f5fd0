"""A recorded run as a plant: the states go on as they were, whatever the controller asks for."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.mpc.log import MpcLog
from rollgait.plant.control import Control
from rollgait.plant.state import RobotState

Array = NDArray[np.float64]

_STATE: Final = tuple(field.name for field in fields(RobotState) if field.name != "time")
"""Names of the arrays of a state, which a log has too."""


class Replay:
    """Shows a controller the states of a log: what would it have done there?

    Between the rows of the log, states are interpolated; after the last one, the robot rests where it is.

    Args:
        log: the recording.

    Attributes:
        name: `replay`.
        joint_names: of the whole body; empty if the recording has none.
    """

    name = "replay"

    def __init__(self, log: MpcLog) -> None:
        self.joint_names = log.joint_names
        self._log = log
        self._time = float(log.time[0])
        self._state = self._at(self._time)

    @property
    def duration(self) -> float:
        """Length of the recording, s."""
        return float(self._log.time[-1] - self._log.time[0]) + self._log.period

    @property
    def state(self) -> RobotState:
        """The recorded state now."""
        return self._state

    @property
    def fallen(self) -> bool:
        """Whether the robot had fallen by now."""
        fallen_at = self._log.fallen_at
        return fallen_at is not None and self._time > fallen_at - 1e-9

    @property
    def pose(self) -> tuple[Array, Array, Array] | None:
        """Base position (3,) and quaternion (4,) and joint positions of the whole body; None without one."""
        if not self.joint_names:
            return None
        log = self._log
        row = int(np.clip(np.searchsorted(log.time, self._time - 0.5 * log.period), 0, log.time.size - 1))
        return log.base_position[row], log.base_quaternion[row], log.joint_position[row]

    def step(self, control: Control) -> None:
        """Lets one period pass; what is asked for has no effect."""
        self._time += control.period
        self._state = self._at(self._time)

    def push(self, force: Array, duration: float) -> None:
        """Has no effect: what happened has happened."""

    def _at(self, time: float) -> RobotState:
        log = self._log
        rests = time > log.time[-1] + log.period
        after = int(np.clip(np.searchsorted(log.time, time), 1, max(1, log.time.size - 1)))
        before = min(after - 1, log.time.size - 1)
        after = min(after, log.time.size - 1)
        length = float(log.time[after] - log.time[before])
        share = float(np.clip((time - log.time[before]) / length, 0.0, 1.0)) if length > 0.0 else 0.0
        values: dict[str, Any] = {}
        for name in _STATE:
            rows = getattr(log, name)
            values[name] = (1.0 - share) * rows[before] + share * rows[after]
            if rests and name in ("com_velocity", "euler_rate", "speed"):
                values[name] = np.zeros_like(values[name])
        return RobotState(time=time, **values)
