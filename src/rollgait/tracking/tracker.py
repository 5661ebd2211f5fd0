"""The whole body follows a plan: one step of the stack per sample, then velocities, torques and a report."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.spatial.transform import Rotation

from rollgait.plan.plan import Plan
from rollgait.plan.samples import Samples, way_factor
from rollgait.robot.robot import LEG_NAMES
from rollgait.robot.urdf_model import BASE_V, BodyState, WholeBodyModel, load_model
from rollgait.robot.whole_body import WholeBody
from rollgait.tracking import tasks
from rollgait.tracking.clearance import Clearances, Nearest
from rollgait.tracking.headings import held_headings
from rollgait.tracking.joints import JointTrajectory
from rollgait.tracking.kinematics import InverseKinematics, carried
from rollgait.tracking.report import TrackingReport, body_rows, clearance_rows, joint_rows, leg_rows
from rollgait.tracking.skid import spin

Array = NDArray[np.float64]


def follow(plan: Plan, body: WholeBody, rate: float, waist: str = "com") -> JointTrajectory:
    """Tracks a plan; see `rollgait.track`."""
    model = load_model(body)
    samples = plan.sample_every(rate)
    samples = replace(samples, heading=held_headings(plan, samples, model))
    kinematics = InverseKinematics(model, waist)
    motion = _integrate(kinematics, samples, _roll_steps(plan, samples, kinematics))
    return _as_trajectory(plan, model, samples, motion)


@dataclass
class _Motion:
    """What the loop writes down, one row per sample (n) or step (n − 1)."""

    q: Array
    contact_force: Array
    foot_error: Array
    heading_error: Array
    camber: Array
    com_error: Array
    base_error: Array
    seconds: Array
    bounded: int = 0
    failed: int = 0


def _integrate(kinematics: InverseKinematics, samples: Samples, roll: Array) -> _Motion:
    n, model = len(samples.time), kinematics.model
    rotations = Rotation.from_euler("ZYX", samples.euler).as_matrix()
    motion = _Motion(
        q=np.zeros((n, model.nv + 1)),
        contact_force=np.zeros((n, model.nv)),
        foot_error=np.zeros((n, len(LEG_NAMES))),
        heading_error=np.zeros((n, len(LEG_NAMES))),
        camber=np.zeros((n, len(LEG_NAMES))),
        com_error=np.zeros(n),
        base_error=np.zeros(n),
        seconds=np.zeros(n - 1),
    )
    contact_offset = samples.contact_position - samples.foot_position
    steered = np.array(["heading" in rows for rows in model.orientation_rows])

    def target(k: int) -> tasks.Target:
        return tasks.Target(
            samples.com_position[k],
            rotations[k],
            samples.foot_position[k],
            samples.heading[k],
            roll[k - 1] if k else np.zeros(len(LEG_NAMES)),
        )

    def note(k: int, state: BodyState) -> None:
        motion.q[k] = state.q
        motion.contact_force[k] = carried(state, samples.force[k], contact_offset[k])
        motion.foot_error[k] = np.linalg.norm(samples.foot_position[k] - state.p_foot, axis=1)
        away = (samples.heading[k] - state.heading + np.pi) % (2.0 * np.pi) - np.pi
        motion.heading_error[k] = np.abs(away) * steered
        motion.camber[k] = np.abs(state.camber)
        motion.com_error[k] = np.linalg.norm(samples.com_position[k] - state.p_com)
        motion.base_error[k] = np.linalg.norm(tasks.rotation_vector(rotations[k] @ state.R_world_base.T))

    state = kinematics.stand(target(0))
    note(0, state)
    for k in range(1, n):
        begin = clock.perf_counter()
        step, state = kinematics.step(state, target(k), samples.time[k] - samples.time[k - 1])
        motion.seconds[k - 1] = clock.perf_counter() - begin
        motion.bounded += step.bounded
        motion.failed += bool(step.failed)
        note(k, state)
    return motion


def _roll_steps(plan: Plan, samples: Samples, kinematics: InverseKinematics) -> Array:
    """∫ v/R dt over each step, (n − 1, 4), rad; v along the ground, constant in an interval on a plane.

    Wheels that slide sideways also spin.
    """
    middle = plan.sample(0.5 * (samples.time[1:] + samples.time[:-1]))
    speed = middle.speed * way_factor(middle) + spin(plan, middle)
    return np.asarray(speed * np.diff(samples.time)[:, None] / kinematics.rolling_radius)


def _as_trajectory(plan: Plan, model: WholeBodyModel, samples: Samples, motion: _Motion) -> JointTrajectory:
    t = samples.time
    velocity = _velocities(model, t, motion.q)
    longest = float(plan.schedule.lengths.max())
    torque = _generalised_forces(model, t, motion.q, velocity, longest) - motion.contact_force
    torque[:, :3] -= _pulled(plan, t, motion.q)
    angles = motion.q[:, BASE_V + 1 :]
    margin = np.minimum(angles - model.position_lower, model.position_upper - angles)
    speed = np.abs(np.diff(angles, axis=0)) / np.diff(t)[:, None]
    use = np.abs(torque[:, BASE_V:]) / model.effort_max
    rows = [
        *leg_rows(t, motion.foot_error, motion.heading_error),
        *body_rows(t, motion.com_error, motion.base_error, motion.camber),
        *joint_rows(t, model.joint_names, margin, speed, model.velocity_max, use),
        *clearance_rows(*_clearances(plan, model, t, motion.q)),
    ]
    report = TrackingReport(
        rows=tuple(rows),
        steps=len(motion.seconds),
        bounded_steps=motion.bounded,
        failed_steps=motion.failed,
        step_time=float(np.mean(motion.seconds)),
        step_time_max=float(np.max(motion.seconds)),
        wrench_mismatch=float(np.sqrt(np.mean(np.sum(torque[:, :3] ** 2, axis=1)))),
    )
    return JointTrajectory(
        time=t,
        joint_names=model.joint_names,
        base_position=motion.q[:, :3],
        base_quaternion=motion.q[:, 3:7],
        base_velocity=velocity[:, :BASE_V],
        joint_position=angles,
        joint_velocity=velocity[:, BASE_V:],
        joint_torque=torque[:, BASE_V:],
        reference=samples,
        robot=plan.robot,
        interval=longest,
        report=report,
        terrain=plan.scenario.terrain,
        wrenches=plan.scenario.wrenches,
    )


def _pulled(plan: Plan, t: Array, q: Array) -> Array:
    """Forces of wrenches on the base in its axes, (n, 3), N: the joints feel them through the feet alone."""
    total = np.zeros((len(t), 3))
    for wrench in plan.scenario.wrenches:
        force = np.tile(wrench.force, (len(t), 1))
        if wrench.frame == "world":
            force = Rotation.from_quat(q[:, 3:7]).inv().apply(force)
        total += wrench.acts_at(t)[:, None] * force
    return total


def _clearances(
    plan: Plan, model: WholeBodyModel, t: Array, q: Array
) -> tuple[Nearest | None, Nearest | None]:
    """Nearest approaches of the body and the ground, and of two legs."""
    clearances = Clearances(model)
    return clearances.ground(t, q, plan.scenario.terrain), clearances.legs(t, q)


def _velocities(model: WholeBodyModel, t: Array, q: Array) -> Array:
    """v by central differences, one-sided at both ends, (n, nv)."""
    n = len(t)
    before = np.maximum(np.arange(n) - 1, 0)
    after = np.minimum(np.arange(n) + 1, n - 1)
    steps = np.array([model.difference(q[i], q[k]) for i, k in zip(before, after, strict=True)])
    return np.asarray(steps / (t[after] - t[before])[:, None])


def _generalised_forces(model: WholeBodyModel, t: Array, q: Array, v: Array, longest: float) -> Array:
    """Inverse dynamics, (n, nv).

    Within an interval of the plan speeds are constant and jump at its ends: an acceleration has a meaning
    only as a mean over an interval, and is taken so: over the longest one, s.
    """
    width = max(1, round(longest / float(np.median(np.diff(t)))))
    smooth = uniform_filter1d(v, width, axis=0, mode="nearest")
    acceleration = np.gradient(smooth, t, axis=0)
    return np.array([model.inverse_dynamics(*row) for row in zip(q, v, acceleration, strict=True)])
