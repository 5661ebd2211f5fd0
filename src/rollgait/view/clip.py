"""A clip: a motion ready to be shown, whatever file it comes from. Plain arrays, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.plan.plan import Plan
from rollgait.plan.samples import Array, Samples, wheel_angle
from rollgait.robot.loads import Wrench
from rollgait.robot.robot import Robot
from rollgait.scenario.scenario import Scenario
from rollgait.simulation.log import SimulationLog
from rollgait.terrain import Terrain
from rollgait.tracking import JointTrajectory
from rollgait.view.marks import Mark, marks_of_joints, marks_of_log, marks_of_plan
from rollgait.view.motion import goal_poses

FRAME_RATE: Final = 30.0
"""Frames per second of the viewer and of recordings."""
FRAMES_MAX: Final = 108_000
"""Frames of an hour; what lasts longer has fewer of them per second."""
FRICTION: Final = 0.5
"""Coefficient of friction where the file does not say it."""


@dataclass(frozen=True)
class Joints:
    """The whole body at the frames: base link and joints.

    Attributes:
        names: of the n_j joints.
        base_position: origin of the base link, world, (n, 3), m.
        base_quaternion: base link to world, (x, y, z, w), (n, 4).
        position: (n, n_j), rad.
    """

    names: tuple[str, ...]
    base_position: Array
    base_quaternion: Array
    position: Array


@dataclass(frozen=True)
class ShownGoal:
    """A goal and from when on it holds.

    Attributes:
        begin: s.
        pose: x, y, z of the CoM (m), yaw, pitch, roll (rad), (6,).
    """

    begin: float
    pose: Array


@dataclass(frozen=True)
class Clip:
    """A motion at equally spaced frames, both ends included. World frame, SI units.

    Attributes:
        name: what a person calls it.
        kind: plan, joints, simulation, mpc or scenario.
        robot: the planner's robot.
        samples: the motion at the frames, (n, …).
        terrain: the ground.
        goals: in the order of time.
        marks: what is worth a look, the worst first.
        verdict: one line on how good the motion is.
        passed: whether it is a success.
        joints: the whole body, if known.
        plan: the plan, if this is one.
        scenario: what was asked, or is to be; None if the file does not say it.
        trajectory: the joints as they are exported, if known.
        wrenches: what pulls at the base as it is known, from the first frame on.
    """

    name: str
    kind: str
    robot: Robot
    samples: Samples
    terrain: Terrain
    goals: tuple[ShownGoal, ...]
    marks: tuple[Mark, ...]
    verdict: str
    passed: bool
    joints: Joints | None = None
    plan: Plan | None = None
    scenario: Scenario | None = None
    trajectory: JointTrajectory | None = None
    wrenches: tuple[Wrench, ...] = ()

    @property
    def time(self) -> Array:
        """Time of each frame, (n,), s."""
        return self.samples.time

    @property
    def horizon(self) -> float:
        """Time of the last frame, s."""
        return float(self.samples.time[-1])

    def frame(self, time: float) -> int:
        """The frame nearest to a time (s)."""
        return int(np.clip(round(time * (len(self.time) - 1) / self.horizon), 0, len(self.time) - 1))

    @cached_property
    def foot_ground(self) -> Array:
        """Height of the ground under each foot, (n, 4), m; NaN where it is not known."""
        x, y, _ = np.moveaxis(self.samples.foot_position, -1, 0)
        return self.terrain.height(x, y)

    @cached_property
    def friction(self) -> Array:
        """μ under each foot, (n, 4)."""
        x, y, _ = np.moveaxis(self.samples.foot_position, -1, 0)
        return self.terrain.friction_at(x, y)

    @cached_property
    def wheel_angle(self) -> Array:
        """Angle by which each wheel has turned since the first frame, (n, 4), rad."""
        return wheel_angle(self.samples, [leg.wheel_radius for leg in self.robot.leg_list])

    def with_joints(self, joints: JointTrajectory) -> Clip:
        """The same clip with the whole body that executes it."""
        return replace(self, joints=_joints_at(joints, self.time), trajectory=joints)


def clip_of_plan(plan: Plan, name: str) -> Clip:
    """A plan, with the marks of its certificate. Raises `InputError` if numbers of it are none."""
    plan.require_numbers()
    scenario, certificate = plan.scenario, plan.certificate()
    begins = [0.0, *(later.at for later in scenario.goal.then)]
    poses = goal_poses(scenario, np.array(begins))
    if not plan.solved:
        verdict = "not solved"
    elif certificate.passed:
        verdict = "certified"
    else:
        verdict = "not certified: " + ", ".join(row.name for row in certificate.failures)
    return Clip(
        name=name,
        kind="plan",
        robot=plan.robot,
        samples=plan.sample(frame_times(plan.horizon)),
        terrain=scenario.terrain,
        goals=tuple(ShownGoal(begin, pose) for begin, pose in zip(begins, poses, strict=True)),
        marks=marks_of_plan(plan),
        verdict=verdict,
        passed=plan.solved and certificate.passed,
        plan=plan,
        scenario=scenario,
        wrenches=scenario.wrenches,
    )


def clip_of_joints(joints: JointTrajectory, name: str) -> Clip:
    """A joint trajectory: the plan it follows, and the whole body."""
    times, plan = frame_times(float(joints.time[-1])), joints.reference
    return Clip(
        name=name,
        kind="joints",
        robot=joints.robot,
        samples=plan.at(_nearest(joints.time, times)),
        terrain=joints.terrain or Terrain(float(np.min(plan.foot_position[..., 2])), FRICTION),
        goals=(_end(plan.com_position, plan.euler),),
        marks=marks_of_joints(joints),
        verdict="followed within its limits" if joints.report.passed else "not followed within its limits",
        passed=joints.report.passed,
        joints=_joints_at(joints, times),
        trajectory=joints,
        wrenches=joints.wrenches,
    )


def clip_of_log(log: SimulationLog, name: str) -> Clip:
    """A simulation: what the robot did. The feet are those of the whole body."""
    from rollgait.simulation.log_samples import euler_of, samples_of_log

    times = frame_times(float(log.time[-1]))
    index = _nearest(log.time, times)
    joints = Joints(
        log.joint_names, log.base_position[index], log.base_quaternion[index], log.joint_position[index]
    )
    report = log.report()
    return Clip(
        name=name,
        kind="simulation",
        robot=log.robot,
        samples=samples_of_log(log, index, times),
        terrain=log.terrain or Terrain(log.ground_height, FRICTION),
        goals=(_end(log.planned_com_position, euler_of(log.planned_base_quaternion)),),
        marks=marks_of_log(log),
        verdict=f"fell at {report.fallen_at:.2f} s" if report.fallen_at is not None else "did not fall",
        passed=not report.fallen,
        joints=joints,
    )


def _end(com_position: Array, euler: Array) -> ShownGoal:
    """Where the plan that was followed ends: the goal itself is not in the file."""
    return ShownGoal(0.0, np.concatenate([com_position[-1], euler[-1]]))


def frame_times(horizon: float) -> Array:
    """Times of the frames, both ends included, as near to `FRAME_RATE` as fits, (n ≤ FRAMES_MAX,), s."""
    return np.linspace(0.0, horizon, 1 + round(min(max(1.0, horizon * FRAME_RATE), FRAMES_MAX - 1)))


def _nearest(time: Array, wanted: Array) -> NDArray[np.intp]:
    """Index of the sample nearest to each wanted time."""
    after = np.clip(np.searchsorted(time, wanted), 1, len(time) - 1)
    earlier = wanted - time[after - 1] < time[after] - wanted
    return np.asarray(np.where(earlier, after - 1, after), dtype=np.intp)


def _joints_at(joints: JointTrajectory, times: Array) -> Joints:
    index = _nearest(joints.time, times)
    return Joints(
        joints.joint_names,
        joints.base_position[index],
        joints.base_quaternion[index],
        joints.joint_position[index],
    )
