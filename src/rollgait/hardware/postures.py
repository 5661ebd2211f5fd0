"""From any posture to the stance and down again: postures on the way, and bounded motion through them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.config import Config, Positive
from rollgait.dynamics.step import rotation
from rollgait.errors import InputError
from rollgait.plant.stance import standing_state
from rollgait.robot.robot import LEG_NAMES, Robot
from rollgait.robot.urdf_model import BASE_V, WholeBodyModel
from rollgait.tracking.kinematics import InverseKinematics
from rollgait.tracking.tasks import Target

Array = NDArray[np.float64]

RISE_STEP: Final = 0.01
"""By how much the base is higher from one posture to the next, m."""


class RiseSettings(Config):
    """How fast the robot comes up and lies down."""

    speed: Positive = 0.25
    """Largest speed of a joint, rad/s."""
    settle: Positive = 0.5
    """How long it then stands before control begins, s."""


@dataclass(frozen=True, eq=False)
class Rise:
    """Postures of the joints, (n, n_j), rad, from the lowest to the stance, feet at their places.

    Attributes:
        postures: wheels turn by nothing.
        wheels: places of the wheels' joints: they stay as they were measured.
    """

    postures: Array
    wheels: tuple[int, ...]

    def way_up(self, measured: Array) -> Array:
        """From measured joints, (n_j,), over the nearest posture up to the stance, (m, n_j), rad."""
        ways = self._with_wheels(measured)
        others = np.ones(len(measured), dtype=bool)
        others[list(self.wheels)] = False
        away = np.abs(ways - measured)[:, others].max(axis=1)
        return np.vstack([measured, ways[int(away.argmin()) :]])

    def way_down(self, told: Array) -> Array:
        """From joints as they were told last, (n_j,), by the stance to the lowest posture, (m, n_j), rad."""
        return np.vstack([told, self._with_wheels(told)[::-1]])

    def _with_wheels(self, joints: Array) -> Array:
        ways = self.postures.copy()
        ways[:, list(self.wheels)] = joints[list(self.wheels)]
        return ways


def rise_of(model: WholeBodyModel, robot: Robot) -> Rise:
    """The postures in which the base sinks from its stance as far as the legs let it.

    Raises:
        InputError: the robot cannot even stand.
    """
    kinematics, state = InverseKinematics(model), standing_state(robot)
    postures: list[Array] = []
    for step in range(int(robot.height / RISE_STEP)):
        lower = replace(state, com_position=state.com_position - [0.0, 0.0, step * RISE_STEP])
        R: Array = np.array(rotation(np, lower.euler.tolist()))
        still = np.zeros(len(LEG_NAMES))
        target = Target(lower.com_position, R, lower.foot_position, lower.heading, still)
        try:
            found = kinematics.stand(target)
        except InputError:
            if not postures:
                raise
            break
        postures.append(np.array(found.q[BASE_V + 1 :]))
    wheels = tuple(leg.wheel - BASE_V for leg in model.legs if leg.wheel is not None)
    return Rise(np.array(postures[::-1]), wheels)


class JointMotion:
    """Through postures one after the other, each way as slow as its farthest joint needs.

    Args:
        postures: (n, n_j), rad, the first is where the joints are.
        speed: largest of any joint, rad/s.
    """

    def __init__(self, postures: Array, speed: float) -> None:
        self._postures = postures
        ways = np.abs(np.diff(postures, axis=0)).max(axis=1, initial=0.0)
        self._times = np.concatenate([[0.0], np.cumsum(ways / speed)])

    @property
    def duration(self) -> float:
        """s."""
        return float(self._times[-1])

    def at(self, time: float) -> Array:
        """The joints at a time from the beginning on, (n_j,), rad."""
        k = int(np.clip(np.searchsorted(self._times, time, side="right") - 1, 0, len(self._times) - 2))
        length = self._times[k + 1] - self._times[k]
        share = (time - self._times[k]) / length if length > 0.0 else 1.0
        share = float(np.clip(share, 0.0, 1.0))
        return np.asarray(self._postures[k] + share * (self._postures[k + 1] - self._postures[k]))
