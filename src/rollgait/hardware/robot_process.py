"""The simulated robot in a process of its own, in real time, reached over DDS alone: as hardware would be."""

from __future__ import annotations

import multiprocessing
import os
import signal
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Final

from rollgait.errors import RollgaitError
from rollgait.pace import Pace
from rollgait.signals import deaf_to_ctrl_c
from rollgait.simulation.world import TIME_STEP
from rollgait.terrain import Terrain

BUILD_WITHIN: Final = 120.0
"""A robot that is not there by then will not come, s."""
END_WITHIN: Final = 3.0
"""It ends by itself in this time, s; otherwise it is ended."""
LOOK_EVERY: Final = 50
"""Milliseconds between two looks whether somebody wants it to end."""


@dataclass(frozen=True)
class RobotSetup:
    """Which robot, and how it is reached.

    Attributes:
        robot: name or file.
        domain: of DDS; None for that of ROS.
        seed: of its sensors' noise.
        tells_truth: whether it says the truth on `/truth` as well.
        slow: seconds on the wall in one of its own: more than 1 where a machine cannot keep up.
        stands: whether it stands in its stance at first, in place of lying.
        place: x, y of the CoM and yaw at first, m and rad.
        terrain: the ground; level if none.
    """

    robot: str
    domain: int | None = None
    seed: int = 0
    tells_truth: bool = False
    slow: float = 1.0
    stands: bool = False
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)
    terrain: Terrain | None = None


class RobotProcess:
    """A simulated robot in another process.

    Args:
        setup: which.

    Raises:
        RollgaitError: as the building of the robot raised it, or there is none in time.
    """

    def __init__(self, setup: RobotSetup) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        self._process = context.Process(target=_run, args=(other, setup), name="robot", daemon=True)
        with deaf_to_ctrl_c():
            self._process.start()
        other.close()
        try:
            answer = (
                self._pipe.recv() if self._pipe.poll(BUILD_WITHIN) else RollgaitError("there is no robot")
            )
        except EOFError:
            answer = RollgaitError("the simulated robot has ended")
        if isinstance(answer, RollgaitError):
            self.close()
            raise answer

    @property
    def is_alive(self) -> bool:
        """Whether it runs."""
        return self._process.is_alive()

    def kill(self) -> None:
        """Ends it at once, as if its power had failed."""
        self._process.kill()
        self._process.join()

    def close(self) -> None:
        """Ends it."""
        self._pipe.close()
        self._process.join(END_WITHIN)
        if self._process.is_alive():
            self.kill()


def _run(pipe: Connection, setup: RobotSetup) -> None:
    """The other process, until the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the bridge, which lays the robot down
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    from rollgait.hardware.postures import rise_of
    from rollgait.hardware.simulated import SimulatedRobot
    from rollgait.hardware.transports.dds import DdsTransport
    from rollgait.robot.library import find_robot
    from rollgait.robot.urdf_model import load_model
    from rollgait.robot.whole_body import find_whole_body

    answer: RollgaitError | None
    try:
        transport = DdsTransport(setup.domain)
        body = find_robot(setup.robot)
        postures = rise_of(load_model(find_whole_body(body)), body).postures
        robot = SimulatedRobot(
            body,
            transport,
            seed=setup.seed,
            tells_truth=setup.tells_truth,
            posture=postures[-1 if setup.stands else 0],
            place=setup.place,
            terrain=setup.terrain,
        )
        answer = None
    except RollgaitError as error:
        answer = error
    try:
        pipe.send(answer)
    except OSError:  # nobody is there any more who started it
        return
    if answer is not None:
        return
    pace, count = Pace(setup.slow * TIME_STEP), 0
    while True:
        robot.tick()
        count += 1
        if count % LOOK_EVERY == 0 and pipe.poll():
            break  # nothing is ever sent: the other end is closed
        pace.wait()
    transport.close()
