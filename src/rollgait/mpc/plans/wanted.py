"""What a horizon shall look like that follows a plan, or holds one of its poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollgait.mpc.reference import Reference

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Wanted:
    """References of the N + 1 nodes and N intervals of a horizon.

    Attributes:
        reference: pose, velocities, headings and speeds of wheels.
        tilt: pitch and roll, (2, N + 1), rad.
        climb: vertical velocity of the CoM, (N + 1,), m/s.
        foot_position: (N + 1, 4, 3), m, world.
        com_position: that goes with them, (N + 1, 3), m.
        in_air: which feet are to swing at the nodes, (N + 1, 4).
        force: mean of each interval, (N, 4, 3), N.
        waits: which feet wait for the ground, (4,): they go straight down, as hardly anything is left of
            their swings to find a motion for.
        landed: speeds of feet that have just landed, (4,), m/s: with these, those that waited go on.
        lead: forces (4, 3), N, and motions (4, 2) of now less their means over the first interval: what is
            found for all of it would come early by half of its length.
        rests: whether the robot shall stand where its feet are.
    """

    reference: Reference
    tilt: Array
    climb: Array
    foot_position: Array
    com_position: Array
    in_air: NDArray[np.bool_]
    force: Array
    waits: NDArray[np.bool_]
    landed: Array
    lead: tuple[Array, Array]
    rests: bool = False
