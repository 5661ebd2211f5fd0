"""The solution as a function of time.

A trajectory holds plain arrays and knows how to evaluate them; it needs neither the solver nor CasADi. There
is one class per transcription, told apart in a file by `kind`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.foot import planar_motion
from rollgait.errors import InputError
from rollgait.npz import KINDS
from rollgait.plan.samples import Array, Samples, level_contact
from rollgait.polynomials import HEIGHT_POINTS, STATE_POINTS, gauss_points, lagrange
from rollgait.robot.robot import Robot
from rollgait.scenario.mesh import Mesh


class Trajectory(ABC):
    """A solution that can be evaluated at any time of the horizon.

    Attributes:
        kind: in files, of the transcription.
        lengths: of the N intervals, (N,), s.
    """

    kind: ClassVar[str]
    registry: ClassVar[dict[str, type[Trajectory]]] = {}
    lengths: Array

    def __init_subclass__(cls) -> None:
        Trajectory.registry[cls.kind] = cls

    @cached_property
    def mesh(self) -> Mesh:
        """The intervals for which there is data."""
        return Mesh(self.lengths)

    @property
    def horizon(self) -> float:
        """T, s: the end of the time for which there is data."""
        return self.mesh.horizon

    @abstractmethod
    def sample(self, times: Array, robot: Robot) -> Samples:
        """The motion at `times`, shape (n,), s, inside the horizon."""

    @classmethod
    @abstractmethod
    def layout(cls, count: int | str) -> dict[str, tuple[str, tuple[int | str, ...]]]:
        """Kind of number and shape of each array of a trajectory with N = `count`, a number or its name."""

    @classmethod
    def layout_of_wrenches(cls, count: int | str) -> dict[str, tuple[str, tuple[int | str, ...]]]:
        """The same of arrays that only a trajectory under wrenches has."""
        return {}

    def arrays(self) -> dict[str, NDArray[Any]]:
        """What must be saved to build it again with `from_arrays`."""
        further = [name for name in self.layout_of_wrenches(1) if getattr(self, name) is not None]
        return {name: getattr(self, name) for name in [*self.layout(1), *further]}

    @classmethod
    def from_arrays(cls, arrays: dict[str, NDArray[Any]]) -> Self:
        """The inverse of `arrays`. Raises `InputError` if one is missing or has the wrong shape."""
        names = list(cls.layout(1))
        missing = [name for name in names if name not in arrays]
        if missing:
            raise InputError("trajectory", missing, "is missing")
        count = arrays["force"].shape[0] if arrays["force"].ndim else 0
        further = {k: v for k, v in cls.layout_of_wrenches(count).items() if k in arrays}
        names += further
        for name, (kind, shape) in (cls.layout(count) | further).items():
            array = arrays[name]
            if count == 0 or array.shape != shape or array.dtype.kind != kind:
                rule = f"must have the shape {shape} and hold {KINDS[kind][1]}"
                raise InputError(f"trajectory.{name}", array.shape, rule)
        return cls(**{name: arrays[name] for name in names})


@dataclass(frozen=True)
class CollocationTrajectory(Trajectory):
    """Polynomials on N intervals, given by their values at the node and at the collocation points.

    Attributes:
        contact: (N, 4), bool, stance or swing of each foot.
        lengths: h of each interval, (N,), s.
        base: r and θ at the node and the 3 points, (N, 4, 6).
        base_rate: ṙ and θ̇ there, (N, 4, 6).
        foot_xy: contact points there, (N, 4, 4, 2): interval, support, leg, axis.
        heading: σ there, (N, 4, 4): interval, support, leg.
        foot_z: heights at the node and the 2 points, (N, 3, 4): interval, support, leg.
        force: (N, 4, 3), N, constant in an interval.
        motion: planar inputs of the feet, (N, 4, 2), constant in an interval: (v, σ̇) of a steerable wheel,
            the velocity along and across the heading of a fixed one, the world velocity (x, y) of a point
            foot.
    """

    kind: ClassVar[str] = "collocation"
    contact: NDArray[np.bool_]
    lengths: Array
    base: Array
    base_rate: Array
    foot_xy: Array
    heading: Array
    foot_z: Array
    force: Array
    motion: Array

    def sample(self, times: Array, robot: Robot) -> Samples:
        k, tau = self.mesh.place_of(times)
        state, _ = lagrange(np.concatenate([[0.0], gauss_points(STATE_POINTS)]), tau)
        height, height_slope = lagrange(np.concatenate([[0.0], gauss_points(HEIGHT_POINTS)]), tau)
        base = np.einsum("ns,nsi->ni", state, self.base[k])
        base_rate = np.einsum("ns,nsi->ni", state, self.base_rate[k])
        xy = np.einsum("ns,nsli->nli", state, self.foot_xy[k])
        z = np.einsum("ns,nsl->nl", height, self.foot_z[k])
        z_rate = np.einsum("ns,nsl->nl", height_slope, self.foot_z[k]) / self.lengths[k, None]
        heading = np.einsum("ns,nsl->nl", state, self.heading[k])
        foot = feet_in_world(robot, self.motion[k], heading, base[:, 3], base_rate[:, 3])
        position = np.concatenate([xy, z[..., None]], axis=-1)
        return Samples(
            time=times,
            com_position=base[:, :3],
            euler=base[:, 3:],
            com_velocity=base_rate[:, :3],
            euler_rate=base_rate[:, 3:],
            foot_position=position,
            foot_velocity=np.concatenate([foot.velocity_xy, z_rate[..., None]], axis=-1),
            heading=foot.heading,
            heading_rate=foot.heading_rate,
            speed=foot.speed,
            force=self.force[k],
            contact=self.contact[k],
            **level_contact(position),
        )

    @classmethod
    def layout(cls, count: int | str) -> dict[str, tuple[str, tuple[int | str, ...]]]:
        state, height = STATE_POINTS + 1, HEIGHT_POINTS + 1  # the node and the collocation points
        return {
            "contact": ("b", (count, 4)),
            "lengths": ("f", (count,)),
            "base": ("f", (count, state, 6)),
            "base_rate": ("f", (count, state, 6)),
            "foot_xy": ("f", (count, state, 4, 2)),
            "heading": ("f", (count, state, 4)),
            "foot_z": ("f", (count, height, 4)),
            "force": ("f", (count, 4, 3)),
            "motion": ("f", (count, 4, 2)),
        }


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
        foot = planar_motion(np, leg.foot, motion[:, i].T, heading[:, i], yaw, yaw_rate, leg.heading)
        velocity[:, i] = np.stack(foot.velocity, axis=-1)
        sigma[:, i], rate[:, i], speed[:, i] = foot.heading, foot.heading_rate, foot.speed
    return FootMotion(velocity, sigma, rate, speed)
