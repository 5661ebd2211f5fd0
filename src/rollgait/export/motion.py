"""What exports are made of: a plan or joints, sampled at a fixed rate. Plain arrays in the terms of ROS.

Frames by REP-105: `odom` is the world, `base_link` the base. A plan alone knows the base by its CoM, so there
`base_link` stands at the CoM; with joints it is the base link of the URDF. Axes and units by REP-103.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rollgait.errors import InputError
from rollgait.plan.plan import MAX_SAMPLES, Plan
from rollgait.plan.samples import Array, Samples
from rollgait.robot.robot import LEG_NAMES, Robot
from rollgait.terrain import Terrain
from rollgait.tracking.joints import JointTrajectory

Motion = Plan | JointTrajectory

LEGS = tuple(name.lower() for name in LEG_NAMES)
"""Names of the legs in frames and joints: lower case, as ROS has it."""


@dataclass(frozen=True)
class Sampled:
    """A motion at n times.

    Attributes:
        robot: the planner's robot.
        samples: the plan, (n, …).
        base_position: of `base_link` in `odom`, (n, 3), m.
        base_quaternion: `base_link` to `odom`, (x, y, z, w), (n, 4).
        joint_names: of the n_j joints.
        joint_position: (n, n_j), rad.
        joint_velocity: (n, n_j), rad/s.
        joint_effort: (n, n_j), N m, or (n, 0) where it is not known.
        wheel_angle: by which each wheel has turned, (n, 4), rad.
        terrain: the ground.
    """

    robot: Robot
    samples: Samples
    base_position: Array
    base_quaternion: Array
    joint_names: tuple[str, ...]
    joint_position: Array
    joint_velocity: Array
    joint_effort: Array
    wheel_angle: Array
    terrain: Terrain

    @property
    def time(self) -> Array:
        """(n,), s."""
        return self.samples.time


def sampled(motion: Motion, rate: float) -> Sampled:
    """A motion at a rate (Hz), both ends included; joints at the nearest of their own samples.

    Raises:
        InputError: the rate is not positive, or too high.
    """
    return _of_plan(motion, rate) if isinstance(motion, Plan) else _of_joints(motion, rate)


def _of_plan(plan: Plan, rate: float) -> Sampled:
    """A plan: its joints are the steering and the wheel of each leg, relative to the base."""
    s, robot = plan.sample_every(rate), plan.robot
    angle = wheel_angle(s, robot)
    names: list[str] = []
    position: list[Array] = []
    velocity: list[Array] = []
    for leg, data in enumerate(robot.leg_list):
        if data.foot == "steerable":
            names.append(f"{LEGS[leg]}_steering_joint")
            position.append(s.heading[:, leg] - s.euler[:, 0])
            velocity.append(s.heading_rate[:, leg] - s.euler_rate[:, 0])
        if data.foot != "point" and data.wheel_radius is not None:
            names.append(f"{LEGS[leg]}_wheel_joint")
            position.append(angle[:, leg])
            velocity.append(s.speed[:, leg] / data.wheel_radius)
    count = len(s.time)
    return Sampled(
        robot=robot,
        samples=s,
        base_position=s.com_position,
        base_quaternion=np.asarray(Rotation.from_euler("ZYX", s.euler).as_quat()),
        joint_names=tuple(names),
        joint_position=np.stack(position, axis=1) if names else np.zeros((count, 0)),
        joint_velocity=np.stack(velocity, axis=1) if names else np.zeros((count, 0)),
        joint_effort=np.zeros((count, 0)),
        wheel_angle=angle,
        terrain=terrain_of(plan),
    )


def _of_joints(joints: JointTrajectory, rate: float) -> Sampled:
    index = _nearest(joints.time, rate)
    s = joints.reference.at(index)
    return Sampled(
        robot=joints.robot,
        samples=s,
        base_position=joints.base_position[index],
        base_quaternion=joints.base_quaternion[index],
        joint_names=joints.joint_names,
        joint_position=joints.joint_position[index],
        joint_velocity=joints.joint_velocity[index],
        joint_effort=joints.joint_torque[index],
        wheel_angle=wheel_angle(s, joints.robot),
        terrain=terrain_of(joints),
    )


def terrain_of(motion: Motion) -> Terrain:
    """The ground of a motion; of joints that do not say theirs a plane under their feet."""
    if isinstance(motion, Plan):
        return motion.scenario.terrain
    return motion.terrain or Terrain(float(motion.reference.foot_position[..., 2].min()))


def wheel_angle(s: Samples, robot: Robot) -> Array:
    """Angle by which each wheel has turned since the first sample, (n, 4), rad; 0 for point feet."""
    radius = np.array([leg.wheel_radius or np.inf for leg in robot.leg_list])
    steps = 0.5 * (s.speed[1:] + s.speed[:-1]) * np.diff(s.time)[:, None]
    return np.asarray(np.concatenate([np.zeros((1, 4)), np.cumsum(steps, axis=0)]) / radius)


def _nearest(time: Array, rate: float) -> NDArray[np.intp]:
    """Samples of `time` nearest to a rate, each at most once, both ends included."""
    if not (math.isfinite(rate) and rate > 0.0):
        raise InputError("rate", rate, "must be a positive number of samples per second (Hz)")
    if rate * (time[-1] - time[0]) > MAX_SAMPLES:
        rule = f"must be at most {MAX_SAMPLES / (time[-1] - time[0]):.6g} Hz for so long a motion"
        raise InputError("rate", rate, rule)
    wanted = np.append(np.arange(time[0], time[-1] - 1e-9, 1.0 / rate), time[-1])
    return np.unique(
        np.clip(np.round(np.interp(wanted, time, np.arange(len(time)))), 0, len(time) - 1)
    ).astype(np.intp)
