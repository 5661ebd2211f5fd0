"""The mechanical work of a plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.angles import angular_velocity
from rollgait.plan.samples import Samples

if TYPE_CHECKING:
    from rollgait.plan.plan import Plan

Array = NDArray[np.float64]

RATE: Final = 100.0
"""Samples per second at which powers are integrated, Hz: ten per interval of the usual 0.1 s."""


def mechanical_power(samples: Samples) -> tuple[Array, Array]:
    """Power of the wheels and of the legs, each (n, 4), W.

    A wheel turns its force into the speed of its foot: f · ṗ. The leg moves the base against its foot:
    f · (v_base − ṗ), v_base the velocity of the base at the contact. Both together are what the contact force
    does to the base. A foot in the air has no force: the mass of a swinging leg counts for nothing.
    """
    omega = angular_velocity(samples.euler.T, samples.euler_rate.T).T[:, None]
    arm = samples.contact_position - samples.com_position[:, None]
    v_base = samples.com_velocity[:, None] + np.cross(omega, arm)
    wheels = (samples.force * samples.foot_velocity).sum(axis=-1)
    return wheels, (samples.force * v_base).sum(axis=-1) - wheels


def mechanical_work(plan: Plan) -> float:
    """∫ Σ |power| dt of wheels and legs, J: braking costs as much as driving, as nothing is won back."""
    samples = plan.sample_every(RATE)
    total = sum(np.abs(power).sum(axis=1) for power in mechanical_power(samples))
    return float(np.trapezoid(total, samples.time))
