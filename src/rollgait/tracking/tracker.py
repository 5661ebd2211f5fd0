"""The whole body follows a plan: one step of the stack per sample, then velocities, torques and a report."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.spatial.transform import Rotation

from rollgait.errors import InputError
from rollgait.plan.plan import Plan
from rollgait.plan.samples import Samples
from rollgait.robot.robot import LEG_NAMES
from rollgait.robot.urdf_model import BASE_V, BodyState, WholeBodyModel, load_model
from rollgait.robot.whole_body import WholeBody
from rollgait.tracking import tasks
from rollgait.tracking.headings import held_headings
from rollgait.tracking.joints import JointTrajectory
from rollgait.tracking.report import TrackingReport, body_rows, joint_rows, leg_rows
from rollgait.tracking.stack import solve

Array = NDArray[np.float64]

START_ITERATIONS: Final = 100
"""Steps in which the posture at t = 0 must be found."""

START_TOLERANCE: Final = 1e-8
"""Largest error, m or rad, with which it counts as found."""

START_STEP: Final = 0.2
"""Largest change of a joint in one of these steps, rad: keeps the knees on their side."""

PLANNED_LEVELS: Final = 3
"""Levels that follow the plan; those below are the posture's."""

Stack = list[list[tasks.Task]]


def follow(plan: Plan, body: WholeBody, rate: float, waist: str = "com") -> JointTrajectory:
    """Tracks a plan; see `rollgait.track`."""
    model = load_model(body)
    samples = plan.sample_every(rate)
    samples = replace(samples, heading=held_headings(plan, samples, model))
    stack = build_stack(model, waist)
    motion = _integrate(model, stack, samples, _roll_steps(plan, samples, model))
    return _as_trajectory(plan, model, samples, motion)


def build_stack(model: WholeBodyModel, waist: str = "com") -> Stack:
    """The levels of the paper: feet XYZ / wheel rolling and foot orientation / waist / posture.

    The posture of the legs stands below that of the upper body: else arms would swing to let the legs be near
    theirs.
    """
    if waist == "com":
        place: tasks.Task = tasks.CentreOfMass()
    else:
        state = model.state(model.posture)
        place = tasks.WaistPosition(state.R_world_base.T @ (state.p_base - state.p_com))
    return [
        [tasks.FootPosition()],
        [
            tasks.WheelRolling(model),
            tasks.WheelHeading(model),
            tasks.FootTilt(model),
            tasks.WheelCamber(model),
        ],
        [place, tasks.WaistOrientation()],
        [tasks.Posture(model, model.posture, tasks.upper_body(model))],
        [tasks.Posture(model, model.posture, tasks.leg_joints(model))],
    ]


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


def _integrate(model: WholeBodyModel, stack: Stack, samples: Samples, roll: Array) -> _Motion:
    n = len(samples.time)
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
        motion.contact_force[k] = np.einsum("lij,li->j", state.J_contact, samples.force[k])
        motion.foot_error[k] = np.linalg.norm(samples.foot_position[k] - state.p_foot, axis=1)
        away = (samples.heading[k] - state.heading + np.pi) % (2.0 * np.pi) - np.pi
        motion.heading_error[k] = np.abs(away) * steered
        motion.camber[k] = np.abs(state.camber)
        motion.com_error[k] = np.linalg.norm(samples.com_position[k] - state.p_com)
        motion.base_error[k] = np.linalg.norm(tasks.rotation_vector(rotations[k] @ state.R_world_base.T))

    state = stand(model, stack, target(0))
    note(0, state)
    for k in range(1, n):
        begin = clock.perf_counter()
        lower, upper = step_bounds(model, state.q, samples.time[k] - samples.time[k - 1])
        step = solve(levels_of(stack, state, target(k)), lower, upper)
        state = model.state(model.integrate(state.q, step.x))
        motion.seconds[k - 1] = clock.perf_counter() - begin
        motion.bounded += step.bounded
        motion.failed += bool(step.failed)
        note(k, state)
    return motion


def stand(model: WholeBodyModel, stack: Stack, target: tasks.Target) -> BodyState:
    """The whole body as it stands at a target, found from the model's posture.

    Raises:
        InputError: it cannot stand so: a foot, a heading or the CoM stays away from its place.
    """
    q = model.posture.copy()
    turn = np.arctan2(target.R_world_base[1, 0], target.R_world_base[0, 0])
    q[3:7] = Rotation.from_euler("z", turn).as_quat()
    state = model.state(q)
    q[:3] += target.p_com - state.p_com
    state = model.state(q)
    error = np.inf
    for _ in range(START_ITERATIONS):
        levels = levels_of(stack, state, target)
        error = max(float(np.max(np.abs(b), initial=0.0)) for _, b in levels[:PLANNED_LEVELS])
        if error < START_TOLERANCE:
            return state
        lower, upper = step_bounds(model, state.q, np.inf)
        step = solve(levels, np.maximum(lower, -START_STEP), np.minimum(upper, START_STEP))
        state = model.state(model.integrate(state.q, step.x))
    errors = [
        (float(np.max(np.abs(t.error(state, target)), initial=0.0)), t.name)
        for s in stack[:PLANNED_LEVELS]
        for t in s
    ]
    worst, name = max(errors)
    raise InputError(
        "plan",
        f"the start of {model.config.name}",
        f"is out of reach of the whole body: {name} stays {worst:.2g} m or rad away",
    )


def levels_of(stack: Stack, state: BodyState, target: tasks.Target) -> list[tuple[Array, Array]]:
    """Jacobian and error of each level, as `stack.solve` takes them."""
    return [
        (
            np.concatenate([task.jacobian(state) for task in level]),
            np.concatenate([task.error(state, target) for task in level]),
        )
        for level in stack
    ]


def step_bounds(model: WholeBodyModel, q: Array, duration: float) -> tuple[Array, Array]:
    """Smallest and largest step within the limits of joint positions and velocities, each of shape (nv,)."""
    upper = np.full(model.nv, np.inf)
    lower = -upper
    angles = q[BASE_V + 1 :]
    reach = model.velocity_max * duration
    lower[BASE_V:] = np.clip(model.position_lower - angles, -reach, reach)
    upper[BASE_V:] = np.clip(model.position_upper - angles, -reach, reach)
    return lower, upper


def _roll_steps(plan: Plan, samples: Samples, model: WholeBodyModel) -> Array:
    """∫ v/R dt over each step, (n − 1, 4), rad; the speed is constant in an interval."""
    middle = plan.sample(0.5 * (samples.time[1:] + samples.time[:-1]))
    radii = np.array([leg.radius if leg.wheel is not None else np.inf for leg in model.legs])
    return np.asarray(middle.speed * np.diff(samples.time)[:, None] / radii)


def _as_trajectory(plan: Plan, model: WholeBodyModel, samples: Samples, motion: _Motion) -> JointTrajectory:
    t = samples.time
    velocity = _velocities(model, t, motion.q)
    longest = float(plan.schedule.lengths.max())
    torque = _generalised_forces(model, t, motion.q, velocity, longest) - motion.contact_force
    angles = motion.q[:, BASE_V + 1 :]
    margin = np.minimum(angles - model.position_lower, model.position_upper - angles)
    speed = np.abs(np.diff(angles, axis=0)) / np.diff(t)[:, None]
    use = np.abs(torque[:, BASE_V:]) / model.effort_max
    rows = [
        *leg_rows(t, motion.foot_error, motion.heading_error),
        *body_rows(t, motion.com_error, motion.base_error, motion.camber),
        *joint_rows(t, model.joint_names, margin, speed, model.velocity_max, use),
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
        report=report,
    )


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
