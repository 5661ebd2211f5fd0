"""The whole robot in MuJoCo as a plant: a controller drives it control by control."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import InputError
from rollgait.plant.control import Control
from rollgait.plant.disturbances import Disturbances
from rollgait.plant.stance import standing_control
from rollgait.plant.state import RobotState
from rollgait.plant.unplanned import UnplannedContact
from rollgait.robot.loads import Wrench
from rollgait.robot.robot import LEG_NAMES, Robot
from rollgait.robot.urdf_model import BASE_V
from rollgait.robot.whole_body import WholeBody
from rollgait.simulation.controller import Gains, JointReference
from rollgait.simulation.drives import gains_of
from rollgait.simulation.joint_path import JointPath
from rollgait.simulation.measure import reader_at
from rollgait.simulation.physics import Load, Physics, Pose, Velocity
from rollgait.simulation.world import TIME_STEP
from rollgait.terrain.terrain import Terrain
from rollgait.tracking.follower import Follower, JointTarget

Array = NDArray[np.float64]

SMOOTHING: Final = 0.03
"""Width of the moving average that the joints' targets go through, s. Without it, wheels reach their limits
of torque where speeds jump; it delays the robot by half its width, so it is narrower than that of a plan."""

SETTLING: Final = 0.5
"""How long the robot stands before its time begins, s: feet sink in, and joints give way under load."""

_SETTLING_PERIOD: Final = 0.01

PRESSING: Final = 0.01
"""A foot touches the ground that carries this share of the robot's weight."""


class MujocoPlant:
    """Joint targets by inverse kinematics, joint PD with feed-forward, and 1 ms steps of physics.

    Args:
        body: the whole body.
        robot: the planner's robot of it: its weight and height set the gains.
        start: where it stands first, on all feet and at rest; the velocities are not used.
        disturbances: what is not as the controller takes it; pushes count time from the start.
        gains: of the drives; those that suit the robot if not given.
        smoothing: width of the moving average that the joints' targets go through, s; 0 for none.
        terrain: the ground; a plane under the feet of the start if not given.
        wrenches: what pulls at the base as the controller knows it, from the start on.

    Attributes:
        name: `mujoco`.
        joint_names: of the n_j joints.
        follower: the inverse kinematics; it says whether it failed.
        contact_force: of the ground on each foot, mean over the last control, (4, 3), N.
        torque: of the drives in the last millisecond, (n_j,), N m.
        torque_share: largest |torque| over its limit in the last control, any joint.
        told: what the joints were told in the last control.

    Raises:
        InputError: the robot cannot stand so, or a number is not one.
        FileError: MuJoCo does not understand the URDF.
    """

    name = "mujoco"

    def __init__(
        self,
        body: WholeBody,
        robot: Robot,
        start: RobotState,
        *,
        disturbances: Disturbances | None = None,
        gains: Gains | None = None,
        smoothing: float = SMOOTHING,
        terrain: Terrain | None = None,
        wrenches: Sequence[Wrench] = (),
    ) -> None:
        if not start.is_finite():
            raise InputError("start", "nan", "must be a state of finite numbers")
        if not (np.isfinite(smoothing) and smoothing >= 0.0):
            raise InputError("smoothing", smoothing, "must be a time in seconds, 0 or more")
        self.follower = Follower(body)
        self.follower.reset(start)
        self.joint_names = self.follower.joint_names
        q = self.follower.state.q
        posture = q[BASE_V + 1 :]
        rest = np.zeros((1, len(posture)))
        self._path = JointPath(smoothing, posture, self._standing_torque(robot, start))
        self._physics = Physics(
            body,
            self.joint_names,
            gains or gains_of(robot, body, self.joint_names),
            disturbances or Disturbances(),
            Pose(q[:3], q[3:7], posture),
            JointReference(posture[None], rest, rest),
            ground=float(np.mean(start.foot_position[:, 2])),
            begins=SETTLING,
            terrain=terrain,
            wrenches=wrenches,
        )
        self._start_time = start.time
        physics = self._physics
        self._reader = reader_at(physics.world, physics.data, self.follower.model, start)
        self._state = self._reader.read(self._physics.data, start.time)
        self._pose, self._velocity = self._physics.pose, self._physics.velocity
        self.told = JointTarget(posture, rest[0], rest[0])
        self._fallen = self._unstable = False
        self.contact_force: Array = np.zeros((len(LEG_NAMES), 3))
        self.torque: Array = np.zeros(len(self.joint_names))
        self.torque_share = 0.0
        self._pressing = PRESSING * robot.weight
        self._settle(robot, start)

    def _standing_torque(self, robot: Robot, start: RobotState) -> Array:
        return self.follower.follow(standing_control(robot, start, _SETTLING_PERIOD)).torque

    def _settle(self, robot: Robot, start: RobotState) -> None:
        """Lets it stand until time begins."""
        count = round(SETTLING / _SETTLING_PERIOD)
        for k in range(count):
            before = start.at(start.time - (count - k) * _SETTLING_PERIOD)
            self.step(standing_control(robot, before, _SETTLING_PERIOD))

    # -- the plant --

    @property
    def state(self) -> RobotState:
        """The true state now, by the radius of the wheels as it is known; with the payload."""
        return self._state

    @property
    def fallen(self) -> bool:
        """Whether the base has tilted by 45° or sunk to half its height; or the physics have become unstable,
        from when on nothing moves."""
        return self._fallen

    @property
    def time(self) -> float:
        """s; begins with that of the start."""
        return self._start_time + self._physics.time

    @property
    def trouble(self) -> str:
        """What is wrong with the robot now; empty if nothing is."""
        return "the joints cannot follow the control: they hold" if self.follower.failed else ""

    @property
    def pose(self) -> Pose:
        """Where the whole body is now."""
        return self._pose

    @property
    def velocity(self) -> Velocity:
        """How the whole body moves now."""
        return self._velocity

    @property
    def delay(self) -> float:
        """By how much the smoothing lets the joints lag behind the controls, s."""
        return self._path.delay

    def step(self, control: Control) -> None:
        """Lets one control pass. One that cannot be followed leaves the joints where they were told to be.

        Raises:
            InputError: the control is shorter than a step of the physics.
        """
        count = round(control.period / TIME_STEP) if np.isfinite(control.period) else 0
        if count < 1:
            raise InputError("control.period", control.period, f"must be at least {TIME_STEP} s")
        self.told = self.follower.follow(control)
        self._path.aim(self.told, count)
        reference = self._path.take(count)
        physics = self._physics
        if self._unstable:
            physics.steps += count
            return
        physics.drives.load(reference)
        for row in range(count):
            physics.step(row)
        self._note(physics.take_load())

    @property
    def touching(self) -> NDArray[np.bool_]:
        """Which feet pressed on the ground in the last control, (4,)."""
        return np.asarray(self.contact_force[:, 2] > self._pressing)

    @property
    def unplanned(self) -> Mapping[str, UnplannedContact]:
        """What else than a foot has touched the ground, by its link; only a terrain can be touched so."""
        return self._physics.unplanned

    def push(self, force: Array, duration: float) -> None:
        """From now on a force on the base, (3,), N, world, for a time, s. Pushes add up.

        Raises:
            InputError: a number is not finite, or the duration not positive.
        """
        vector = np.asarray(force, dtype=float)
        if vector.shape != (3,) or not np.isfinite(vector).all():
            raise InputError("force", force, "must be three finite numbers, N")
        if not (np.isfinite(duration) and duration > 0.0):
            raise InputError("duration", duration, "must be a positive number of seconds")
        x, y, z = vector.tolist()
        self._physics.push((x, y, z), duration)

    # -- inside --

    def _note(self, load: Load) -> None:
        """Reads everything, unless the physics have become unstable: then all stays as it was read last."""
        physics = self._physics
        state = self._reader.read(physics.data, self.time)
        torque = physics.data.actuator_force.copy()
        if not (state.is_finite() and np.isfinite(torque).all() and np.isfinite(load.force).all()):
            self._unstable = self._fallen = True
            return
        self._fallen |= physics.has_fallen
        self._state, self._pose, self._velocity = state, physics.pose, physics.velocity
        self.contact_force, self.torque = load.force, torque
        self.torque_share = float(np.max(load.torque_peak / physics.world.effort_max))
