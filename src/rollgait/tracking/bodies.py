"""Joints as poses and velocities of all bodies of a robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.robot.whole_body import find_whole_body
from rollgait.tracking.joints import JointTrajectory

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Bodies:
    """Bodies of the whole body over time, in the world.

    Attributes:
        names: of the B links of the URDF.
        position: of their origins, (n, B, 3), m.
        quaternion: (w, x, y, z), (n, B, 4).
        linear_velocity: of their origins, (n, B, 3), m/s.
        angular_velocity: (n, B, 3), rad/s.
    """

    names: tuple[str, ...]
    position: Array
    quaternion: Array
    linear_velocity: Array
    angular_velocity: Array


def bodies_of(joints: JointTrajectory, index: NDArray[np.intp]) -> Bodies:
    """Where all links of the URDF are at samples `index`, (n,), of a joint trajectory.

    Raises `InputError` if there is no whole-body model of its robot.
    """
    import pinocchio as pin

    model: Any = WholeBodyModel(find_whole_body(joints.robot)).pin
    data = model.createData()
    links = [k for k, frame in enumerate(model.frames) if frame.type == pin.FrameType.BODY]
    names = tuple(str(model.frames[k].name) for k in links)
    order = [joints.joint_names.index(name) for name in model.names[2:]]
    shape = (len(index), len(links))
    position, quaternion = np.zeros((*shape, 3)), np.zeros((*shape, 4))
    linear, angular = np.zeros((*shape, 3)), np.zeros((*shape, 3))
    for n, k in enumerate(index):
        q = np.concatenate(
            [joints.base_position[k], joints.base_quaternion[k], joints.joint_position[k, order]]
        )
        v = np.concatenate([joints.base_velocity[k], joints.joint_velocity[k, order]])
        pin.forwardKinematics(model, data, q, v)
        pin.updateFramePlacements(model, data)
        for b, link in enumerate(links):
            x, y, z, w = pin.Quaternion(data.oMf[link].rotation).coeffs()
            motion = pin.getFrameVelocity(model, data, link, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
            position[n, b], quaternion[n, b] = data.oMf[link].translation, (w, x, y, z)
            linear[n, b], angular[n, b] = motion.linear, motion.angular
    return Bodies(names, position, quaternion, linear, angular)
