"""The control loop in a process of its own: drawing, serving and garbage never take its time."""

from __future__ import annotations

import contextlib
import gc
import itertools
import logging
import multiprocessing
import os
import signal
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any, Final

from rollgait.errors import RollgaitError
from rollgait.mpc.plans.manoeuvres import Manoeuvre
from rollgait.signals import deaf_to_ctrl_c
from rollgait.terrain import Terrain
from rollgait.view.driving.messages import Request, Snapshot
from rollgait.view.driving.session import Session

if TYPE_CHECKING:
    from rollgait.hardware.transports.elsewhere import Line
    from rollgait.hardware.window import Window

ANSWER_WITHIN: Final = 60.0
"""A loop that does not answer for so long hangs, s: building it anew takes a second or two, on a busy machine
ten times that. One whose process has ended is known at once."""
BUILD_WITHIN: Final = 600.0
"""The same for its first answer: kernels may have to be compiled, s."""
END_WITHIN: Final = 2.0
"""It ends by itself in this time, s; otherwise it is ended."""

COLLECT_EVERY: Final = 50
"""Periods between two collections of young garbage: a drive has no end, so that none at all is no choice."""


class LoopEndedError(RollgaitError):
    """The control loop has ended though nobody asked it to."""

    exit_status = 1


@dataclass(frozen=True)
class Setup:
    """What is driven: robot (name or file), plant, gait, ground (or level), manoeuvres, who else looks."""

    robot: str
    plant: str
    gait: str
    terrain: Terrain | None = None
    manoeuvres: tuple[Manoeuvre, ...] = ()
    others: Line | None = None


class LoopProcess:
    """A session in another process. One exchange at a time.

    Args:
        setup: what is driven.

    Raises:
        RollgaitError: as the building of the loop raised it.
    """

    def __init__(self, setup: Setup) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        self._process = context.Process(target=_run, args=(other, setup), name="drive", daemon=True)
        with deaf_to_ctrl_c():
            self._process.start()
        other.close()
        try:
            self._answer(BUILD_WITHIN)
        except BaseException:
            self.close()
            raise

    @property
    def pid(self) -> int:
        """Number of the process."""
        return int(self._process.pid or 0)

    def exchange(self, request: Request) -> Snapshot:
        """Hands a request to the loop; how it goes. Takes one period at most, unless the loop builds anew.

        Raises:
            LoopEndedError: there is no loop any more.
        """
        try:
            self._pipe.send(request)
        except OSError:
            raise LoopEndedError("the control loop has ended") from None
        snapshot: Snapshot = self._answer(ANSWER_WITHIN)
        return snapshot

    def _answer(self, seconds: float) -> Any:
        try:
            if not self._pipe.poll(seconds):
                raise LoopEndedError(f"the control loop has not answered for {seconds:g} s")
            answer = self._pipe.recv()
        except (EOFError, OSError):
            raise LoopEndedError("the control loop has ended") from None
        if isinstance(answer, BaseException):
            raise answer
        return answer

    def close(self) -> None:
        """Ends the loop."""
        self._pipe.close()
        self._process.join(END_WITHIN)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


def _window(others: Line | None) -> Window | None:
    """The window through which others look; it lasts as long as the process."""
    if others is None:
        return None
    from rollgait.hardware.topics import VELOCITY
    from rollgait.hardware.transports.elsewhere import Elsewhere
    from rollgait.hardware.window import Window

    return Window(Elsewhere(others), "rollgait: drive", (VELOCITY,))


def _run(pipe: Connection, setup: Setup) -> None:
    """The other process, until the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the page, which closes the pipe
    if hasattr(signal, "pthread_sigmask"):  # and no handler that a solver sets shall hear it either
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what a solver prints belongs nowhere
    logging.getLogger("rollgait").addHandler(logging.NullHandler())  # the page shows the controller's events
    from rollgait.mpc.loop import no_collections
    from rollgait.mpc.setup import make_loop

    with contextlib.suppress(EOFError, OSError), contextlib.ExitStack() as stack:
        try:
            session = Session(
                lambda: make_loop(setup.robot, setup.plant, gait=setup.gait, terrain=setup.terrain),
                terrain=setup.terrain,
                manoeuvres=setup.manoeuvres,
                window=_window(setup.others),
            )
            stack.callback(session.close)
            pipe.send(None)
            session.pace.restart()
            with no_collections():
                for number in itertools.count(1):
                    session.step()
                    while pipe.poll():
                        session.handle(pipe.recv())
                        pipe.send(session.snapshot())
                    if number % COLLECT_EVERY == 0:
                        gc.collect(0)  # what is young is little, and takes a fraction of a millisecond
                    session.pace.wait()
        except RollgaitError as error:
            pipe.send(error)
