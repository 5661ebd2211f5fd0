"""A robot in the middle of a motion: where it is, how it moves, and what its feet did last."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.plant.state import SHAPES, RobotState

if TYPE_CHECKING:
    from rollgait.plant.control import Control

Array = NDArray[np.float64]

MOVING_SHAPES: Final = {**SHAPES, "foot_velocity": (4, 3), "force": (4, 3), "contact": (4,)}
"""Shapes of the parts of a moving state."""


@dataclass(frozen=True, eq=False)
class MotionState(RobotState):
    """The state of a robot that moves: what a plan needs to go on from there.

    World frame, SI units, legs in the order FL, FR, HL, HR.

    Attributes: as of `RobotState`, and
        foot_velocity: ṗ_i, (4, 3), m/s.
        force: contact forces on the robot, now or last, (4, 3), N; None if nobody knows them.
        contact: which feet stand, (4,), bool.
    """

    foot_velocity: Array
    force: Array | None
    contact: NDArray[np.bool_]

    @classmethod
    def of(cls, state: RobotState, control: Control | None = None) -> MotionState:
        """A state, and what the robot was told last: its forces, contacts and how its feet move.

        Without a control all feet stand, wheels roll along their headings, and no force is known.
        """
        values = {f.name: getattr(state, f.name) for f in fields(RobotState)}
        if control is None:
            c, s = np.cos(state.heading), np.sin(state.heading)
            velocity = state.speed[:, None] * np.stack([c, s, np.zeros(len(c))], axis=-1)
            return cls(**values, foot_velocity=velocity, force=None, contact=np.ones(len(c), dtype=bool))
        velocity = (control.end.foot_position - control.begin.foot_position) / control.period
        velocity[control.contact, 2] = 0.0
        return cls(
            **values, foot_velocity=velocity, force=control.force.copy(), contact=control.contact.copy()
        )
