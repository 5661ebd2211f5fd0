"""Replaces a plan that no longer fits, in mid-motion, while the controller goes on with it.

The new plan is made for where the robot will be: the state that the controller expects `AHEAD` later. Then
it takes over, if it is ready and the robot moves as it begins; else it is thrown away and said.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from rollgait.errors import InputError
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.plans.follower import Progress
from rollgait.mpc.plans.worker import RestTask, Worker
from rollgait.plan.plan import Plan
from rollgait.plan.rest import LEAST
from rollgait.plant.state import RobotState

AHEAD: Final = 0.5
"""s of the robot's time, which planning may take: a rest of 10 s takes 0.1 to 0.4 s."""
GIVEN_UP: Final = 2.0 * AHEAD
"""s of processor time, after which a plan not found is given up: nobody waits longer than `AHEAD`, but
what takes little more says by how much."""
STANDING: Final = 0.5
"""For so long a robot that had to wait stands on before the rest goes on, s: its weight may have to shift."""
OFF: Final = 0.03
"""From so far off the plan on it no longer fits: CoM or a foot in the ground plane, m."""
OFF_YAW: Final = math.radians(4.0)
"""The same of the yaw, rad."""
LASTING: Final = 0.1
"""For so long, s: a moment's error the controller mends."""
PAUSE: Final = 0.5
"""Between two tries, s."""
READY: Final = 60.0
"""Within which the planning process must be ready, s of wall time: it may have to compile."""


@dataclass(frozen=True)
class Replacement:
    """A plan that was to take another one's place.

    Attributes:
        time: at which it was to begin, s.
        plan_time: time of the plan that it replaces then, s.
        why: what no longer fitted.
        done: whether it took over.
        message: why not.
        seconds: of processor time that planning took; 0 if it was not ready.
    """

    time: float
    plan_time: float
    why: str
    done: bool
    message: str
    seconds: float

    def __str__(self) -> str:
        if self.done:
            took = f"(planned in {self.seconds:.2f} s)"
            return f"the plan is replaced at t = {self.time:.2f} s because {self.why} {took}"
        return f"the plan is not replaced at t = {self.time:.2f} s, though {self.why}: {self.message}"


@dataclass(frozen=True)
class _Pending:
    begin: float
    plan_time: float
    why: str
    number: int
    waited: bool
    """Whether the plan waited when this was asked for."""


class Replanner:
    """Watches a controller that follows plans, and replaces one that no longer fits.

    Args:
        mpc: the controller.
        plans: those that it follows, in order; one that is replaced is followed by the new one.
        waits: whether time waits for a plan, as in a simulation: planning may take `AHEAD` of processor time
            then, however busy the machine is. A real robot's time does not.

    Attributes:
        replacements: all that were tried.
    """

    def __init__(self, mpc: Mpc, plans: list[Plan], waits: bool = True) -> None:
        self._mpc, self._plans, self._waits = mpc, plans, waits
        self.replacements: list[Replacement] = []
        self._pending: _Pending | None = None
        self._off_since, self._next = math.inf, 0.0
        self._worker = Worker()
        self._worker.ask(RestTask(plans[0], 0.0, None))  # loads and compiles what the next ones need
        self._worker.answer(READY)

    def close(self) -> None:
        """Ends the process that plans."""
        self._worker.close()

    def update(self, state: RobotState) -> None:
        """After a step of the controller and the plant: asks for a plan, or lets one take over.

        Args:
            state: of the robot now, from which the next step begins.
        """
        progress = self._mpc.progress
        if progress is None or progress.phase in ("done", "given up", "joining", "stopped"):
            self._pending, self._off_since = None, math.inf
            return
        if self._pending is not None and self._pending.waited != (progress.phase == "holding"):
            self._pending = None  # it was asked for from another way to go on
        if self._pending is not None:
            if state.time >= self._pending.begin - 0.5 * self._mpc.settings.period:
                pending, self._pending = self._pending, None
                self._take_over(pending, progress)
                self._next = state.time + PAUSE
            return
        why = self._why(state, progress)
        if why and state.time >= self._next:
            self._ask(why, state, progress)

    def _why(self, state: RobotState, progress: Progress) -> str:
        """What does not fit any more; nothing if all does."""
        planned = self._mpc.planned
        if planned is None:
            return ""
        away = float(np.hypot(*(state.com_position - planned.com_position)[:2]))
        feet = float(np.linalg.norm((state.foot_position - planned.foot_position)[:, :2], axis=1).max())
        turned = abs((state.euler[0] - planned.euler[0] + math.pi) % (2.0 * math.pi) - math.pi)
        gap = (
            f"the CoM is {1e3 * away:.0f} mm, a foot {1e3 * feet:.0f} mm, "
            f"the yaw {math.degrees(turned):.1f} degrees off"
        )
        if progress.phase == "holding":
            return f"it had to wait: {gap}"
        if max(away, feet) <= OFF and turned <= OFF_YAW:
            self._off_since = math.inf
            return ""
        self._off_since = min(self._off_since, state.time)
        return gap if state.time - self._off_since >= LASTING else ""

    def _ask(self, why: str, state: RobotState, progress: Progress) -> None:
        """Asks for the rest of the plan from where the robot will be."""
        mpc = self._mpc
        expected = mpc.expected(AHEAD)
        ahead = 0.0 if progress.phase == "holding" else expected.time - state.time
        plan, plan_time = self._plans[progress.number], progress.plan_time + ahead
        if plan_time > plan.horizon - LEAST:
            return
        waited = progress.phase == "holding"
        self._worker.ask(RestTask(plan, plan_time, expected, STANDING if waited else 0.0, GIVEN_UP))
        self._pending = _Pending(expected.time, plan_time, why, progress.number, waited)

    def _take_over(self, pending: _Pending, progress: Progress) -> None:
        """The plan that was asked for begins, or is thrown away."""
        answer = self._worker.answer(READY if self._waits else 0.0)
        message, seconds = "it was not ready in time", 0.0
        if answer is not None and self._waits and answer.seconds > AHEAD:
            seconds = answer.seconds
            message = f"planning took {seconds:.2f} s, more than {AHEAD:g} s"
        elif progress.number != pending.number:
            message = "another plan is followed by now"
        elif answer is not None:
            message, seconds = answer.message, answer.seconds
            if answer.plan is not None:
                try:
                    self._mpc.replace(answer.plan, pending.begin)
                    self._plans.insert(pending.number + 1, answer.plan)
                except InputError as error:
                    message = f"it no longer fits either ({error})"
        found = Replacement(pending.begin, pending.plan_time, pending.why, not message, message, seconds)
        self.replacements.append(found)
        self._mpc.note(str(found))
