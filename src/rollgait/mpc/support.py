"""Whether the feet that stay on the ground can carry the robot when others leave it."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.mpc.clock import GaitClock
from rollgait.plant.state import RobotState
from rollgait.robot.robot import GRAVITY

Array = NDArray[np.float64]

READY_MARGIN: Final = 0.0
"""m: how far inside the support the CoM, moving as it does, must be before a foot leaves the ground."""
HOLD_MAX: Final = 0.5
"""So long a step is put off at most, s."""


class StepHold:
    """Lets a foot stay on the ground while the others could not carry the robot yet.

    Args:
        period: of the controller, s.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._held = 0.0

    def reset(self) -> None:
        """The next step may be put off for the full time again."""
        self._held = 0.0

    def apply(self, clock: GaitClock, state: RobotState) -> None:
        """Puts off what the clock would lift within a period, if need be."""
        pending = clock.pending(state.time, self._period)
        if not pending:
            return
        standing = clock.contact(state.time)
        standing[pending] = False
        if support_margin(state, standing) < READY_MARGIN and self._held < HOLD_MAX:
            self._held += self._period
            clock.hold(self._period)
        else:
            self._held = 0.0


def support_margin(state: RobotState, standing: NDArray[np.bool_]) -> float:
    """Distance of the capture point from the edge of the support polygon, m; negative outside.

    The capture point is where the CoM would come to rest over its support, r + ṙ √(z / g). With fewer than
    three feet there is no polygon: infinite.

    Args:
        state: of the robot.
        standing: which feet are to carry it, (4,).
    """
    if int(standing.sum()) < 3:
        return float("inf")
    z = float(state.com_position[2] - state.foot_position[standing, 2].mean())
    capture = state.com_position[:2] + state.com_velocity[:2] * np.sqrt(max(z, 0.0) / GRAVITY)
    capture = capture - _common_velocity(state, standing) * np.sqrt(max(z, 0.0) / GRAVITY)
    p = state.foot_position[standing, :2]
    centre = p.mean(axis=0)
    p = p[np.argsort(np.arctan2(*(p - centre).T[::-1]))]
    edge = np.roll(p, -1, axis=0) - p
    to_point = capture - p
    across = edge[:, 0] * to_point[:, 1] - edge[:, 1] * to_point[:, 0]
    return float((across / np.linalg.norm(edge, axis=1)).min())


def _common_velocity(state: RobotState, standing: NDArray[np.bool_]) -> Array:
    """With which the support rolls along, (2,), m/s."""
    direction = np.column_stack([np.cos(state.heading), np.sin(state.heading)])
    return np.asarray((state.speed[:, None] * direction)[standing].mean(axis=0))
