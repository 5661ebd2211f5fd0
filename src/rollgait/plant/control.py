"""What a controller asks of the robot until its next step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollgait.plant.state import RobotState

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Control:
    """What the robot shall do for one period: from one state to another with constant forces and motions.

    Attributes:
        begin, end: where everything shall be at the ends of the period.
        force: f_i on the robot, (4, 3), N; 0 in swing.
        motion: (v_i, σ̇_i), (4, 2), m/s and rad/s.
        contact: which feet stand on the ground, (4,).
        contact_offset: from the lowest points of the rims to where the forces act, (4, 3), m; None on level
            ground, where they are one.
        way_factor: way of each wheel along the ground over its way in the plane, (4,); None on level ground.
    """

    begin: RobotState
    end: RobotState
    force: Array
    motion: Array
    contact: NDArray[np.bool_]
    contact_offset: Array | None = None
    way_factor: Array | None = None

    @property
    def period(self) -> float:
        """Its length, s."""
        return self.end.time - self.begin.time
