"""The plan at dense times: every interval sampled from its one end to the other, seen from inside."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.plan.certificate.judged import Judged
from rollgait.plan.certificate.physics import Array
from rollgait.plan.samples import Samples

SAMPLES = 12
"""Samples per interval; at least ten are promised."""
INSIDE = 1e-6
"""Distance of the first and last sample from the ends of the interval, as a part of it.

Inputs jump at the ends: this near, the state is that of the end, and the inputs are this interval's."""


def chebyshev_points() -> Array:
    """The samples' places in an interval, (SAMPLES,), in [INSIDE, 1 − INSIDE], both included.

    Chebyshev's, as the polynomial through values at them is accurate, and so is its derivative.
    """
    cosine = np.cos(np.pi * np.arange(SAMPLES)[::-1] / (SAMPLES - 1))
    return np.asarray(0.5 + (0.5 - INSIDE) * cosine)


def barycentric_weights() -> Array:
    """Weights of the Chebyshev points of the second kind, (SAMPLES,)."""
    weights = (-1.0) ** np.arange(SAMPLES)
    weights[[0, -1]] *= 0.5
    return np.asarray(weights)


def interpolation(tau: float) -> Array:
    """Coefficients (SAMPLES,) that give the value at `tau` from the values at the Chebyshev points."""
    difference = tau - chebyshev_points()
    if np.any(difference == 0.0):
        return np.asarray(difference == 0.0, dtype=float)
    terms = barycentric_weights() / difference
    return np.asarray(terms / terms.sum())


def differentiation() -> Array:
    """Matrix (SAMPLES, SAMPLES) from values at the Chebyshev points to the derivatives there, by tau."""
    points, weights = chebyshev_points(), barycentric_weights()
    difference = points[:, None] - points[None, :] + np.eye(SAMPLES)
    matrix = weights[None, :] / weights[:, None] / difference
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return matrix


@dataclass(frozen=True)
class DenseMotion:
    """Samples with leading axes (N, K): interval, place in the interval.

    Attributes:
        lengths: h of each interval, (N,), s.
        tau: places in an interval, (K,).
        time: (N, K), s.
        at: the samples, every array with leading axes (N, K).
        stance: whether a foot is on the ground in an interval, by the plan's schedule, (N, 4).
        path_velocity: velocity of the contact points from their path alone, (N, K, 4, 3), m/s.
    """

    lengths: Array
    tau: Array
    time: Array
    at: Samples
    stance: NDArray[np.bool_]
    path_velocity: Array

    @classmethod
    def of(cls, plan: Judged) -> DenseMotion:
        """The plan, sampled."""
        tau, count, h = chebyshev_points(), plan.schedule.intervals, plan.schedule.lengths
        time = plan.schedule.node_times[:-1, None] + tau * h[:, None]
        flat = plan.sample(time.ravel())
        split: dict[str, Any] = {f.name: _split(getattr(flat, f.name), count) for f in fields(Samples)}
        at = Samples(**split)
        return cls(
            lengths=h,
            tau=tau,
            time=time,
            at=at,
            stance=plan.schedule.contact.T,
            path_velocity=np.einsum("ij,njlx,n->nilx", differentiation(), at.foot_position, 1.0 / h),
        )

    @property
    def in_stance(self) -> NDArray[np.bool_]:
        """`stance` as a mask of foot samples, (N, 1, 4)."""
        return self.stance[:, None, :]


def _split(values: Array, count: int) -> Array:
    return values.reshape(count, SAMPLES, *values.shape[1:])
