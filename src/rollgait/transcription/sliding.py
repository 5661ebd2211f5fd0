"""Friction of wheels that slide sideways while the base turns: what a guess begins with."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.ocp.friction import pyramid
from rollgait.ocp.problem import Problem
from rollgait.ocp.skid import KINETIC, SOFT

Array = NDArray[np.float64]

HALVINGS: Final = 40
"""Of the range in which the force to the side is looked for: as fine as numbers are."""
TINY: Final = 1e-9
"""N; keeps shares finite where no wheel slips."""


def sliding_forces(
    problem: Problem,
    interval: NDArray[np.intp],
    normal: Array,
    lever: Array,
    heading: Array,
    velocity: Array,
    acceleration: Array,
) -> Array:
    """Forces in the ground plane, (n, 4, 3), N, with the moment that turns the base as asked.

    Across the heading friction is against the slip; what its moment takes too much is given back by drives
    that push on one side and brake on the other, all wheels with the same share of their friction. What
    speeds the base up along its heading comes on top, by the load of the wheels.

    Args:
        problem: what is asked, all wheels sharing one heading.
        interval: in which each time is, (n,).
        normal: normal forces, (n, 4), N.
        lever: from the base to the feet, (n, 4, 2), m, world axes.
        heading: of the wheels, (n, 4), rad.
        velocity: of the feet, (n, 4, 2), m/s, world axes.
        acceleration: of the base pose (r, θ), (n, 6), m/s² and rad/s².
    """
    legs = range(normal.shape[1])
    mu = np.stack([pyramid(problem, leg)[interval] for leg in legs], axis=1)
    soft = np.array([SOFT * problem.scenario.slip_max(leg) for leg in legs])
    along = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    left = np.stack([-np.sin(heading), np.cos(heading)], axis=-1)
    slip = np.sum(velocity * left, axis=-1)
    against = -slip / np.hypot(slip, soft)
    ahead, aside = np.sum(lever * along, axis=-1), np.sum(lever * left, axis=-1)
    most = KINETIC * mu * normal
    moment = problem.robot.inertia.zz * acceleration[:, 3]
    across, drives = _shared(ahead, aside, against, most, moment)
    faster = np.sum(acceleration[:, None, :2] * along, axis=-1) / problem.robot.weight
    pushes = drives * most + faster * problem.robot.mass * normal
    planar = pushes[..., None] * along + (across * against * most)[..., None] * left
    return np.concatenate([planar, np.zeros_like(planar[..., :1])], axis=-1)


def _shared(ahead: Array, aside: Array, against: Array, most: Array, moment: Array) -> tuple[Array, Array]:
    """How friction is shared, cos β across and sin β along the headings, both (n, 4).

    Wheels ahead of the base and behind it push it to the side alike, or it would go there, by L; what of
    their friction that leaves drives. L is found for which L (a + a') − Σ |b| √(1 − cos² β) f is the moment.
    """
    is_front = ahead > 0.0
    sums = np.stack([np.sum(np.abs(against) * most * here, axis=1) for here in (is_front, ~is_front)], axis=1)
    sums = np.maximum(sums, TINY)
    own = np.where(is_front, sums[:, :1], sums[:, 1:])
    weights = np.abs(against) * most / own
    length = np.sum(np.abs(ahead) * weights, axis=1)
    way = np.sign(np.sum(ahead * against * most, axis=1))
    low, high = np.zeros(len(ahead)), sums.min(axis=1)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        across = middle[:, None] / own
        driving = np.sum(np.abs(aside) * most * np.sqrt(1.0 - across**2), axis=1)
        is_less = middle * length - driving < way * moment
        low, high = np.where(is_less, middle, low), np.where(is_less, high, middle)
    across = high[:, None] / own
    return across, way[:, None] * np.sign(aside) * np.sqrt(1.0 - np.minimum(across, 1.0) ** 2)
