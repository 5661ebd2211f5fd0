"""A trajectory of the condensed transcription: node states and inputs, joined by the map that was solved."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.ground import FootGround
from rollgait.dynamics.step import POINTS, Figures, FootInput, FootState, State, euler_rate, step
from rollgait.dynamics.wrench import WRENCH_SIZE
from rollgait.plan.samples import Array, Samples, level_contact
from rollgait.plan.trajectory import Trajectory, feet_in_world
from rollgait.robot.robot import Robot


@dataclass(frozen=True)
class CondensedTrajectory(Trajectory):
    """N states and the inputs that hold after each; between nodes the same step with a shorter length.

    Attributes:
        contact: (N, 4), bool, stance or swing of each foot.
        lengths: h of each interval, (N,), s.
        r, theta, dr: of the CoM and the base at the beginning of each interval, (N, 3), m, rad, m/s.
        L: angular momentum about the CoM, (N, 3), N·m·s.
        foot_xy: lowest points of the feet, (N, 4, 2), m.
        foot_z: their heights, (N, 4), m.
        heading: σ of steerable wheels, (N, 4), rad.
        force: (N, 4, 3), N.
        motion: planar inputs of the feet, (N, 4, 2), as in `CollocationTrajectory`.
        lift_rate: how fast feet rise above the ground at the two height points, (N, 4, 2), m/s.
        ground: under each foot, `Footing.numbers()`, (N, 4, 10).
        wrench: what pulls at the base, as `dynamics.wrench` has it, (N, 21); None if nothing.
    """

    kind: ClassVar[str] = "condensed"
    contact: NDArray[np.bool_]
    lengths: Array
    r: Array
    theta: Array
    dr: Array
    L: Array
    foot_xy: Array
    foot_z: Array
    heading: Array
    force: Array
    motion: Array
    lift_rate: Array
    ground: Array
    wrench: Array | None = None

    def sample(self, times: Array, robot: Robot) -> Samples:
        k, tau = self.mesh.place_of(times)
        figures = Figures(
            mass=robot.mass,
            inertia_inverse=list(np.linalg.inv(robot.inertia_matrix)),
            kinds=[leg.foot for leg in robot.leg_list],
            heading_offset=[leg.heading for leg in robot.leg_list],
        )
        begin = State(
            r=list(self.r[k].T),
            theta=list(self.theta[k].T),
            dr=list(self.dr[k].T),
            L=list(self.L[k].T),
            feet=tuple(
                FootState([*self.foot_xy[k, i].T, self.foot_z[k, i]], self.heading[k, i]) for i in range(4)
            ),
        )
        inputs = [
            # the lift is one parabola per interval: a shorter step must see the rates at its own points
            FootInput(list(self.force[k, i].T), list(self.motion[k, i].T), self._rates(k, i, tau))
            for i in range(4)
        ]
        grounds = None if self.is_flat else self._grounds(k, robot)
        wrench = None if self.wrench is None else list(self.wrench[k].T)
        x, _ = step(np, begin, inputs, tau * self.lengths[k], figures, grounds, wrench)
        theta = np.stack(x.theta, axis=-1)
        theta_rate = np.stack(euler_rate(np, x.theta, x.L, figures), axis=-1)
        heading = np.stack([np.broadcast_to(foot.sigma, times.shape) for foot in x.feet], axis=-1)
        foot = feet_in_world(robot, self.motion[k], heading, theta[:, 0], theta_rate[:, 0])
        position = np.stack([np.stack(f.p, axis=-1) for f in x.feet], axis=1)
        lift = np.stack([self._rate_at(k, i, tau) for i in range(4)], axis=-1)
        contacts = level_contact(position)
        if grounds is not None:
            contacts = _contacts(grounds, position)
            for i, ground in enumerate(grounds):
                lift[:, i] += (
                    np.stack(ground.slope(position[:, i].T), axis=-1) * foot.velocity_xy[:, i]
                ).sum(-1)
        return Samples(
            time=times,
            com_position=np.stack(x.r, axis=-1),
            euler=theta,
            com_velocity=np.stack(x.dr, axis=-1),
            euler_rate=theta_rate,
            foot_position=position,
            foot_velocity=np.concatenate([foot.velocity_xy, lift[..., None]], axis=-1),
            heading=foot.heading,
            heading_rate=foot.heading_rate,
            speed=foot.speed,
            force=self.force[k],
            contact=self.contact[k],
            **contacts,
        )

    @cached_property
    def is_flat(self) -> bool:
        """Whether the ground under all feet is one level plane."""
        ground = self.ground
        return bool((ground[..., 2] == ground[0, 0, 2]).all() and not ground[..., 3:].any())

    def _grounds(self, k: NDArray[np.intp], robot: Robot) -> list[FootGround]:
        """The ground under each foot in intervals (n,)."""
        numbers = self.ground[k]
        return [
            FootGround(list(numbers[:, i, :8].T), list(numbers[:, i, 8:].T), leg.foot_radius)
            for i, leg in enumerate(robot.leg_list)
        ]

    def _rate_at(self, k: NDArray[np.intp], leg: int, tau: Array) -> Array:
        """How fast a foot rises at the fraction τ: linear through the two height points."""
        c1, c2 = POINTS
        first, second = self.lift_rate[k, leg].T
        return np.asarray(((tau - c2) * first - (tau - c1) * second) / (c1 - c2))

    def _rates(self, k: NDArray[np.intp], leg: int, tau: Array) -> list[Array]:
        return [self._rate_at(k, leg, c * tau) for c in POINTS]

    @classmethod
    def layout(cls, count: int | str) -> dict[str, tuple[str, tuple[int | str, ...]]]:
        return {
            "contact": ("b", (count, 4)),
            "lengths": ("f", (count,)),
            **dict.fromkeys(("r", "theta", "dr", "L"), ("f", (count, 3))),
            "foot_xy": ("f", (count, 4, 2)),
            **dict.fromkeys(("foot_z", "heading"), ("f", (count, 4))),
            "force": ("f", (count, 4, 3)),
            **dict.fromkeys(("motion", "lift_rate"), ("f", (count, 4, 2))),
            "ground": ("f", (count, 4, 10)),
        }

    @classmethod
    def layout_of_wrenches(cls, count: int | str) -> dict[str, tuple[str, tuple[int | str, ...]]]:
        return {"wrench": ("f", (count, WRENCH_SIZE))}


def _contacts(grounds: list[FootGround], position: Array) -> dict[str, Array]:
    """Where feet (n, 4, 3) touch the ground, and its normals there: fields of `Samples`."""

    def stacked(vectors: list[list[Array]]) -> Array:
        return np.stack([np.stack(vector, axis=-1) for vector in vectors], axis=1)

    return {
        "contact_position": position + stacked([ground.contact_offset(np) for ground in grounds]),
        "contact_normal": stacked([ground.normal(np) for ground in grounds]),
    }
