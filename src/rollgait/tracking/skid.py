"""How much faster than it rolls the rim of a wheel runs that slides sideways, so that its drive pushes."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.plan.plan import Plan
from rollgait.plan.samples import Samples

Array = NDArray[np.float64]

SLIPS: Final = 1e-3
"""m/s; a wheel that slips by less sticks, as far as anybody can tell."""


def spin(plan: Plan, samples: Samples) -> Array:
    """Speed of the rims beyond that of rolling, (n, 4), m/s; 0 but for fixed wheels that slip.

    Friction is against the way that the rim slides over the ground. So of a wheel that slides sideways by s
    the force says how much it slides along its heading, s f_long / f_lat; here at most by `slip_max`.
    """
    slip_max = np.array([plan.scenario.slip_max(leg) for leg in range(samples.heading.shape[1])])
    c, s = np.cos(samples.heading), np.sin(samples.heading)
    slip = c * samples.foot_velocity[..., 1] - s * samples.foot_velocity[..., 0]
    along = c * samples.force[..., 0] + s * samples.force[..., 1]
    left = c * samples.force[..., 1] - s * samples.force[..., 0]
    slides = samples.contact & (slip_max > 0.0) & (np.abs(slip) > SLIPS) & (left * slip < 0.0)
    sliding = np.where(slides, slip * along / np.where(slides, left, 1.0), 0.0)
    return np.asarray(np.clip(-sliding, -slip_max, slip_max))
