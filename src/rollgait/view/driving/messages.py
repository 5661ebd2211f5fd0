"""What goes between the page and the control loop: a request 30 times a second, and its answer."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.config import validate
from rollgait.errors import InputError
from rollgait.mpc.command import VelocityCommand
from rollgait.plant.state import RobotState

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
NO_FORCE: Final[Vector] = (0.0, 0.0, 0.0)
AHEAD: Final = "what is ahead"
"""Stands for the manoeuvre that leads over whatever is ahead."""
PUSHES_MAX: Final = 5
"""Pushes at a time: who clicks faster than they pass is not heard."""


@dataclass(frozen=True)
class PushRequest:
    """A force on the base, world, N, for a time, s."""

    force: Vector
    duration: float


@dataclass(frozen=True)
class Request:
    """What the page wants.

    Attributes:
        command: holds until the next request.
        pull: force on the base that acts until the next request, world, N.
        pushes: that begin now.
        reset: begin anew after a fall or a fault.
        paused: time stands still until a request that says otherwise.
        manoeuvre: name of one that is to begin, or `AHEAD`.
        distance: how far ahead that leads then, m.
        halt: end the manoeuvre that is under way.
        record: file into which the run is to be recorded; what was recorded is written when this is "" again.
        stops: how often somebody has pressed stop by now.
    """

    command: VelocityCommand
    pull: Vector = NO_FORCE
    pushes: tuple[PushRequest, ...] = ()
    reset: bool = False
    paused: bool = False
    record: str = ""
    manoeuvre: str = ""
    distance: float = 0.0
    halt: bool = False
    stops: int = 0

    def check(self) -> None:
        """Raises `InputError` for numbers that are none, and for a gait that is not known."""
        validate(VelocityCommand, dict(self.command), "command").check()
        for name, force in (("pull", self.pull), *(("push", push.force) for push in self.pushes)):
            if not all(map(math.isfinite, force)):
                raise InputError(name, force, "must be finite forces")
        for push in self.pushes:
            if not 0.0 <= push.duration < math.inf:
                raise InputError("push.duration", push.duration, "must be finite and not negative")


@dataclass(frozen=True, eq=False)
class Body:
    """The whole body: base link in the world, (3,) m and (x, y, z, w), and the joints, (n_j,), rad."""

    base_position: Array
    base_quaternion: Array
    joint_position: Array


@dataclass(frozen=True, eq=False)
class Snapshot:
    """How it goes.

    Attributes:
        state: of the robot.
        body: where it is known.
        joint_names: of the body's joints.
        wheel_angle: by which the wheels have turned, (4,), rad.
        force: on the feet, (4, 3), N.
        contact: which feet shall stand, (4,).
        pushed: force on the base now, (3,), N.
        com_path: predicted r, (N + 1, 3), m.
        foot_path: predicted p, (N + 1, 4, 3), m.
        foot_contact: whether a foot is predicted to stand for some of an interval, (N, 4).
        command: that holds.
        wanted: forward and lateral velocity and turn rate of the reference, m/s and rad/s.
        actual: the same of the robot, in the base-yaw frame.
        gait: that decides about the next lift-off.
        mode: of the controller, or `fallen`.
        solve: median and 99th percentile of the controller's time over the last second, s.
        rate: periods per second of wall time, Hz.
        factor: simulated over wall time.
        events: of the controller, (s, text), newest last.
        recorded: how long the recording is, s; 0 while there is none.
        written: the last file that was recorded, "" if there is none yet.
        manoeuvre: which one is under way, and how far it is; "" if none is.
    """

    state: RobotState
    body: Body | None
    joint_names: tuple[str, ...]
    wheel_angle: Array
    force: Array
    contact: NDArray[np.bool_]
    pushed: Array
    com_path: Array
    foot_path: Array
    foot_contact: NDArray[np.bool_]
    command: VelocityCommand
    wanted: Vector
    actual: Vector
    gait: str
    mode: str
    solve: tuple[float, float]
    rate: float
    factor: float
    events: tuple[tuple[float, str], ...]
    recorded: float = 0.0
    written: str = ""
    manoeuvre: str = ""
