"""The judge's own physics: a rigid body on wheels and feet, in plain NumPy.

Deliberately another formulation than the planner's: the orientation is a rotation matrix, not three Euler
angles, so that nothing of Ė or of a singularity at 90° pitch enters the judgement. Arrays have leading axes …
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollgait.robot.robot import GRAVITY, Robot

Array = NDArray[np.float64]


def rotation_world_base(euler: Array) -> Array:
    """R = Rz(yaw) Ry(pitch) Rx(roll), base to world, (…, 3, 3), from θ = (yaw, pitch, roll), (…, 3), rad."""
    cy, cp, cr = np.moveaxis(np.cos(euler), -1, 0)
    sy, sp, sr = np.moveaxis(np.sin(euler), -1, 0)
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def angular_velocity_world(euler: Array, euler_rate: Array) -> Array:
    """ω in world axes, (…, 3), rad/s: yaw rate about z, pitch rate about Rz y, roll rate about Rz Ry x."""
    cy, cp, _ = np.moveaxis(np.cos(euler), -1, 0)
    sy, sp, _ = np.moveaxis(np.sin(euler), -1, 0)
    yaw, pitch, roll = np.moveaxis(euler_rate, -1, 0)
    return np.stack(
        [-sy * pitch + cy * cp * roll, cy * pitch + sy * cp * roll, yaw - sp * roll],
        axis=-1,
    )


def rotation_angle(first: Array, second: Array) -> Array:
    """Angle between two orientations, (…), rad: ‖R1 − R2‖ = 2 √2 sin(angle / 2)."""
    distance = np.linalg.norm(first - second, axis=(-2, -1))
    return np.asarray(2.0 * np.arcsin(np.minimum(distance / np.sqrt(8.0), 1.0)))


def in_yaw_frame(vector: Array, yaw: Array) -> Array:
    """World vectors (…, 3) in axes turned by `yaw` about z: Rzᵀ vector. `yaw` broadcasts against (…)."""
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = vector[..., 0], vector[..., 1]
    return np.stack([c * x + s * y, c * y - s * x, np.broadcast_to(vector[..., 2], x.shape)], axis=-1)


def in_base_frame(vector: Array, euler: Array) -> Array:
    """World vectors (…, 4, 3) in the axes of a base with angles θ (…, 3): Rᵀ vector."""
    return np.asarray(np.einsum("...ji,...lj->...li", rotation_world_base(euler), vector))


@dataclass(frozen=True)
class BodyState:
    """State of body and feet, world frame; `flat` puts it into one array for the integrator.

    Attributes:
        position: r, (…, 3), m.
        velocity: ṙ, (…, 3), m/s.
        rotation: R, (…, 3, 3), base to world.
        angular_velocity: ω, (…, 3), rad/s.
        foot: p, (…, 4, 3), m.
        heading: σ, (…, 4), rad.
    """

    position: Array
    velocity: Array
    rotation: Array
    angular_velocity: Array
    foot: Array
    heading: Array

    SIZE = 34

    def flat(self) -> Array:
        """All of it, (…, 34)."""
        lead = self.position.shape[:-1]
        parts = (
            self.position,
            self.velocity,
            self.rotation,
            self.angular_velocity,
            self.foot,
            self.heading,
        )
        return np.concatenate([part.reshape(*lead, -1) for part in parts], axis=-1)

    @classmethod
    def from_flat(cls, y: Array) -> BodyState:
        """The inverse of `flat`."""
        lead = y.shape[:-1]
        return cls(
            position=y[..., 0:3],
            velocity=y[..., 3:6],
            rotation=y[..., 6:15].reshape(*lead, 3, 3),
            angular_velocity=y[..., 15:18],
            foot=y[..., 18:30].reshape(*lead, 4, 3),
            heading=y[..., 30:34],
        )


@dataclass(frozen=True)
class Inputs:
    """What drives body and feet; `flat` puts it into one array.

    Attributes:
        force: f on the robot, world frame, (…, 4, 3), N.
        along: speed of a foot along its heading, (…, 4), m/s.
        across: speed of a foot across its heading, to the left, (…, 4), m/s.
        climb: vertical speed of a foot, (…, 4), m/s.
        heading_rate: σ̇, (…, 4), rad/s.
        contact: where the ground pushes a foot, from its lowest point, (…, 4, 3), m; None if right there.
    """

    force: Array
    along: Array
    across: Array
    climb: Array
    heading_rate: Array
    contact: Array | None = None

    def flat(self) -> Array:
        """All of it, (…, 28), or (…, 40) with the contacts."""
        lead = self.along.shape[:-1]
        parts = [self.force.reshape(*lead, 12), self.along, self.across, self.climb, self.heading_rate]
        if self.contact is not None:
            parts.append(self.contact.reshape(*lead, 12))
        return np.concatenate(parts, axis=-1)

    @classmethod
    def from_flat(cls, u: Array) -> Inputs:
        """The inverse of `flat`."""
        feet = (*u.shape[:-1], 4, 3)
        contact = u[..., 28:].reshape(feet) if u.shape[-1] > 28 else None
        force = u[..., :12].reshape(feet)
        return cls(force, u[..., 12:16], u[..., 16:20], u[..., 20:24], u[..., 24:28], contact)


@dataclass(frozen=True)
class Pull:
    """A force and a torque on the base from outside.

    Attributes:
        force, torque: (3,), N and N·m.
        lever: from the CoM to where the force acts, base axes, (3,), m.
        in_base: whether force and torque turn with the base.
        acts: in which intervals, (N,).
    """

    force: Array
    torque: Array
    lever: Array
    in_base: bool
    acts: NDArray[np.bool_]

    def at(self, R: Array) -> tuple[Array, Array]:
        """Force and torque about the CoM in the world, (…, N, 3) each, for orientations (…, N, 3, 3)."""
        force, torque = ((R @ v if self.in_base else v) for v in (self.force, self.torque))
        acts = self.acts[:, None]
        return acts * force, acts * (torque + np.cross(R @ self.lever, force))


def derivative(robot: Robot, state: BodyState, inputs: Inputs, pulls: Sequence[Pull] = ()) -> BodyState:
    """Time derivative of the state.

    m r̈ = m g + Σ f + F;  I_W ω̇ + ω × I_W ω = Σ (c − r) × f + T with I_W = R I_B Rᵀ, c the contacts, F and T
    from outside;  Ṙ = [ω]× R;  ṗ = along (cos σ, sin σ) + across (−sin σ, cos σ), and the climb in z.
    """
    inertia_base = robot.inertia_matrix
    R, omega = state.rotation, state.angular_velocity
    acceleration = inputs.force.sum(axis=-2) / robot.mass - np.array([0.0, 0.0, GRAVITY])
    lever = state.foot - state.position[..., None, :]
    if inputs.contact is not None:
        lever = lever + inputs.contact
    torque = np.cross(lever, inputs.force).sum(axis=-2)
    for pull in pulls:
        force, turning = pull.at(R)
        acceleration, torque = acceleration + force / robot.mass, torque + turning
    R_base_world = np.swapaxes(R, -1, -2)
    momentum = _apply(R, _apply(R_base_world, omega) @ inertia_base)
    balance = torque - np.cross(omega, momentum)
    angular_acceleration = _apply(R, _apply(R_base_world, balance) @ np.linalg.inv(inertia_base))
    c, s = np.cos(state.heading), np.sin(state.heading)
    foot_velocity = np.stack(
        [c * inputs.along - s * inputs.across, s * inputs.along + c * inputs.across, inputs.climb], axis=-1
    )
    return BodyState(
        position=state.velocity,
        velocity=acceleration,
        rotation=np.cross(omega[..., None, :], R, axisa=-1, axisb=-2, axisc=-2),
        angular_velocity=angular_acceleration,
        foot=foot_velocity,
        heading=inputs.heading_rate,
    )


def _apply(matrix: Array, vector: Array) -> Array:
    return np.asarray(np.einsum("...ij,...j->...i", matrix, vector))
