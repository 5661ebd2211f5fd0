"""From the plan to what the robot does now: the first inputs, within what a robot may be asked for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rollgait.mpc.clock import GaitClock
from rollgait.mpc.filling import Filling
from rollgait.mpc.iterate import Iterate
from rollgait.mpc.plans.wanted import Wanted
from rollgait.mpc.standing import within_cone
from rollgait.plant.control import Control
from rollgait.transcription.layout import StageLayout

Array = NDArray[np.float64]


def first_inputs(
    iterate: Iterate,
    layout: StageLayout,
    fill: Filling,
    clock: GaitClock,
    contact: NDArray[np.bool_],
    now: float,
    period: float,
    previous: Control | None,
    normals: Array,
    wanted: Wanted | None = None,
) -> tuple[Array, Array]:
    """Forces (4, 3), N, and motions (4, 2) of the plan now. Speeds change no faster than the bounds allow.

    Args:
        iterate: the plan.
        layout: of its inputs.
        fill: bounds, and the robot's figures.
        clock: which wheels are locked.
        contact: which feet stand, (4,).
        now: s.
        period: of the controller, s.
        previous: the control before, if there was one.
        normals: of the ground under the feet, (4, 3).
        wanted: by the plan that is followed.
    """
    bounds = fill.bounds
    u = iterate.inputs[0]
    force = contact[:, None] * u[layout.inputs["force"]].reshape(4, 3) * fill.robot.weight
    motion = u[layout.inputs["motion"]].reshape(4, 2).copy()
    if wanted is not None:
        force, motion = force + contact[:, None] * wanted.lead[0], motion + wanted.lead[1]
    locked = contact & (clock.locked(now) | ~fill.rolls)
    motion[locked] = 0.0
    motion[contact & ~fill.steers, 1] = 0.0  # no wheel slips sideways
    before = np.zeros(4) if previous is None else iterate.previous[12:]
    limit = period * np.where(contact, bounds.acceleration_max, fill.swing_acceleration)
    change = np.clip(motion[:, 0] - before, -limit, limit)
    speed, rate = fill.speed_limit, fill.second_limit
    motion[:, 0] = np.where(locked, 0.0, np.clip(before + change, -speed, speed))
    motion[:, 1] = np.clip(motion[:, 1], -rate, rate)
    if wanted is not None:
        motion[wanted.waits] = 0.0
    # an iterate may violate what no robot shall be asked for; the pyramid reaches √2 beyond the cone
    return within_cone(force, np.sqrt(2.0) * bounds.friction, normals), motion
