"""The robot at one instant, as CasADi expressions: what the terms of the problem are written in.

Frames: world unless the name says otherwise; the base-yaw frame has its origin at the CoM and is turned by
the yaw only. SI units. The inputs (forces, motions, rates) do not exist at the very end of the horizon: there
they are not-a-number, so that a term which reads them by mistake cannot go unnoticed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca

from rollgait.dynamics.foot import planar_motion
from rollgait.dynamics.ground import FootGround
from rollgait.dynamics.rigid_body import acceleration
from rollgait.dynamics.rotations import R_world_base, R_z
from rollgait.dynamics.wrench import external
from rollgait.robot.robot import FootKind


@dataclass(frozen=True)
class Body:
    """Figures of the robot and the ground that every instant knows, as symbols: one kernel serves all robots.

    Attributes:
        mass: m, kg.
        weight: m g, N.
        inertia: I_B about the CoM, base axes, 3 × 3, kg·m².
        stance: p̄, nominal contact points in the base-yaw frame, 4 × 3 numbers as columns (3, 4), m.
        heading_offset: σ − θz of fixed wheels, 4, rad.
        interval: h, s.
        ground: height of the ground under each foot where it is level, 4, m.
        terrain: the ground under each foot where it is not; None where it is level.
        tilt: pitch and roll that it asks for at both ends of the interval, 2 each, rad; None if level.
        interval_before: h of the interval before, s, where it is a variable; the first has one like it.
        wrench: from outside, as `dynamics.wrench` has it, 21; None where there is none.
    """

    mass: ca.SX
    weight: ca.SX
    inertia: ca.SX
    stance: ca.SX
    heading_offset: ca.SX
    interval: ca.SX
    ground: ca.SX
    terrain: tuple[FootGround, ...] | None = None
    tilt: tuple[ca.SX, ca.SX] | None = None
    interval_before: ca.SX | None = None
    wrench: ca.SX | None = None

    @property
    def between_middles(self) -> ca.SX:
        """Time from the middle of the interval before to that of this one, where it is a variable, s."""
        assert self.interval_before is not None, "asked only where the lengths of intervals are variables"
        return ca.SX(0.5 * (self.interval + self.interval_before))

    def R_world_feet(self, yaw: ca.SX, tau: float) -> ca.SX:
        """Axes in which feet are seen from the base at a fraction of the interval, to world, 3 × 3.

        They have the base's yaw, and the pitch and roll that the ground asks for, from which the base's own
        differ by little. On level ground they are those of the base-yaw frame.
        """
        if self.tilt is None:
            return R_z(yaw)
        begin, end = self.tilt
        tilt = (1.0 - tau) * begin + tau * end
        return R_world_base(ca.vertcat(yaw, tilt))

    def ground_height(self, leg: int, xy: Sequence[Any] | ca.SX) -> ca.SX:
        """z of the ground under the lowest point of a foot, m."""
        return ca.SX(self.ground[leg] if self.terrain is None else self.terrain[leg].height(xy))


@dataclass(frozen=True)
class Foot:
    """A foot at one instant.

    Attributes:
        index: 0 … 3 for FL, FR, HL, HR.
        kind: of the foot.
        p: lowest point of the foot, world, 3, m; on level ground the contact point.
        p_body: Rzᵀ (p − r), in the base-yaw frame, 3, m; where the ground is not level that frame is tilted
            as the ground asks for.
        up_body: e_z in that frame, 3: how wheels stand that are upright.
        height: of the foot above the ground, m.
        height_rate: how fast it rises above the ground, m/s.
        velocity: ṗ, world, 3, m/s.
        heading: σ, rad (0 for a point foot).
        steering: σ − θz, rad.
        heading_rate: σ̇, rad/s.
        speed: v along the heading in the plane, m/s (0 for a point foot).
        surface_speed: the same along the ground, m/s.
        lateral_speed: across the heading, m/s (only of a fixed wheel, in swing or where it may slip).
        motion: the two planar inputs (see `dynamics.foot`).
        lift_rate: u2, ṗz at the two height points of the interval, 2, m/s.
        force: f, on the robot, world, 3, N.
        force_contact: f in the contact frame (along the heading, lateral, normal to the ground), 3, N.
        previous_force: f of the interval before, 3, N.
        previous_motion: the planar inputs of the interval before.
        height_point: number of the height point at which this is, if it is one.
    """

    index: int
    kind: FootKind
    p: ca.SX
    p_body: ca.SX
    up_body: ca.SX
    height: ca.SX
    height_rate: ca.SX
    velocity: ca.SX
    heading: ca.SX
    steering: ca.SX
    heading_rate: ca.SX
    speed: ca.SX
    surface_speed: ca.SX
    lateral_speed: ca.SX
    motion: ca.SX
    lift_rate: ca.SX
    force: ca.SX
    force_contact: ca.SX
    previous_force: ca.SX
    previous_motion: ca.SX
    height_point: int | None = None


@dataclass(frozen=True)
class Instant:
    """The robot at one instant.

    Attributes:
        body: figures of the robot.
        r: CoM, world, 3, m.
        theta: (yaw, pitch, roll), 3, rad.
        dr: ṙ, 3, m/s.
        dtheta: θ̇, 3, rad/s.
        feet: the four feet.
    """

    body: Body
    r: ca.SX
    theta: ca.SX
    dr: ca.SX
    dtheta: ca.SX
    feet: tuple[Foot, ...]

    @cached_property
    def ddr(self) -> ca.SX:
        """r̈, 3, m/s²: equation 1."""
        forces = [foot.force for foot in self.feet]
        if self.body.wrench is not None:
            forces.append(self.external[0])
        return acceleration(self.body.mass, forces)

    @cached_property
    def external(self) -> tuple[ca.SX, ca.SX]:
        """Force, N, and torque about the CoM, N·m, from outside, world, 3 each; only where there is any."""
        assert self.body.wrench is not None, "asked only where there is one"
        R = [ca.horzsplit(row) for row in ca.vertsplit(self.R_world_base)]
        force, torque = external(ca.vertsplit(self.body.wrench), R)
        return ca.vertcat(*force), ca.vertcat(*torque)

    @cached_property
    def R_world_base(self) -> ca.SX:
        """R(θ), base to world, 3 × 3."""
        return R_world_base(self.theta)


@dataclass(frozen=True)
class Inputs:
    """Inputs of all feet: lists of forces (3 each, N), motions (2 each), lift rates (2 each)."""

    force: Sequence[ca.SX]
    motion: Sequence[ca.SX]
    lift_rate: Sequence[ca.SX]

    @classmethod
    def none(cls) -> Inputs:
        """Stands for inputs that do not exist."""
        return cls([ca.SX.nan(3)] * 4, [ca.SX.nan(2)] * 4, [ca.SX.nan(2)] * 4)


def make_instant(
    body: Body,
    kinds: Sequence[FootKind],
    base: ca.SX,
    base_rate: ca.SX,
    foot_xy: Sequence[ca.SX],
    height: Sequence[ca.SX],
    sigma: Sequence[ca.SX],
    height_rate: Sequence[ca.SX],
    inputs: Inputs,
    previous: Inputs,
    height_point: int | None = None,
    tau: float = 0.0,
) -> Instant:
    """An instant from the numbers that a transcription holds.

    Args:
        body: figures of the robot.
        kinds: of the four feet.
        base: (r, θ), 6.
        base_rate: (ṙ, θ̇), 6.
        foot_xy: lowest points of the feet, 2 each.
        height: theirs above the ground, 1 each.
        sigma: headings of steerable wheels, 1 each (not read for other kinds).
        height_rate: how fast they rise above the ground, 1 each.
        inputs: forces and motions.
        previous: those of the interval before.
        height_point: number of the height point, if the instant is one.
        tau: fraction of the interval that has passed.
    """
    r, theta = base[:3], base[3:]
    R_feet = body.R_world_feet(theta[0], tau)
    feet = []
    for i, kind in enumerate(kinds):
        planar = planar_motion(
            ca, kind, inputs.motion[i], sigma[i], theta[0], base_rate[3], body.heading_offset[i]
        )
        p = ca.vertcat(foot_xy[i], body.ground_height(i, foot_xy[i]) + height[i])
        heading, force = ca.SX(planar.heading), inputs.force[i]
        if body.terrain is None:
            force_contact, speed_factor = R_z(heading).T @ force, ca.SX(1)
            rise = height_rate[i]
        else:
            frame = body.terrain[i].rolling_frame(ca, heading)
            force_contact = ca.vertcat(*(ca.dot(ca.vertcat(*axis), force) for axis in frame))
            speed_factor = body.terrain[i].way_factor(ca, heading)
            slope = body.terrain[i].slope(foot_xy[i])
            rise = height_rate[i] + slope[0] * planar.velocity[0] + slope[1] * planar.velocity[1]
        feet.append(
            Foot(
                index=i,
                kind=kind,
                p=p,
                p_body=R_feet.T @ (p - r),
                up_body=R_feet[2, :].T,
                height=height[i],
                height_rate=height_rate[i],
                velocity=ca.vertcat(*planar.velocity, rise),
                heading=heading,
                steering=heading - theta[0],
                heading_rate=ca.SX(planar.heading_rate),
                speed=ca.SX(planar.speed),
                surface_speed=speed_factor * planar.speed,
                lateral_speed=ca.SX(planar.lateral_speed),
                motion=inputs.motion[i],
                lift_rate=inputs.lift_rate[i],
                force=force,
                force_contact=force_contact,
                previous_force=previous.force[i],
                previous_motion=previous.motion[i],
                height_point=height_point,
            )
        )
    return Instant(body, r, theta, base_rate[:3], base_rate[3:], tuple(feet))
