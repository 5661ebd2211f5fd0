"""The feet, the CoM and the forces of a simulated whole body, as samples like those of a plan."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rollgait.plan.samples import Array, Samples, level_contact, rate_of
from rollgait.robot.link_poses import Poses, link_poses
from rollgait.robot.urdf_feet import FootShape, measure_foot
from rollgait.robot.urdf_files import read_urdf
from rollgait.robot.whole_body import find_whole_body
from rollgait.simulation.log import SimulationLog

CONTACT_FORCE = 1.0
"""A foot that presses with more than this (N) touches the ground."""


def samples_of_log(log: SimulationLog, index: NDArray[np.intp], times: Array) -> Samples:
    """The motion of a log at some of its samples, (n,), called `times`.

    Velocities are differences of neighbouring frames, headings those of the wheels' axles.
    """
    body = find_whole_body(log.robot)
    urdf = read_urdf(body.urdf)
    poses = link_poses(
        urdf,
        log.joint_names,
        log.joint_position[index],
        log.base_position[index],
        log.base_quaternion[index],
    )
    foot, heading = np.zeros((len(times), 4, 3)), np.zeros((len(times), 4))
    for leg, (name, joints) in enumerate(body.leg_list()):
        shape = measure_foot(urdf, f"legs.{name}", joints)
        foot[:, leg], heading[:, leg] = _contact_point(poses[joints.frame], shape)
    com, euler = log.com_position[index], euler_of(log.base_quaternion[index])
    heading = np.unwrap(heading, period=np.pi, axis=0)
    heading -= np.pi * np.round((heading[0] - euler[0, 0]) / np.pi)  # an axle has no front: take the base's
    velocity = rate_of(foot, times)
    speed = velocity[..., 0] * np.cos(heading) + velocity[..., 1] * np.sin(heading)
    return Samples(
        time=times,
        com_position=com,
        euler=euler,
        com_velocity=rate_of(com, times),
        euler_rate=rate_of(euler, times),
        foot_position=foot,
        foot_velocity=velocity,
        heading=heading,
        heading_rate=rate_of(heading, times),
        speed=speed,
        force=log.force[index],
        contact=log.force[index][..., 2] > CONTACT_FORCE,
        **level_contact(foot),
    )


def euler_of(xyzw: Array) -> Array:
    """(yaw, pitch, roll), yaw counted on beyond a full turn."""
    return np.unwrap(Rotation.from_quat(xyzw).as_euler("ZYX"), axis=0)


def _contact_point(pose: Poses, shape: FootShape) -> tuple[Array, Array]:
    """Lowest point of the rim (or ball), (n, 3), and the heading of the wheel, (n,)."""
    centre = pose.p + pose.R @ shape.centre
    down = np.broadcast_to([0.0, 0.0, -1.0], pose.p.shape)
    if not shape.axle.any():
        return centre + shape.radius * down, np.zeros(len(pose.p))
    axle = pose.R @ shape.axle
    radial = down - (down * axle).sum(axis=-1, keepdims=True) * axle
    radial /= np.linalg.norm(radial, axis=-1, keepdims=True)
    return centre + shape.radius * radial, np.arctan2(-axle[:, 0], axle[:, 1])
