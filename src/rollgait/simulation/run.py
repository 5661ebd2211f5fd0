"""The loop: joints → physics → log."""

from __future__ import annotations

import time as clock
from typing import Any, Final

import mujoco
import numpy as np
from numpy.typing import NDArray

from rollgait.plant.disturbances import Disturbances
from rollgait.robot.whole_body import WholeBody
from rollgait.simulation.controller import SMOOTHING, Controller, Gains, interpolated, reference_at
from rollgait.simulation.drives import gains_of
from rollgait.simulation.feedback import PERIOD, BaseFeedback
from rollgait.simulation.log import SimulationLog
from rollgait.simulation.measure import contact_forces, has_fallen, slip
from rollgait.simulation.world import TIME_STEP, World, build_world
from rollgait.tracking.joints import JointTrajectory

Array = NDArray[np.float64]

LOG_PERIOD: Final = 0.005
"""Time between two samples of the log, s."""

LEAD: Final = 0.5 * SMOOTHING
"""How long before t = 0 the simulation begins, s: the smoothed motion begins there, from rest."""

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
) -> SimulationLog:
    """Simulates a joint trajectory; see `rollgait.simulate`."""
    ground = _ground_height(joints)
    drives = gains or gains_of(joints.robot, body, joints.joint_names, wheels)
    world = build_world(body, joints.joint_names, disturbances, damping=drives.damping, ground_height=ground)
    return _Run(world, joints, disturbances, drives, feedback, ground).log()


def _ground_height(joints: JointTrajectory) -> float:
    """z of the ground: where the plan has its stance feet, m."""
    samples = joints.reference
    return float(np.mean(samples.foot_position[samples.contact][:, 2]))


class _Run:
    """One simulation."""

    def __init__(
        self,
        world: World,
        joints: JointTrajectory,
        disturbances: Disturbances,
        gains: Gains,
        feedback: bool,
        ground: float,
    ) -> None:
        self._world, self._joints, self._disturbances, self._ground = world, joints, disturbances, ground
        self._data: Any = mujoco.MjData(world.model)
        end = float(joints.time[-1])
        self._end = end
        first, last = -round(LEAD / TIME_STEP), round((end + STANDING) / TIME_STEP)
        self._times: Array = np.arange(first, last + 1) * np.float64(TIME_STEP)
        delay = round(disturbances.latency / TIME_STEP)
        self._controller = Controller(gains, reference_at(joints, self._times), delay)
        self._feedback = BaseFeedback(world, joints) if feedback else None
        self._rows: list[dict[str, Array]] = []
        self._begin()

    def _begin(self) -> None:
        """The robot as it is planned at t = 0, at rest."""
        joints, world, data = self._joints, self._world, self._data
        data.qpos[:3] = joints.base_position[0]
        data.qpos[2] += world.lift
        data.qpos[3:7] = np.roll(joints.base_quaternion[0], 1)
        data.qpos[world.position] = joints.joint_position[0]
        mujoco.mj_forward(world.model, data)

    def log(self) -> SimulationLog:
        """Runs to the end, or until the robot has fallen."""
        begin = clock.perf_counter()
        world, data, model = self._world, self._data, self._world.model
        every, correction = round(LOG_PERIOD / TIME_STEP), round(PERIOD / TIME_STEP)
        force, samples = np.zeros((4, 3)), 0
        peak = np.zeros(len(world.joint_names))
        height = float(self._joints.base_position[0, 2]) - self._ground
        fallen_at = None
        for step, time in enumerate(self._times):
            if self._feedback is not None and time >= 0.0 and step % correction == 0:
                self._correct(float(time))
            data.ctrl[:] = self._controller.control(step, data.qpos[world.position])
            self._push(float(time))
            mujoco.mj_step1(model, data)
            number = round(float(time) / TIME_STEP)
            noted = number >= 0 and number % every == 0
            row = self._state(float(time)) if noted else {}
            mujoco.mj_step2(model, data)  # forces are known only here, where positions have moved on
            force += contact_forces(world, data)
            np.maximum(peak, np.abs(data.actuator_force), out=peak)
            samples += 1
            if noted:
                row |= {"force": force / samples, "torque_peak": peak}
                self._rows.append(row | {"joint_torque": data.actuator_force.copy()})
                force, samples, peak = np.zeros((4, 3)), 0, np.zeros_like(peak)
                if has_fallen(world, data, self._ground, height):
                    fallen_at = float(time)
                    break
        return self._as_log(fallen_at, clock.perf_counter() - begin)

    def _correct(self, time: float) -> None:
        data, feedback = self._data, self._feedback
        assert feedback is not None
        shift, rate = feedback.update(time, data)
        self._controller.shift, self._controller.shift_rate = shift, rate

    def _push(self, time: float) -> None:
        pushes = self._disturbances.pushes
        if pushes:
            acting = [p.vector for p in pushes if p.start <= time < p.start + p.duration]
            self._data.xfrc_applied[self._world.base, :3] = np.sum(acting, axis=0) if acting else 0.0

    def _state(self, time: float) -> dict[str, Array]:
        """What the log says of the state at the beginning of a step."""
        world, data = self._world, self._data
        R_world_base = data.xmat[world.base].reshape(3, 3)
        return {
            "time": np.array(time),
            "base_position": data.qpos[:3].copy(),
            "base_quaternion": np.roll(data.qpos[3:7], -1),
            "base_velocity": np.concatenate([R_world_base.T @ data.qvel[:3], data.qvel[3:6]]),
            "joint_position": data.qpos[world.position],
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
            effort_max=self._world.effort_max,
            joint_names=joints.joint_names,
            robot=joints.robot,
            disturbances=self._disturbances,
            feedback=self._feedback is not None,
            ground_height=self._ground,
            motion_end=self._end,
            fallen_at=fallen_at,
            wall_time=wall_time,
        )


def _without_jumps(quaternions: Array) -> Array:
    """The same rotations, each quaternion with the sign that is nearer to the one before."""
    same = np.sum(quaternions[1:] * quaternions[:-1], axis=1) >= 0.0
    signs = np.concatenate([[1.0], np.cumprod(np.where(same, 1.0, -1.0))])
    return np.asarray(quaternions * signs[:, None])
