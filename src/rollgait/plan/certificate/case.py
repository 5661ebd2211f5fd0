"""What every check needs: the plan's samples, the robot, the scenario and what it promises."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.certificate.contacts import Contacts, contacts_on
from rollgait.plan.certificate.judged import Judged
from rollgait.plan.certificate.motion import DenseMotion
from rollgait.plan.certificate.physics import Array, in_base_frame, in_yaw_frame, rotation_world_base
from rollgait.plan.certificate.pose import ground_under_feet, wanted_pose
from rollgait.plan.samples import Samples
from rollgait.robot.robot import FootKind, Leg, Robot
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule
from rollgait.terrain.terrain import Terrain


@dataclass(frozen=True)
class Case:
    """A plan to be judged."""

    plan: Judged
    motion: DenseMotion

    @property
    def robot(self) -> Robot:
        """The plan's robot."""
        return self.plan.robot

    @property
    def scenario(self) -> Scenario:
        """What was asked."""
        return self.plan.scenario

    @property
    def schedule(self) -> ContactSchedule:
        """The plan's schedule."""
        return self.plan.schedule

    @property
    def legs(self) -> tuple[Leg, ...]:
        """The robot's legs, FL, FR, HL, HR."""
        return self.robot.leg_list

    def bound(self, name: str) -> Any:
        """A bound of the scenario or of its profile, or None."""
        return self.scenario.value_of("bounds", name)

    def has(self, *terms: str) -> bool:
        """Whether all these terms are part of the problem: none is named in `bounds.without`."""
        return not set(terms) & set(self.scenario.bounds.without)

    def feet(self, *kinds: FootKind) -> NDArray[np.bool_]:
        """Which feet are of one of these kinds, (4,)."""
        return np.array([leg.foot in kinds for leg in self.legs])

    @property
    def fixed_headings(self) -> Array:
        """σ − θz of fixed wheels (0 of others), (4,), rad."""
        return np.array([leg.heading if leg.foot == "fixed" else 0.0 for leg in self.legs])

    @cached_property
    def slip_max(self) -> Array:
        """How fast a foot that stands may slip sideways, (4,), m/s: 0 but for fixed wheels on flat ground."""
        flat = self.scenario.ground.kind == "flat"
        own = [leg.slip_max or 0.0 if leg.foot == "fixed" and flat else 0.0 for leg in self.legs]
        return np.array(own)

    @cached_property
    def terrain(self) -> Terrain | None:
        """The raw ground; None if it is flat."""
        return None if self.scenario.ground.kind == "flat" else self.scenario.terrain

    @cached_property
    def contacts(self) -> Contacts | None:
        """What feet touch on ground that is not flat."""
        return None if self.terrain is None else contacts_on(self.terrain, self.robot, self.motion)

    @property
    def radius(self) -> Array:
        """R of the wheels or of the balls of point feet, (4,), m."""
        return np.array([leg.foot_radius for leg in self.legs])

    @cached_property
    def foot_base(self) -> Array:
        """p − r seen from the base, as if it were tilted as the ground asks for, (N, K, 4, 3), m.

        On flat ground that is level: Rzᵀ(p − r).
        """
        at = self.motion.at
        offset = at.foot_position - at.com_position[..., None, :]
        if self.terrain is None:
            return in_yaw_frame(offset, at.euler[..., :1])
        return in_base_frame(offset, self._wanted_tilt)

    @cached_property
    def up_base(self) -> Array:
        """e_z in the frame of `foot_base`, (N, K, 3)."""
        if self.terrain is None:
            return np.broadcast_to([0.0, 0.0, 1.0], (*self.motion.time.shape, 3))
        return rotation_world_base(self._wanted_tilt)[..., 2, :]

    @cached_property
    def _wanted_tilt(self) -> Array:
        """Angles of a base with this yaw that is tilted as the ground asks for, (N, K, 3), rad."""
        assert self.terrain is not None, "flat ground asks for no tilt"
        under = ground_under_feet(self.schedule, self.motion, self.terrain, self.robot.height)
        return wanted_pose(under, self.motion.at.euler[..., 0], self.robot.stance)[1]

    def standing_pose(self, at: Samples, yaw: Array) -> tuple[Array, Array]:
        """Height of the CoM (n,), m, and angles of the base (n, 3), rad, over feet that all stand."""
        if self.terrain is None:
            level = np.stack([yaw, np.zeros_like(yaw), np.zeros_like(yaw)], axis=-1)
            return np.full_like(yaw, self.scenario.height), level
        ground, wanted = wanted_pose(at.foot_position, yaw, self.robot.stance)
        return ground + self.robot.height, wanted

    @cached_property
    def steering(self) -> Array:
        """σ − θz, (N, K, 4), rad."""
        return np.asarray(self.motion.at.heading - self.motion.at.euler[..., :1])

    @cached_property
    def planar_speeds(self) -> tuple[Array, Array]:
        """Speeds of the feet along and across their headings, two arrays (N, K, 4), m/s.

        By the model of each foot: what rolls has no speed across unless it may slip, what stands has none;
        only of what moves freely the velocity is the one that the plan states.
        """
        at, stance = self.motion.at, self.motion.in_stance
        c, s = np.cos(at.heading), np.sin(at.heading)
        vx, vy = at.foot_velocity[..., 0], at.foot_velocity[..., 1]
        rolls = self.feet("steerable") | (self.feet("fixed") & stance)
        stands = self.feet("point") & stance
        along = np.where(rolls, at.speed, np.where(stands, 0.0, c * vx + s * vy))
        held = (rolls & (self.slip_max == 0.0)) | stands
        return along, np.where(held, 0.0, c * vy - s * vx)

    @cached_property
    def start_speeds(self) -> tuple[Array, Array]:
        """Speeds of the feet along and across their headings before t = 0, two arrays (4,), m/s."""
        motion = self.scenario.start.motion
        if motion is None:
            return np.zeros(len(self.legs)), np.zeros(len(self.legs))
        heading, velocity = np.array(motion.heading), np.array(motion.foot_velocity)
        c, s = np.cos(heading), np.sin(heading)
        along, across = c * velocity[:, 0] + s * velocity[:, 1], c * velocity[:, 1] - s * velocity[:, 0]
        steers = self.feet("steerable")
        return np.where(steers, np.array(motion.speed), along), np.where(steers, 0.0, across)

    def eased(self, margin: Array, least: float, most: float, time: Array | None = None) -> Array:
        """Margins (N, k, …) less strictly at first, where a start in motion is beyond its limits.

        By as much as it misses `least` at the start, at most `most`; evenly less until `GRACE` is over.
        Of all samples, or of those at some times (N, k), s.
        """
        if self.scenario.start.motion is None:
            return margin
        missing = _missing(margin, least, most)
        share = np.maximum(0.0, 1.0 - (self.motion.time if time is None else time) / tol.GRACE)
        return np.asarray(margin + share.reshape(*share.shape, *[1] * (margin.ndim - 2)) * missing)

    def eased_places(self, margin: Array, least: float, most: float) -> Array:
        """Margins (N, k, 4) of where feet stand: until they leave the places where a motion finds them."""
        if self.scenario.start.motion is None:
            return margin
        missing = _missing(margin, least, most)
        stays = np.logical_and.accumulate(self.motion.stance, axis=0)[:, None, :]
        return np.asarray(margin + np.where(stays, missing, 0.0))

    @property
    def knows_joints(self) -> bool:
        """Whether the robot has figures of the joints behind each steerable foot, and has such feet."""
        limbs = [leg.limb for leg in self.legs if leg.foot == "steerable"]
        return bool(limbs) and None not in limbs

    @property
    def steers_by_joints(self) -> bool:
        """Whether the joints limit the steering of steerable feet, in place of a fixed range."""
        return bool(self.bound("joint_steering")) and self.has("joint_steering") and self.knows_joints


def _missing(margin: Array, least: float, most: float) -> Array:
    """By how much margins (N, k, …) miss what is asked at the start, and rounding more; at most `most`."""
    missing = np.clip(np.nan_to_num(least - margin[0, 0]), 0.0, most)
    return np.asarray(np.where(missing > 0.0, missing + tol.BEYOND_ROUNDING, 0.0))
