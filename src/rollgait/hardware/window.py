"""A window onto a simulated run: others see live what a bridge would say of a robot, and may drive it.

It is for spectators: nothing has to be enabled, nothing is estimated, and no last stage cuts anything, as no
robot can be harmed. The way to hardware is `rollgait.hardware.bridge`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rollgait.angles import angular_velocity
from rollgait.hardware.operator import Operator
from rollgait.hardware.reports import ERROR, OK, WARN, Health, Reports
from rollgait.hardware.topics import JOINT_COMMANDS, encoded, joint_command
from rollgait.hardware.transports.transport import Transport
from rollgait.mpc.loop import Ask, ClosedLoop
from rollgait.mpc.prediction import Prediction
from rollgait.pace import Pace
from rollgait.plant.state import RobotState
from rollgait.ros.messages import Pose as FramePose
from rollgait.ros.messages import joint_state, odometry
from rollgait.ros.topics import BASE_LINK, JOINT_STATES, ODOM, ODOMETRY, Topic
from rollgait.simulation.physics import Pose, Velocity

Array = NDArray[np.float64]

BEGIN: Final = 1.0
"""Stamp of the beginning of a run, s: a stamp of 0 means "the latest" to tf."""
NO_JOINTS: Final[Array] = np.zeros(0)


@dataclass(frozen=True)
class SeenRobot:
    """The robot of a loop as it is. One without joints is seen as a base link at its CoM.

    Attributes:
        loop: the closed loop.
    """

    loop: ClosedLoop

    @property
    def state(self) -> RobotState:
        """The true state."""
        return self.loop.plant.state

    @property
    def pose(self) -> Pose:
        """Where the whole body is."""
        own = getattr(self.loop.plant, "pose", None)
        if own is not None:
            return Pose(*own)
        state = self.state
        return Pose(state.com_position, Rotation.from_euler("ZYX", state.euler).as_quat(), NO_JOINTS)

    @property
    def velocity(self) -> Velocity:
        """How it moves; joints whose velocities nobody knows have none."""
        own: Velocity | None = getattr(self.loop.plant, "velocity", None)
        if own is not None:
            return own
        state = self.state
        omega = angular_velocity(state.euler, state.euler_rate)
        turn = Rotation.from_quat(self.pose.base_quaternion)
        return Velocity(state.com_velocity, turn.inv().apply(omega), NO_JOINTS)

    @property
    def contact_force(self) -> Array:
        """On the feet; as planned where nothing is measured, (4, 3), N."""
        measured = getattr(self.loop.plant, "contact_force", None)
        if measured is not None:
            return np.asarray(measured)
        control = self.loop.control
        return np.zeros((4, 3)) if control is None else control.force * control.contact[:, None]


class Window:
    """Says of a closed loop what a bridge says, and of its robot what the robot would, period by period.

    Args:
        transport: an `Elsewhere`, so that the loop does not wait for it.
        name: of the run, for `/diagnostics`.
        takes: topics of commands that are heard; `/enable` and maps mean nothing here.
        clock: of who commands, seconds that only go on.

    Attributes:
        operator: who commands from outside; None if nobody is heard.
    """

    def __init__(
        self,
        transport: Transport,
        name: str,
        takes: Collection[Topic] = (),
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        self._transport, self._name = transport, name
        self._stamp, self._last = BEGIN, 0.0
        self._reports = Reports(transport, lambda: self._stamp)
        self._loop: ClosedLoop | None = None
        self._factor = 1.0
        self._heard: list[str] = []
        self.operator: Operator | None = None
        if takes:
            self.operator = Operator(transport, clock, self._heard.append, takes=takes)

    def after(self, loop: ClosedLoop, factor: float = 1.0) -> None:
        """A period of a loop has passed. Time that goes back, in a loop that begins anew, goes on here.

        Args:
            loop: the closed loop.
            factor: simulated over wall time, for `/diagnostics`.
        """
        passed = loop.time - self._last
        self._stamp += passed if passed > 0.0 else loop.mpc.settings.period
        self._loop, self._last, self._factor = loop, loop.time, factor
        self._say_state(SeenRobot(loop), round(1e9 * self._stamp))
        self._reports.after(self)
        self.listen()

    def listen(self) -> None:
        """Hears what is asked for from outside."""
        self._transport.receive(0.0)
        if self._loop is not None:
            for text in self._heard:
                self._loop.mpc.note(text)
            self._heard.clear()

    def _say_state(self, robot: SeenRobot, stamp: int) -> None:
        """What the robot's own process says, and what its joints are told; without noise, at once."""
        pose, velocity, plant = robot.pose, robot.velocity, robot.loop.plant
        publish = self._transport.publish
        names: tuple[str, ...] = getattr(plant, "joint_names", ())
        if names:
            torque = getattr(plant, "torque", None)
            state = joint_state(stamp, names, pose.joint_position, velocity.joint_velocity, torque)
            publish(JOINT_STATES, encoded(JOINT_STATES, state))
        if (told := getattr(plant, "told", None)) is not None:
            publish(JOINT_COMMANDS, joint_command(stamp, names, told))
        frame = FramePose(ODOM, BASE_LINK, pose.base_position, pose.base_quaternion)
        linear = Rotation.from_quat(pose.base_quaternion).inv().apply(velocity.base_linear)
        publish(ODOMETRY, encoded(ODOMETRY, odometry(stamp, frame, linear, velocity.base_angular)))

    # -- what is reported on ----------------------------------------------------------------------------

    @property
    def _shown(self) -> ClosedLoop:
        if self._loop is None:
            raise RuntimeError("nothing has been shown yet")
        return self._loop

    @property
    def plant(self) -> SeenRobot:
        """The robot."""
        return SeenRobot(self._shown)

    @property
    def prediction(self) -> Prediction | None:
        """Of the controller."""
        return self._shown.prediction

    def health(self) -> Health:
        """Mode, gait, pace, and what happened last."""
        loop = self._shown
        mpc, prediction = loop.mpc, loop.prediction
        mode = "fallen" if loop.plant.fallen else "" if prediction is None else prediction.status.mode
        level = ERROR if mode in ("fallen", "standing") else WARN if mode == "coasting" else OK
        values: dict[str, Any] = {
            "phase": mode,
            "plant": loop.plant.name,
            "gait": mpc.clock.gait.name,
            "time, s": f"{loop.time:.2f}",
            "simulated over wall time": f"{self._factor:.2f}",
            "messages dropped": getattr(self._transport, "dropped", 0),
        }
        if prediction is not None:
            values["step, ms"] = f"{1e3 * prediction.status.seconds:.2f}"
        if self.operator is not None:
            values["operator"] = self.operator.presence
        latest = [event.text for event in mpc.events][-1:]
        return Health(level, self._name, latest[0] if latest else mode, mpc.robot.name, values)


class Showing:
    """A run that goes by itself, shown period by period, no faster than the clock on the wall goes.

    Args:
        window: onto it.
        loop: that is run.

    Attributes:
        ask: what is asked for from outside, in the gait with which the loop began; None if nobody is heard.
    """

    def __init__(self, window: Window, loop: ClosedLoop) -> None:
        self._window, self._loop = window, loop
        self._pace: Pace | None = None
        operator, gait = window.operator, loop.mpc.clock.gait.name
        self.ask: Ask | None = None if operator is None else lambda: operator.command(gait)

    def __call__(self) -> None:
        """A step has been made."""
        if self._pace is None:
            self._pace = Pace(self._loop.mpc.settings.period)
        self._window.after(self._loop, self._pace.factor)
        self._pace.wait()
