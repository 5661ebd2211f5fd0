"""A run of the controller as samples like those of a plan."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rollgait.mpc.log import MpcLog
from rollgait.plan.samples import Array, Samples, level_contact, rate_of


def samples_of_mpc(log: MpcLog, row: NDArray[np.intp], times: Array) -> Samples:
    """The motion of a log at some of its rows, (n,), called `times`.

    Forces are those that the controller asked for; velocities of feet are differences of neighbouring rows.
    """
    foot, heading = log.foot_position[row], log.heading[row]
    return Samples(
        time=times,
        com_position=log.com_position[row],
        euler=log.euler[row],
        com_velocity=log.com_velocity[row],
        euler_rate=log.euler_rate[row],
        foot_position=foot,
        foot_velocity=rate_of(foot, times),
        heading=heading,
        heading_rate=rate_of(heading, times),
        speed=log.speed[row],
        force=log.force[row],
        contact=log.contact[row],
        **level_contact(foot),
    )


def ground_height(log: MpcLog) -> float:
    """Of the plane under the feet, m: a log does not say its ground."""
    return float(np.median(log.foot_position[..., 2].min(axis=1)))
