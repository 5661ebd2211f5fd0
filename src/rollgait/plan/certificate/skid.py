"""Do fixed wheels that may slip sideways slip as friction lets them? (On flat ground: elsewhere none may.)"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.certificate.case import Case
from rollgait.plan.certificate.physics import Array, in_yaw_frame
from rollgait.plan.certificate.rows import Row, measured

SLIDING: Final = 0.9
"""Share of the friction that forces may use which a sliding wheel has, as the plan promises."""
CREEPS: Final = 0.1
"""Parts of `slip_max` below which friction grows with the slip."""


def check_skid(case: Case) -> Iterator[Row]:
    """The slip is bounded, and over at the end; the force is against it, as large as sliding friction.

    That it is inside the cone says `friction_margin`, of all feet.
    """
    may_slip = case.slip_max > 0.0
    if not may_slip.any():
        return
    motion = case.motion
    slip = _across(case, motion.path_velocity[..., :2])
    allowed = np.tile(case.slip_max, (len(motion.lengths), 1, 1))
    allowed[-1] = 0.0  # there wheels rest
    yield from measured(
        "skid_slip",
        "lateral slip of fixed wheels below its limit, from the path",
        "m/s",
        allowed - np.abs(slip),
        -tol.SLIP,
        motion.time,
        where=motion.in_stance & may_slip,
        at_least=True,
        promised=case.has("stance_motion"),
    )
    force = in_yaw_frame(motion.at.force, motion.at.heading)
    along, left, normal = np.moveaxis(force, -1, 0)
    promised = case.has("skid", "stance_motion")
    slips = motion.in_stance & may_slip & (np.abs(slip) > tol.SLIP)
    yield from measured(
        "skid_direction",
        "force along the lateral slip of fixed wheels, not against it",
        "N",
        left * np.sign(slip),
        tol.FORCE,
        motion.time,
        where=slips,
        promised=promised,
    )
    mu = case.bound("friction_share") * case.scenario.ground.friction
    mu /= np.sqrt(2.0) if case.scenario.bounds.inscribed else 1.0
    cone = np.maximum(SLIDING * mu * normal, tol.FORCE)
    # what is across gets less as the slip gets less than ε, what is along the heading does not
    share = slip / np.hypot(slip, np.where(may_slip, CREEPS * case.slip_max, 1.0))
    law = np.sqrt((cone * share) ** 2 + along**2 * (1.0 - share**2))
    yield from measured(
        "skid_friction",
        "friction of slipping wheels against that of sliding ones, in parts of the latter",
        "",
        np.abs(np.hypot(along, left) - law) / cone,
        tol.SKID_FRICTION,
        motion.time,
        where=slips,
        promised=promised,
    )


def slip_along(case: Case, velocity: Array) -> Array:
    """The part of horizontal velocities (N, K, 4, 2) along the headings, (N, K, 4), m/s."""
    heading = case.motion.at.heading
    return np.asarray(velocity[..., 0] * np.cos(heading) + velocity[..., 1] * np.sin(heading))


def _across(case: Case, velocity: Array) -> Array:
    """The part of horizontal velocities to the left of the headings, (N, K, 4), m/s."""
    heading = case.motion.at.heading
    return np.asarray(velocity[..., 1] * np.cos(heading) - velocity[..., 0] * np.sin(heading))
