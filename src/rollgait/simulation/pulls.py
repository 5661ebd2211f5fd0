"""Planned wrenches in MuJoCo: what pulls at the base link, millisecond by millisecond."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.robot.loads import Wrench
from rollgait.robot.standing_com import com_in_base
from rollgait.robot.whole_body import WholeBody

Array = NDArray[np.float64]


class Pulls:
    """What pulls at the base link of a robot.

    Args:
        body: the whole body, whose CoM without loads is the origin of all places.
        wrenches: what acts, from time 0 on.
    """

    def __init__(self, body: WholeBody, wrenches: Sequence[Wrench]) -> None:
        self._wrenches = tuple(wrenches)
        self._origin = com_in_base(body) if wrenches else np.zeros(3)

    def __bool__(self) -> bool:
        return bool(self._wrenches)

    def at(self, time: float, data: Any, base: int) -> Array:
        """Force, N, and torque about the centre of mass of the base link's own body, N m, world, (6,).

        Args:
            time: s.
            data: MuJoCo's data: where the base link is.
            base: number of its body.
        """
        total = np.zeros(6)
        R_world_base = data.xmat[base].reshape(3, 3)
        for wrench in self._wrenches:
            if not wrench.acts_at(time):
                continue
            force, torque = np.array(wrench.force), np.array(wrench.torque)
            if wrench.frame == "base":
                force, torque = R_world_base @ force, R_world_base @ torque
            place = data.xpos[base] + R_world_base @ (self._origin + np.array(wrench.at))
            total[:3] += force
            total[3:] += torque + np.cross(place - data.xipos[base], force)
        return total
