"""The whole robot in MuJoCo, millisecond by millisecond, whoever drives it: a plan or a controller."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from rollgait.plant.disturbances import Disturbances
from rollgait.plant.unplanned import UnplannedContact
from rollgait.robot.loads import Wrench
from rollgait.robot.robot import LEG_NAMES
from rollgait.robot.whole_body import WholeBody
from rollgait.simulation.controller import Controller, Gains, JointReference
from rollgait.simulation.measure import contacts_of, ground_under, has_fallen
from rollgait.simulation.pulls import Pulls
from rollgait.simulation.world import TIME_STEP, build_world
from rollgait.terrain.terrain import Terrain

Array = NDArray[np.float64]


class Pose(NamedTuple):
    """Where the whole body is.

    Attributes:
        base_position: origin of the base link, (3,), m.
        base_quaternion: base link to world, (x, y, z, w), (4,).
        joint_position: (n_j,), rad.
    """

    base_position: Array
    base_quaternion: Array
    joint_position: Array


class Velocity(NamedTuple):
    """How the whole body moves.

    Attributes:
        base_linear: of the origin of the base link, world, (3,), m/s.
        base_angular: of the base link, in its own axes, (3,), rad/s.
        joint_velocity: (n_j,), rad/s.
    """

    base_linear: Array
    base_angular: Array
    joint_velocity: Array


class Load(NamedTuple):
    """What the robot had to bear over some steps.

    Attributes:
        force: of the ground on each foot, mean, (4, 3), N.
        torque_peak: largest |torque| of each drive, (n_j,), N m.
    """

    force: Array
    torque_peak: Array


class Physics:
    """The world, its drives and what disturbs it. Knows neither plan nor controller.

    Args:
        body: the whole body.
        joint_names: the driven joints.
        gains: of the drives.
        disturbances: what is not as whoever drives it takes it; pushes count time from 0.
        pose: where it is first, on its feet and at rest; it is raised by what its wheels are larger than
            known.
        reference: what the joints shall do, step by step.
        ground: z of the ground where that is a plane, m.
        terrain: the ground, in place of the plane.
        begins: how long before time 0 the first step is, s.
        wrenches: what pulls at the base as planned, from time 0 on.

    Attributes:
        world: where things are in MuJoCo's model.
        data: MuJoCo's data.
        drives: joint PD with feed-forward.
        steps: number of the next step; step 0 begins at time 0.
        unplanned: what else than a foot has touched the ground, by its link.

    Raises:
        InputError, FileError: as `build_world`.
    """

    def __init__(
        self,
        body: WholeBody,
        joint_names: tuple[str, ...],
        gains: Gains,
        disturbances: Disturbances,
        pose: Pose,
        reference: JointReference,
        *,
        ground: float,
        begins: float,
        terrain: Terrain | None = None,
        wrenches: Sequence[Wrench] = (),
    ) -> None:
        self._pulls = Pulls(body, wrenches)
        self.world = build_world(
            body,
            joint_names,
            disturbances,
            damping=gains.damping,
            ground_height=ground,
            terrain=terrain,
            about=pose.base_position[:2],
        )
        self.data: Any = mujoco.MjData(self.world.model)
        self.drives = Controller(gains, reference, round(disturbances.latency / TIME_STEP))
        self.steps = -round(begins / TIME_STEP)
        self.unplanned: dict[str, UnplannedContact] = {}
        self._plane, self._terrain = ground, terrain
        self._pushes = [
            (round(push.start / TIME_STEP), round((push.start + push.duration) / TIME_STEP), push.vector)
            for push in disturbances.pushes
        ]
        self._forget_load()
        self._place(pose)

    def _place(self, pose: Pose) -> None:
        world, data = self.world, self.data
        world.put(data, *pose)
        data.qpos[2] += world.lift
        mujoco.mj_forward(world.model, data)
        self._height = float(data.qpos[2]) - self.ground

    @property
    def time(self) -> float:
        """s."""
        return self.steps * TIME_STEP

    @property
    def pose(self) -> Pose:
        """Where the whole body is now."""
        data = self.data
        return Pose(data.qpos[:3].copy(), np.roll(data.qpos[3:7], -1), data.qpos[self.world.position])

    @property
    def velocity(self) -> Velocity:
        """How the whole body moves now."""
        data = self.data
        return Velocity(data.qvel[:3].copy(), data.qvel[3:6].copy(), data.qvel[self.world.velocity])

    @property
    def ground(self) -> float:
        """z of the ground under the robot now, m; NaN where it is not known."""
        return ground_under(self.world, self.data, self._terrain, self._plane)

    @property
    def has_fallen(self) -> bool:
        """Whether the robot lies, now; also if the physics have become unstable."""
        return has_fallen(self.world, self.data, self.ground, self._height)

    def push(self, force: tuple[float, float, float], duration: float) -> None:
        """From now on a force on the base, N, world, for a time, s. Pushes add up."""
        self._pushes.append((self.steps, self.steps + max(1, round(duration / TIME_STEP)), force))

    def step(self, row: int) -> None:
        """One step of `TIME_STEP` in which the joints follow a row of the reference."""
        self.begin_step(row)
        self.end_step()

    def begin_step(self, row: int) -> None:
        """The first half of `step`: all of the data that follows from positions and velocities is of now."""
        data = self.data
        if self._pushes or self._pulls:
            self._apply_pushes()
        data.ctrl[:] = self.drives.control(row, data.qpos[self.world.position])
        mujoco.mj_step1(self.world.model, data)

    def end_step(self) -> None:
        """The second half of `step`: forces are known only here, where positions have moved on."""
        data = self.data
        mujoco.mj_step2(self.world.model, data)
        contacts = contacts_of(self.world, data)
        self._force += contacts.force
        for body, force in contacts.others:
            self._note_unplanned(self.world.model.body(body).name, force)
        np.maximum(self._peak, np.abs(data.actuator_force, out=self._magnitude), out=self._peak)
        self._borne += 1
        self.steps += 1

    def take_load(self) -> Load:
        """What was borne since this was asked last; there must have been a step."""
        load = Load(self._force / self._borne, self._peak)
        self._forget_load()
        return load

    def _forget_load(self) -> None:
        self._force: Array = np.zeros((len(LEG_NAMES), 3))
        self._peak: Array = np.zeros(len(self.world.joint_names))
        self._magnitude: Array = np.zeros_like(self._peak)
        self._borne = 0

    def _note_unplanned(self, link: str, force: float) -> None:
        known = self.unplanned.get(link)
        first, largest = (self.time, 0.0) if known is None else (known.time, known.force)
        self.unplanned[link] = UnplannedContact(link=link, time=first, force=max(largest, force))

    def _apply_pushes(self) -> None:
        now = self.steps
        acting = [vector for begin, end, vector in self._pushes if begin <= now < end]
        applied, base = self.data.xfrc_applied, self.world.base
        applied[base] = self._pulls.at(self.time, self.data, base)
        applied[base, :3] += np.sum(acting, axis=0) if acting else 0.0
        self._pushes = [push for push in self._pushes if now < push[1]]
