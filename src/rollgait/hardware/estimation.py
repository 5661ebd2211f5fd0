"""From joints, IMU and odometry to the state that the controller takes, and to what presses on the feet."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rollgait.angles import euler_angles, euler_rates, near
from rollgait.hardware.measured import Imu, Joints, Odometry
from rollgait.plant.state import RobotState
from rollgait.robot.robot import LEG_NAMES, Robot
from rollgait.robot.urdf_model import BASE_V, BodyState, WholeBodyModel

Array = NDArray[np.float64]

FORCE_TIME: Final = 0.02
"""Time constant of the forces, s: noise of the efforts and what legs weigh more while they speed up."""
PRESSES: Final = 0.08
"""A foot presses from this share of the robot's weight on: a leg that swings shows up to 0.07."""
LIFTED: Final = 0.05
"""It does until it shows less than that."""
SINGULAR: Final = 1e-3
"""Share of the largest singular value below which efforts say nothing about a direction: a straight knee."""


def base_rotation(imu: Imu, odometry: Odometry) -> Array:
    """R_world_base: tilt of the IMU, which knows where down is, and yaw of the odometry, which does not drift
    with a gyroscope; (3, 3)."""
    tilted, turned = (
        euler_angles(Rotation.from_quat(q).as_matrix()) for q in (imu.quaternion, odometry.quaternion)
    )
    return np.asarray(Rotation.from_euler("ZYX", [turned[0], tilted[1], tilted[2]]).as_matrix())


class BodyEstimator:
    """Puts what sensors say together by the kinematics and dynamics of the whole body.

    Sensors give base pose and velocities and joints; CoM, feet, headings and their velocities follow. Forces
    on the feet are those that the efforts of their legs leave unexplained, as if nothing were accelerated.

    Args:
        model: the whole body, with what it carries.
        robot: the planner's robot of it.
        period: at which it is asked, s.

    Attributes:
        contact_force: on the feet, world, (4, 3), N.
        touching: which feet press on the ground, (4,).
        body: the whole body as it was measured last; None at first.
    """

    def __init__(self, model: WholeBodyModel, robot: Robot, period: float) -> None:
        self._model = model
        self._weight = robot.weight
        self._keep = float(np.exp(-period / FORCE_TIME))
        self._radius = np.array([leg.radius if leg.wheel is not None else 0.0 for leg in model.legs])
        self._wheels = np.array([leg.wheel is not None for leg in model.legs])
        self._rows = [np.array(leg.joints) for leg in model.legs]
        self.reset()

    def reset(self) -> None:
        """Forgets the past."""
        self._last: RobotState | None = None
        self.body: BodyState | None = None
        self.contact_force: Array = np.zeros((len(LEG_NAMES), 3))
        self.touching: NDArray[np.bool_] = np.zeros(len(LEG_NAMES), dtype=bool)
        self._has_force = False

    def estimate(self, time: float, joints: Joints, imu: Imu, odometry: Odometry) -> RobotState:
        """The state, said to be that of a time, s; yaw and headings go on from the last one."""
        R = base_rotation(imu, odometry)
        q = np.concatenate([odometry.position, Rotation.from_matrix(R).as_quat(), joints.position])
        v = np.concatenate([odometry.velocity, imu.angular_velocity, joints.velocity])
        body = self._model.state(q)
        self._take_efforts(body, v, joints.effort)
        euler, heading = euler_angles(R), body.heading
        heading = np.where(self._wheels, heading, euler[0])
        if self._last is not None:
            euler[0] = near(euler[0], self._last.euler[0])
            heading = near(heading, self._last.heading)
        else:
            heading = near(heading, euler[0])
        self.body = body
        self._last = RobotState(
            time=time,
            com_position=body.p_com,
            euler=euler,
            com_velocity=body.J_com @ v,
            euler_rate=euler_rates(euler, R @ imu.angular_velocity),
            foot_position=body.p_foot,
            heading=heading,
            speed=self._radius * (body.J_roll @ v),
        )
        return self._last

    def _take_efforts(self, body: BodyState, v: Array, effort: Array) -> None:
        """Forces on the feet, and which press."""
        need = self._model.inverse_dynamics(body.q, v, np.zeros(self._model.nv))
        found = np.empty((len(LEG_NAMES), 3))
        for leg, rows in enumerate(self._rows):
            unexplained = need[rows] - effort[rows - BASE_V]
            found[leg] = np.linalg.lstsq(body.J_contact[leg][:, rows].T, unexplained, rcond=SINGULAR)[0]
        keep = self._keep if self._has_force else 0.0
        self._has_force = True
        self.contact_force = keep * self.contact_force + (1.0 - keep) * found
        share = self.contact_force[:, 2] / self._weight
        self.touching = (share > PRESSES) | (self.touching & (share > LIFTED))
