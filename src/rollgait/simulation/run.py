"""The loop: joints → physics → log."""

from __future__ import annotations

import time as clock
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.plant.disturbances import Disturbances
from rollgait.robot.whole_body import WholeBody
from rollgait.simulation.controller import Gains, interpolated, reference_at, smoothing_of
from rollgait.simulation.drives import gains_of
from rollgait.simulation.feedback import PERIOD, BaseFeedback
from rollgait.simulation.log import SimulationLog
from rollgait.simulation.measure import slip
from rollgait.simulation.physics import Physics, Pose
from rollgait.simulation.world import TIME_STEP
from rollgait.terrain.terrain import Terrain
from rollgait.tracking.joints import JointTrajectory

Array = NDArray[np.float64]

LOG_PERIOD: Final = 0.005
"""Time between two samples of the log, s."""

STANDING: Final = 0.5
"""How long the robot stands after the motion, s: where it comes to rest counts."""


def run(
    joints: JointTrajectory,
    body: WholeBody,
    disturbances: Disturbances,
    *,
    feedback: bool = False,
    wheels: str = "angle",
    gains: Gains | None = None,
    terrain: Terrain | None = None,
) -> SimulationLog:
    """Simulates a joint trajectory; see `rollgait.simulate`."""
    drives = gains or gains_of(joints.robot, body, joints.joint_names, wheels)
    return _Run(body, joints, disturbances, drives, feedback, terrain).log()


def _ground_height(joints: JointTrajectory) -> float:
    """z of the ground: where the plan has its stance feet, m."""
    samples = joints.reference
    return float(np.mean(samples.foot_position[samples.contact][:, 2]))


class _Run:
    """One simulation: the robot as it is planned at t = 0, at rest, then the plan, then the rest after it."""

    def __init__(
        self,
        body: WholeBody,
        joints: JointTrajectory,
        disturbances: Disturbances,
        gains: Gains,
        feedback: bool,
        terrain: Terrain | None,
    ) -> None:
        self._joints, self._disturbances, self._terrain = joints, disturbances, terrain
        self._end = float(joints.time[-1])
        lead = 0.5 * smoothing_of(joints)  # the smoothed motion begins that early, from rest
        first, last = -round(lead / TIME_STEP), round((self._end + STANDING) / TIME_STEP)
        times: Array = np.arange(first, last + 1) * np.float64(TIME_STEP)
        self._count = len(times)
        self._physics = Physics(
            body,
            joints.joint_names,
            gains,
            disturbances,
            Pose(joints.base_position[0], joints.base_quaternion[0], joints.joint_position[0]),
            reference_at(joints, times),
            ground=_ground_height(joints),
            begins=lead,
            terrain=terrain,
            wrenches=joints.wrenches,
            sliding=any(leg.slip_max for leg in joints.robot.leg_list),
        )
        self._ground = self._physics.ground
        self._feedback = BaseFeedback(self._physics.world, joints) if feedback else None
        self._rows: list[dict[str, Array]] = []

    def log(self) -> SimulationLog:
        """Runs to the end, or until the robot has fallen."""
        begin = clock.perf_counter()
        physics = self._physics
        every, correction = round(LOG_PERIOD / TIME_STEP), round(PERIOD / TIME_STEP)
        fallen_at = None
        for row in range(self._count):
            time, number = physics.time, physics.steps
            if self._feedback is not None and number >= 0 and row % correction == 0:
                physics.drives.shift, physics.drives.shift_rate = self._feedback.update(time, physics.data)
            physics.begin_step(row)
            noted = number >= 0 and number % every == 0
            state = self._state(time) if noted else {}
            physics.end_step()
            if noted:
                load, torque = physics.take_load(), physics.data.actuator_force.copy()
                loads = {"force": load.force, "torque_peak": load.torque_peak, "joint_torque": torque}
                self._rows.append(state | loads)
                if physics.has_fallen:
                    fallen_at = time
                    break
        return self._as_log(fallen_at, clock.perf_counter() - begin)

    def _state(self, time: float) -> dict[str, Array]:
        """What the log says of the state at the beginning of a step."""
        world, data, pose = self._physics.world, self._physics.data, self._physics.pose
        R_world_base = data.xmat[world.base].reshape(3, 3)
        return {
            "time": np.array(time),
            **pose._asdict(),
            "base_velocity": np.concatenate([R_world_base.T @ data.qvel[:3], data.qvel[3:6]]),
            "joint_velocity": data.qvel[world.velocity],
            "com_position": data.subtree_com[world.base].copy(),
            "slip": slip(world, data),
        }

    def _as_log(self, fallen_at: float | None, wall_time: float) -> SimulationLog:
        joints = self._joints
        measured = {name: np.array([row[name] for row in self._rows]) for name in self._rows[0]}
        times = measured["time"]
        samples = joints.reference
        place = np.clip(np.searchsorted(samples.time, times + 1e-9) - 1, 0, len(samples.time) - 1)
        quaternion = interpolated(times, joints.time, _without_jumps(joints.base_quaternion))
        return SimulationLog(
            **measured,
            planned_base_position=interpolated(times, joints.time, joints.base_position),
            planned_base_quaternion=quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True),
            planned_com_position=interpolated(times, samples.time, samples.com_position),
            planned_force=samples.force[place],
            planned_contact=samples.contact[place],
            effort_max=self._physics.world.effort_max,
            joint_names=joints.joint_names,
            robot=joints.robot,
            disturbances=self._disturbances,
            feedback=self._feedback is not None,
            ground_height=self._ground,
            motion_end=self._end,
            fallen_at=fallen_at,
            wall_time=wall_time,
            terrain=self._terrain,
            unplanned=tuple(self._physics.unplanned.values()),
        )


def _without_jumps(quaternions: Array) -> Array:
    """The same rotations, each quaternion with the sign that is nearer to the one before."""
    same = np.sum(quaternions[1:] * quaternions[:-1], axis=1) >= 0.0
    signs = np.concatenate([[1.0], np.cumprod(np.where(same, 1.0, -1.0))])
    return np.asarray(quaternions * signs[:, None])
