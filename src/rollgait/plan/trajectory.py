"""The solution as a function of time.

A trajectory holds plain arrays and knows how to evaluate them; it needs neither the solver nor CasADi. There is one
class per transcription, told apart in a file by `kind`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import ClassVar, Self

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from rollgait.errors import InputError
from rollgait.plan.samples import Array, Samples
from rollgait.robot.robot import Robot

STATE_POINTS = 3
"""Gauss-Legendre points per interval of all states but the foot heights (paper)."""
HEIGHT_POINTS = 2
"""Gauss-Legendre points per interval of the foot heights (paper)."""


def gauss_points(count: int) -> Array:
    """Gauss-Legendre points on [0, 1], shape (count,)."""
    return np.asarray(0.5 * (leggauss(count)[0] + 1.0))


def lagrange(support: Array, tau: Array) -> tuple[Array, Array]:
    """Values and derivatives of the Lagrange polynomials on `support` (m,) at `tau` (n,): two arrays (n, m)."""
    value = np.ones((tau.size, support.size))
    slope = np.zeros((tau.size, support.size))
    for j, sj in enumerate(support):
        for i, si in enumerate(support):
            if i == j:
                continue
            factor = (tau - si) / (sj - si)
            slope[:, j] = slope[:, j] * factor + value[:, j] / (sj - si)
            value[:, j] *= factor
    return value, slope


class Trajectory(ABC):
    """A solution that can be evaluated at any time of the horizon."""

    kind: ClassVar[str]
    registry: ClassVar[dict[str, type[Trajectory]]] = {}

    def __init_subclass__(cls) -> None:
        Trajectory.registry[cls.kind] = cls

    @abstractmethod
    def sample(self, times: Array, robot: Robot) -> Samples:
        """The motion at `times`, shape (n,), s, inside the horizon."""

    @abstractmethod
    def arrays(self) -> dict[str, Array]:
        """What must be saved to build it again with `from_arrays`."""

    @classmethod
    @abstractmethod
    def from_arrays(cls, arrays: dict[str, Array]) -> Self:
        """The inverse of `arrays`."""


@dataclass(frozen=True)
class CollocationTrajectory(Trajectory):
    """Polynomials on N equal intervals, given by their values at the node and at the collocation points.

    Attributes:
        contact: (N, 4), bool, stance or swing of each foot.
        interval: h, s, shape ().
        base: r and θ at the node and the 3 points, (N, 4, 6).
        base_rate: ṙ and θ̇ there, (N, 4, 6).
        foot_xy: contact points there, (N, 4, 4, 2): interval, support, leg, axis.
        heading: σ there, (N, 4, 4): interval, support, leg.
        foot_z: heights at the node and the 2 points, (N, 3, 4): interval, support, leg.
        force: (N, 4, 3), N, constant in an interval.
        motion: planar inputs of the feet, (N, 4, 2), constant in an interval: (v, σ̇) of a steerable wheel, the
            velocity along and across the heading of a fixed one, the world velocity (x, y) of a point foot.
    """

    kind: ClassVar[str] = "collocation"
    contact: NDArray[np.bool_]
    interval: Array
    base: Array
    base_rate: Array
    foot_xy: Array
    heading: Array
    foot_z: Array
    force: Array
    motion: Array

    def sample(self, times: Array, robot: Robot) -> Samples:
        h, count = float(self.interval), self.base.shape[0]
        k = np.clip(np.floor(times / h + 1e-9).astype(int), 0, count - 1)
        tau = times / h - k
        state, state_slope = lagrange(np.concatenate([[0.0], gauss_points(STATE_POINTS)]), tau)
        height, height_slope = lagrange(np.concatenate([[0.0], gauss_points(HEIGHT_POINTS)]), tau)
        base = np.einsum("ns,nsi->ni", state, self.base[k])
        base_rate = np.einsum("ns,nsi->ni", state, self.base_rate[k])
        xy = np.einsum("ns,nsli->nli", state, self.foot_xy[k])
        z = np.einsum("ns,nsl->nl", height, self.foot_z[k])
        z_rate = np.einsum("ns,nsl->nl", height_slope, self.foot_z[k]) / h
        heading = np.einsum("ns,nsl->nl", state, self.heading[k])
        foot = feet_in_world(robot, self.motion[k], heading, base[:, 3], base_rate[:, 3])
        return Samples(
            time=times,
            com_position=base[:, :3],
            euler=base[:, 3:],
            com_velocity=base_rate[:, :3],
            euler_rate=base_rate[:, 3:],
            foot_position=np.concatenate([xy, z[..., None]], axis=-1),
            foot_velocity=np.concatenate([foot.velocity_xy, z_rate[..., None]], axis=-1),
            heading=foot.heading,
            heading_rate=foot.heading_rate,
            speed=foot.speed,
            force=self.force[k],
            contact=self.contact[k],
        )

    def arrays(self) -> dict[str, Array]:
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @classmethod
    def from_arrays(cls, arrays: dict[str, Array]) -> CollocationTrajectory:
        missing = [f.name for f in fields(cls) if f.name not in arrays]
        if missing:
            raise InputError("trajectory", missing, "is missing in the file")
        return cls(**{f.name: arrays[f.name] for f in fields(cls)})


@dataclass(frozen=True)
class FootMotion:
    """Planar motion of the feet in the world, from their inputs: arrays with first axes (n, 4)."""

    velocity_xy: Array
    heading: Array
    heading_rate: Array
    speed: Array


def feet_in_world(robot: Robot, motion: Array, heading: Array, yaw: Array, yaw_rate: Array) -> FootMotion:
    """What the planar inputs of the feet mean in the world, by the kind of each foot.

    Args:
        robot: says the kind of each foot.
        motion: (n, 4, 2), as in `CollocationTrajectory`.
        heading: σ of steerable wheels, (n, 4), rad.
        yaw: θz, (n,), rad.
        yaw_rate: θ̇z, (n,), rad/s.
    """
    velocity = np.zeros_like(motion)
    sigma, rate, speed = np.zeros_like(heading), np.zeros_like(heading), np.zeros_like(heading)
    for i, leg in enumerate(robot.leg_list):
        first, second = motion[:, i, 0], motion[:, i, 1]
        if leg.foot == "point":
            velocity[:, i] = motion[:, i]
            continue
        steers = leg.foot == "steerable"
        sigma[:, i] = heading[:, i] if steers else yaw + leg.heading
        rate[:, i] = second if steers else yaw_rate
        speed[:, i] = first
        lateral = np.zeros_like(first) if steers else second
        c, s = np.cos(sigma[:, i]), np.sin(sigma[:, i])
        velocity[:, i, 0] = c * first - s * lateral
        velocity[:, i, 1] = s * first + c * lateral
    return FootMotion(velocity, sigma, rate, speed)
