"""How high and how tilted the base should stand over its feet."""

from __future__ import annotations

from typing import Final

import numpy as np

from rollgait.plan.certificate.case import Case
from rollgait.plan.samples import Samples

TILT_SHARE: Final = 0.6
"""Share of the slope under its feet that the base takes (docs/terrain.md)."""


def wanted_pose(case: Case, at: Samples) -> tuple[float, float, float]:
    """The height (m) over which the CoM should be at its nominal one, and pitch and roll (rad).

    Args:
        case: says whether the ground is flat: then it is the height of that, and level.
        at: one sample, (1, …): of this the feet on the ground and the yaw count.
    """
    if case.terrain is None:
        return case.scenario.ground.height, 0.0, 0.0
    feet, yaw = at.foot_position[0], float(at.euler[0, 0])
    spread = feet - feet.mean(axis=0)
    slope = np.linalg.pinv(spread[:, :2], rcond=1e-9) @ spread[:, 2]
    rise_ahead = slope[0] * np.cos(yaw) + slope[1] * np.sin(yaw)
    rise_left = slope[1] * np.cos(yaw) - slope[0] * np.sin(yaw)
    pitch, roll = -np.arctan(rise_ahead), np.arctan(rise_left)
    return float(feet[:, 2].mean()), TILT_SHARE * float(pitch), TILT_SHARE * float(roll)
