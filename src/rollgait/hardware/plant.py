"""A robot behind a transport as a plant: sensors in, joint commands out, and time passes by waiting."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import InputError
from rollgait.hardware.estimation import BodyEstimator
from rollgait.hardware.last_stage import LastStage, StageLimits, bounds_of
from rollgait.hardware.measured import Sensors
from rollgait.hardware.topics import JOINT_COMMANDS, joint_command
from rollgait.hardware.transports.transport import Transport
from rollgait.plant.control import Control
from rollgait.plant.fall import is_fallen
from rollgait.plant.stance import standing_state
from rollgait.plant.state import RobotState
from rollgait.robot.robot import Robot
from rollgait.robot.urdf_model import BASE_V
from rollgait.robot.whole_body import find_whole_body
from rollgait.simulation.physics import Pose
from rollgait.tracking.follower import Follower, JointTarget

Array = NDArray[np.float64]

FRESH: Final = 0.03
"""Sensors that have said nothing for so long say nothing of now, s: three of their usual periods."""
NAME: Final = "hardware"
"""Of the plant."""


class HardwarePlant:
    """What a controller drives when the robot is elsewhere.

    Args:
        robot: the planner's robot; it needs a whole body.
        transport: the way to its sensors and drives.
        clock: seconds that only go on; `transport.receive` lets them pass.
        period: of the controller, s.
        limits: of the last stage.

    Attributes:
        name: `hardware`.
        follower: the inverse kinematics.
        joint_names: of the n_j joints.
        sensors: what they said last.
        estimator: what is made of it.
        stage: the last stage.
        contact_force: on the feet as estimated, (4, 3), N.
        touching: which feet press as estimated, (4,).
        stalls: periods that were missed because a step took too long.
        stall: what of that was before the current one, s.

    Raises:
        InputError: there is no whole body of the robot.
        MissingExtraError: an extra is not installed.
    """

    name = NAME

    def __init__(
        self,
        robot: Robot,
        transport: Transport,
        clock: Callable[[], float],
        period: float,
        limits: StageLimits | None = None,
    ) -> None:
        self._robot, self._transport, self._clock, self._period = robot, transport, clock, period
        self.follower = Follower(find_whole_body(robot))
        model = self.follower.model
        self.joint_names = model.joint_names
        self._wheels = [leg.wheel - BASE_V for leg in model.legs if leg.wheel is not None]
        self._turned: Array = np.zeros(len(self.joint_names))
        self.sensors = Sensors(transport, self.joint_names, clock, period, model.urdf.root_link)
        self.estimator = BodyEstimator(model, robot, period)
        self._bounds = bounds_of(model, limits)
        self.stage = LastStage(self.joint_names, self._bounds, period)
        self._state = standing_state(robot)
        self._begin = self._due = clock()
        self._periods = 0
        self.stalls = 0
        self.stall = 0.0
        self.torque_share = 0.0

    # -- the plant --------------------------------------------------------------------------------------

    @property
    def state(self) -> RobotState:
        """The state as estimated. Its time is that of the step which it was fresh in."""
        return self._state

    @property
    def time(self) -> float:
        """s: periods that it has waited for. Those that were missed do not count."""
        return self._periods * self._period

    @property
    def fallen(self) -> bool:
        """Whether the base, as estimated, has tilted by 45° or sunk to half its height over its feet."""
        state = self._state
        up = float(np.cos(state.euler[1]) * np.cos(state.euler[2]))
        height = float(state.com_position[2] - state.foot_position[:, 2].mean())
        return is_fallen(up, height, self._robot.height)

    @property
    def is_fresh(self) -> bool:
        """Whether the sensors said something of this period."""
        return self._state.time >= self.time - 0.5 * self._period and self.sensors.age <= FRESH

    @property
    def is_upright(self) -> bool:
        """Whether the base has not tilted as a fallen one has."""
        return not is_fallen(float(np.cos(self._state.euler[1]) * np.cos(self._state.euler[2])), 1.0, 1.0)

    @property
    def contact_force(self) -> Array:
        """Of the ground on the feet as estimated, (4, 3), N."""
        return self.estimator.contact_force

    @property
    def touching(self) -> NDArray[np.bool_]:
        """Which feet press on the ground as estimated, (4,)."""
        return self.estimator.touching

    @property
    def trouble(self) -> str:
        """What is wrong with the robot now; empty if nothing is."""
        if self.follower.failed:
            return "the joints cannot follow the control: they hold"
        return f"the last stage cuts the joints' targets: {self.stage.cut}" if self.stage.cut else ""

    @property
    def pose(self) -> Pose | None:
        """Where the whole body is, as measured; None until it is known."""
        body = self.estimator.body
        return None if body is None else Pose(body.p_base, body.q[3:7], body.q[7:])

    def push(self, force: Array, duration: float) -> None:
        """Raises `InputError`: nobody pushes hardware by software."""
        raise InputError("push", force.tolist(), "is not possible: the robot is behind a transport")

    def step(self, control: Control) -> None:
        """Tells the joints what a control asks for, and waits for the next period."""
        target = self.follower.follow(control)
        self.tell(JointTarget(target.position + self._turned, target.velocity, target.torque))
        self.wait()

    # -- joints -----------------------------------------------------------------------------------------

    def take_hold(self, position: Array) -> None:
        """From now on the joints are told something, beginning where they are, (n_j,), rad."""
        self.stage.begin(position, self._clock() - self._period)

    def begin_at(self, state: RobotState) -> Array:
        """The inverse kinematics begins at a state, wheels turned as they are told now.

        Returns:
            The joints that it begins with, (n_j,), rad.
        """
        self.follower.reset(state)
        joints = np.array(self.follower.state.q[BASE_V + 1 :])
        self._turned[self._wheels] = (self.stage.target.position - joints)[self._wheels]
        return np.asarray(joints + self._turned)

    def tell(self, target: JointTarget) -> None:
        """Sends a target to the drives, through the last stage."""
        joints = self.sensors.joints
        known = joints is not None and self._clock() - joints.time <= FRESH
        measured = joints.position if joints is not None and known else None
        self._send(self.stage.let_through(target, measured, self._clock()))

    def hold(self) -> None:
        """Sends the drives where they were told to be, at rest."""
        self._send(self.stage.hold(self._clock()))

    def _send(self, told: JointTarget) -> None:
        now = round(1e9 * self._clock())
        self._transport.publish(JOINT_COMMANDS, joint_command(now, self.joint_names, told))

    # -- time -------------------------------------------------------------------------------------------

    def wait(self) -> None:
        """Lets what is left of the period pass, then looks at what the sensors said."""
        self._due += self._period
        self._periods += 1
        while (left := self._due - self._clock()) > 1e-9:
            self._transport.receive(left)
        self._transport.receive(0.0)
        missed = int((self._clock() - self._due) / self._period)
        self.stall = missed * self._period
        if missed > 0:  # what was missed is not made good: motions take longer, they do not leap
            self.stalls += missed
            self._due += missed * self._period
        self._look()

    def resume(self) -> None:
        """What was due is forgotten: something took its time while the joints were told nothing."""
        self._due, self.stall = self._clock(), 0.0
        self._transport.receive(0.0)
        self._look()

    def _look(self) -> None:
        sensors = self.sensors
        joints, imu, odometry = sensors.joints, sensors.imu, sensors.odometry
        if joints is None or imu is None or odometry is None or sensors.age > FRESH:
            return
        self._state = self.estimator.estimate(self.time, joints, imu, odometry)
        self.torque_share = float(np.max(np.abs(joints.effort) / self._bounds.torque))


class Fresh:
    """An estimator that says nothing where the plant has nothing new."""

    def __init__(self) -> None:
        self._time = -np.inf

    def __call__(self, true: RobotState, expected: RobotState | None) -> RobotState | None:
        if true.time <= self._time:
            return None
        self._time = true.time
        return true
