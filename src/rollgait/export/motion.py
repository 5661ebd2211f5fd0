"""What exports are made of: a plan, joints or a log, at a fixed rate. Plain arrays in the terms of ROS.

A plan alone, and a log of a robot without legs, know the base by its CoM; with joints it is the root link of
the URDF. Axes and units by REP-103.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rollgait.angles import angular_velocity
from rollgait.errors import InputError
from rollgait.mpc.log import MpcLog
from rollgait.mpc.log_samples import ground_height, samples_of_mpc
from rollgait.plan.plan import MAX_SAMPLES, Plan
from rollgait.plan.samples import Array, Samples, rate_of, way_factor, wheel_angle
from rollgait.robot.robot import Robot
from rollgait.ros.topics import LEGS
from rollgait.simulation.log import SimulationLog
from rollgait.terrain import Terrain
from rollgait.tracking.joints import JointTrajectory

Motion = Plan | JointTrajectory | SimulationLog | MpcLog


@dataclass(frozen=True)
class Sampled:
    """A motion at n times.

    Attributes:
        robot: the planner's robot.
        samples: the plan, or what became of it, (n, …).
        whole: whether the joints are those of the robot's whole body; else they are its steering joints and
            wheels alone, and the base is at the CoM.
        base_position: of the base in the world, (n, 3), m.
        base_quaternion: base to world, (x, y, z, w), (n, 4).
        base_velocity: linear, then angular velocity in base axes, (n, 6), m/s and rad/s.
        joint_names: of the n_j joints.
        joint_position: (n, n_j), rad.
        joint_velocity: (n, n_j), rad/s.
        joint_effort: (n, n_j), N m, or (n, 0) where it is not known.
        wheel_angle: by which each wheel has turned, (n, 4), rad.
        terrain: the ground.
    """

    robot: Robot
    samples: Samples
    whole: bool
    base_position: Array
    base_quaternion: Array
    base_velocity: Array
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

    @property
    def joint_acceleration(self) -> Array:
        """(n, n_j), rad/s²."""
        return rate_of(self.joint_velocity, self.time)


def sampled(motion: Motion, rate: float) -> Sampled:
    """A motion at a rate (Hz), both ends included; joints and logs at the nearest of their own samples.

    Raises:
        InputError: the rate is not positive, or too high.
    """
    if isinstance(motion, Plan):
        return _of_body(motion.sample_every(rate), motion.robot, terrain_of(motion))
    index = _nearest(motion.time, rate)
    if isinstance(motion, JointTrajectory):
        return _of_joints(motion, index)
    if isinstance(motion, SimulationLog):
        return _of_simulation(motion, index)
    s = samples_of_mpc(motion, index, motion.time[index])
    of_body = _of_body(s, motion.robot, terrain_of(motion))
    return _with_legs(of_body, motion, index) if motion.joint_names else of_body


def _of_body(s: Samples, robot: Robot, terrain: Terrain) -> Sampled:
    """A single rigid body: its joints are the steering and the wheel of each leg, relative to the base."""
    angle, factor = _wheel_angle(s, robot), way_factor(s)
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
            velocity.append(s.speed[:, leg] * factor[:, leg] / data.wheel_radius)
    count = len(s.time)
    turn = Rotation.from_euler("ZYX", s.euler)
    omega = angular_velocity(s.euler.T, s.euler_rate.T).T
    return Sampled(
        robot=robot,
        samples=s,
        whole=False,
        base_position=s.com_position,
        base_quaternion=np.asarray(turn.as_quat()),
        base_velocity=np.column_stack([turn.inv().apply(s.com_velocity), turn.inv().apply(omega)]),
        joint_names=tuple(names),
        joint_position=np.stack(position, axis=1) if names else np.zeros((count, 0)),
        joint_velocity=np.stack(velocity, axis=1) if names else np.zeros((count, 0)),
        joint_effort=np.zeros((count, 0)),
        wheel_angle=angle,
        terrain=terrain,
    )


def _of_joints(joints: JointTrajectory, index: NDArray[np.intp]) -> Sampled:
    return _of_whole_body(joints, joints.reference.at(index), index)


def _of_simulation(log: SimulationLog, index: NDArray[np.intp]) -> Sampled:
    """What the robot did; its feet are where its joints have them."""
    from rollgait.simulation.log_samples import samples_of_log

    return _of_whole_body(log, samples_of_log(log, index, log.time[index]), index)


def _of_whole_body(motion: JointTrajectory | SimulationLog, s: Samples, index: NDArray[np.intp]) -> Sampled:
    return Sampled(
        robot=motion.robot,
        samples=s,
        whole=True,
        base_position=motion.base_position[index],
        base_quaternion=motion.base_quaternion[index],
        base_velocity=motion.base_velocity[index],
        joint_names=motion.joint_names,
        joint_position=motion.joint_position[index],
        joint_velocity=motion.joint_velocity[index],
        joint_effort=motion.joint_torque[index],
        wheel_angle=_wheel_angle(s, motion.robot),
        terrain=terrain_of(motion),
    )


def _with_legs(of_body: Sampled, log: MpcLog, index: NDArray[np.intp]) -> Sampled:
    """A run of the controller with the joints of the plant; velocities are differences of the log's rows."""
    quaternion = log.base_quaternion[index]
    linear = rate_of(log.base_position, log.time)[index]
    return replace(
        of_body,
        whole=True,
        base_position=log.base_position[index],
        base_quaternion=quaternion,
        base_velocity=np.column_stack(
            [Rotation.from_quat(quaternion).inv().apply(linear), of_body.base_velocity[:, 3:]]
        ),
        joint_names=log.joint_names,
        joint_position=log.joint_position[index],
        joint_velocity=rate_of(log.joint_position, log.time)[index],
        joint_effort=np.zeros((len(index), 0)),
    )


def terrain_of(motion: Motion) -> Terrain:
    """The ground of a motion; of those that do not say theirs a plane under their feet."""
    if isinstance(motion, Plan):
        return motion.scenario.terrain
    if isinstance(motion, MpcLog):
        return Terrain(ground_height(motion))
    if isinstance(motion, SimulationLog):
        return motion.terrain or Terrain(motion.ground_height)
    return motion.terrain or Terrain(float(motion.reference.foot_position[..., 2].min()))


def _wheel_angle(s: Samples, robot: Robot) -> Array:
    return wheel_angle(s, [leg.wheel_radius for leg in robot.leg_list])


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
