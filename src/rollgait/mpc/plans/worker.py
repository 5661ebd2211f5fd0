"""Plans in the background, by a process of its own.

Not by a thread: making a problem ready is Python's work, and would hold up the steps of the controller.
Tasks and answers are pickled: both ends are this package, and nobody else has the pipes.
"""

from __future__ import annotations

import pickle
import queue
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from typing import Protocol

from rollgait.plan.plan import Plan
from rollgait.plan.rest import Rest
from rollgait.plant.state import RobotState
from rollgait.scenario.scenario import Scenario


class Task(Protocol):
    """Something to plan."""

    @property
    def asked(self) -> Rest | Scenario:
        """What `Planner.plan` is to plan. Raises `RollgaitError` if that cannot be."""

    @property
    def seconds(self) -> float | None:
        """Of processor time, after which it is given up; an iteration may exceed it; never if None."""


@dataclass(frozen=True)
class RestTask:
    """The rest of a plan from a time of it on, s, from a state, or as planned; put off by a delay, s."""

    plan: Plan
    time: float
    state: RobotState | None
    delay: float = 0.0
    seconds: float | None = None

    @property
    def asked(self) -> Rest:
        """What is left of the plan."""
        return self.plan.rest(self.time, self.state, self.delay)


@dataclass(frozen=True)
class ScenarioTask:
    """A scenario, its start as it stands there."""

    asked: Scenario
    seconds: float | None = None


@dataclass(frozen=True)
class Answer:
    """A certified plan, or why there is none; after how long, s of processor time."""

    plan: Plan | None
    message: str
    seconds: float


class Worker:
    """A process that plans one task after another, and forgets answers that nobody waits for any more."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "rollgait.mpc.plans.planning_process"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self._answers: queue.Queue[Answer] = queue.Queue()
        self._asked = self._got = 0
        threading.Thread(target=self._listen, daemon=True).start()

    def ask(self, task: Task) -> None:
        """Begins with a task; the answer to an earlier one is dropped when it comes."""
        assert self._process.stdin is not None
        self._asked += 1
        try:
            pickle.dump(task, self._process.stdin)
            self._process.stdin.flush()
        except OSError:
            self._answers.put(_dead())

    def answer(self, timeout: float) -> Answer | None:
        """The answer to the last task; None if there is none after a time, s of wall time."""
        until = time.monotonic() + timeout
        while True:
            try:
                found = self._answers.get(timeout=max(0.0, until - time.monotonic()))
            except queue.Empty:
                return None
            self._got += 1
            if self._got == self._asked:
                return found

    def close(self) -> None:
        """Ends the process."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        self._process.kill()
        self._process.wait()

    def _listen(self) -> None:
        stream = self._process.stdout
        assert stream is not None
        with stream:
            while True:
                try:
                    self._answers.put(pickle.load(stream))
                except (EOFError, OSError, pickle.UnpicklingError):
                    self._answers.put(_dead())
                    return


def _dead() -> Answer:
    return Answer(None, "the planning process has ended", 0.0)
