"""Plans in the background, by a process of its own.

Not by a thread: making a problem ready is Python's work, and would hold up the steps of the controller.
"""

from __future__ import annotations

import queue
import time
from dataclasses import dataclass
from typing import Protocol

from rollgait.child import Child
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
        self._answers: queue.Queue[Answer] = queue.Queue()
        self._asked = self._got = 0
        self._child = Child(
            "rollgait.mpc.plans.planning_process",
            heard=lambda said: self._answers.put(said if isinstance(said, Answer) else _dead()),
            ended=lambda: self._answers.put(_dead()),
            silent=True,
        )

    def ask(self, task: Task) -> None:
        """Begins with a task; the answer to an earlier one is dropped when it comes."""
        self._asked += 1
        if not self._child.tell(task):
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
        self._child.close()


def _dead() -> Answer:
    return Answer(None, "the planning process has ended", 0.0)
