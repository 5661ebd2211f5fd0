"""Between the targets that drives are sent: a ramp to each, smoothed, step by step of the physics."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rollgait.simulation.controller import JointReference, MovingAverage
from rollgait.simulation.world import TIME_STEP
from rollgait.tracking.follower import JointTarget

Array = NDArray[np.float64]


class JointPath:
    """What the joints shall do at each step of the physics.

    Positions ramp evenly to a target and rest there; a torque holds from the moment it is told.

    Args:
        smoothing: width of the moving average that both go through, s; 0 for none.
        position: where the joints rest first, (n_j,), rad.
        torque: feed-forward there, (n_j,), N m.
    """

    def __init__(self, smoothing: float, position: Array, torque: Array) -> None:
        self._average = MovingAverage(max(1, round(smoothing / TIME_STEP)), 2 * len(position))
        self._average.fill(np.concatenate([position, torque]))
        self._placed = position.copy()
        self._ramp: Array = position[None].copy()
        self._torque: Array = torque
        self._next = 1

    @property
    def delay(self) -> float:
        """By how much the smoothing lets the joints lag behind, s."""
        return 0.5 * (self._average.width - 1) * TIME_STEP

    def aim(self, target: JointTarget, count: int) -> None:
        """From the next step on to a target, to be reached in so many steps."""
        share = np.arange(1, count + 1)[:, None] / count
        begin = self._ramp[self._next - 1]
        self._ramp = np.concatenate([begin[None], begin + share * (target.position - begin)])
        self._torque, self._next = target.torque, 1

    def take(self, count: int) -> JointReference:
        """The next steps, (count, n_j)."""
        rows = np.minimum(np.arange(self._next, self._next + count), len(self._ramp) - 1)
        self._next = min(self._next + count, len(self._ramp))
        position = self._ramp[rows]
        torque = np.broadcast_to(self._torque, position.shape)
        smooth = self._average.update(np.concatenate([position, torque], axis=1))
        position, torque = smooth[:, : position.shape[1]], smooth[:, position.shape[1] :]
        velocity = np.diff(position, axis=0, prepend=self._placed[None]) / TIME_STEP
        self._placed = position[-1]
        return JointReference(position, velocity, torque)
