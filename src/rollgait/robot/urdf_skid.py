"""Robots on fixed wheels whose legs give no way sideways turn where wheels slip: how fast they must."""

from __future__ import annotations

from typing import Final

import numpy as np

from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.robot.urdf_reach import PLANAR
from rollgait.robot.urdf_stance import Stance

TURN_RATE: Final = 0.1
"""rad/s, with which a robot shall turn by skidding: 90° in 20 s. Faster turns end farther from their plan."""
DIGITS: Final = 3
"""Of a speed in m/s."""


def slip_to_turn(model: WholeBodyModel, stance: Stance, sideways: float) -> float | None:
    """A limit of the lateral slip that lets a robot turn, m/s; None where it turns without, or has no wheels.

    Args:
        model: the whole body.
        stance: its nominal stance.
        sideways: half-width of the box that all feet reach, m.
    """
    fixed = all(chain.wheel is not None and chain.steering is None for chain in model.legs)
    if not fixed or sideways > PLANAR:
        return None
    heading = stance.state.heading
    ahead = stance.feet[:, 0] * np.cos(heading) + stance.feet[:, 1] * np.sin(heading)
    return round(TURN_RATE * float(np.abs(ahead).max()), DIGITS)
