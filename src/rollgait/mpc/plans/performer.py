"""Carries out manoeuvres while a robot is driven: it comes to rest, plans from there, follows the plan.

Planning takes a process of its own, so the controller goes on meanwhile, and commands count again afterwards.
"""

from __future__ import annotations

from typing import Final, Literal

import numpy as np

from rollgait.errors import InputError
from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.plans.joining import PLACE_MAX
from rollgait.mpc.plans.manoeuvres import Manoeuvre, placed
from rollgait.mpc.plans.worker import ScenarioTask, Worker
from rollgait.plan.plan import Plan
from rollgait.plant.state import RobotState
from rollgait.terrain.terrain import Terrain

Stage = Literal["", "coming to rest", "planning", "following", "stopping"]

STILL: Final = 0.02
"""m/s and rad/s, below which a robot is at rest."""
LASTING: Final = 0.3
"""It must be for so long, s."""
REST_WITHIN: Final = 12.0
"""And come to it within this, s: a crawl puts its feet down at the end of its cycle."""
PLANNED_WITHIN: Final = 30.0
"""s of processor time that the search for a way over terrain may take."""
MOVED: Final = 0.8 * PLACE_MAX
"""By how much the robot may have moved while its plan was made, m."""


class Performer:
    """Does what is asked for, one manoeuvre at a time.

    Args:
        mpc: the controller.
        terrain: the ground; level if None.
        worker: the process that plans; made when it is needed first, if none is given.

    Attributes:
        name: of the manoeuvre, "" if there is none.
        stage: how far it is.
    """

    def __init__(self, mpc: Mpc, terrain: Terrain | None, worker: Worker | None = None) -> None:
        self._mpc, self._terrain, self.worker = mpc, terrain, worker
        self._manoeuvre: Manoeuvre | None = None
        self._plan: Plan | None = None
        self.stage: Stage = ""
        self._since = self._still_since = 0.0

    @property
    def name(self) -> str:
        """Of the manoeuvre that is under way; "" if none is."""
        return "" if self._manoeuvre is None else self._manoeuvre.name

    def close(self) -> None:
        """Ends the process that plans."""
        if self.worker is not None:
            self.worker.close()
            self.worker = None

    def ask(self, manoeuvre: Manoeuvre, state: RobotState) -> None:
        """Begins with a manoeuvre; one that is under way must be stopped before."""
        if self._manoeuvre is not None:
            self._mpc.note(f"{manoeuvre.name}: not begun, as {self.name} is under way; stop it before")
            return
        if self.worker is None:
            self.worker = Worker()
        self._manoeuvre, self.stage = manoeuvre, "coming to rest"
        self._since = self._still_since = state.time

    def halt(self) -> None:
        """Ends what is under way: at once, or where all feet stand next."""
        if self.stage == "following":
            self.stage = "stopping"
            self._mpc.halt()
        elif self.stage in ("coming to rest", "planning"):
            self._end("stopped before it began")

    def _end(self, why: str = "") -> None:
        if why:
            self._mpc.note(f"{self.name}: {why}")
        self._manoeuvre, self._plan, self.stage = None, None, ""

    def command(self, asked: VelocityCommand) -> VelocityCommand:
        """What counts in place of what is asked for: a robot that is to begin a plan stands."""
        if self._manoeuvre is None:
            return asked
        return VelocityCommand(gait="drive")

    def said(self, state: RobotState) -> str:
        """How far it is, for a person; "" if nothing is under way."""
        if self._manoeuvre is None:
            return ""
        progress = self._mpc.progress
        if self._plan is None or progress is None:
            return f"{self.name}: {self.stage}, {state.time - self._since:.0f} s"
        return f"{self.name}: {self.stage}, {progress.plan_time:.1f} of {self._plan.horizon:.1f} s"

    def update(self, state: RobotState) -> None:
        """After a step of the controller and the plant.

        Args:
            state: of the robot now.
        """
        if self.stage == "coming to rest":
            self._come_to_rest(state)
        elif self.stage == "planning":
            self._take_plan(state)
        elif self.stage in ("following", "stopping"):
            self._follow()

    def _come_to_rest(self, state: RobotState) -> None:
        stands = bool(self._mpc.clock.contact(state.time).all())
        rates = np.concatenate([state.com_velocity, state.euler_rate, state.speed])
        if not stands or np.abs(rates).max() > STILL:
            self._still_since = state.time
            if state.time - self._since > REST_WITHIN:
                self._end(f"the robot does not come to rest within {REST_WITHIN:g} s")
            return
        if state.time - self._still_since < LASTING:
            return
        assert self._manoeuvre is not None
        assert self.worker is not None
        try:
            scenario = placed(self._manoeuvre, self._mpc.robot, state, self._terrain)
        except InputError as error:
            self._end(str(error))
            return
        self.worker.ask(ScenarioTask(scenario, PLANNED_WITHIN))
        self.stage, self._since = "planning", state.time

    def _take_plan(self, state: RobotState) -> None:
        assert self.worker is not None
        answer = self.worker.answer(0.0)
        if answer is None:
            return
        if answer.plan is None:
            self._end(answer.message)
            return
        begin = answer.plan.state_at(0.0)
        moved = np.abs((state.foot_position - begin.foot_position)[:, :2]).max()
        if moved > MOVED:
            self._end(f"the robot has moved by {1e3 * moved:.0f} mm while it was planned")
            return
        try:
            self._mpc.follow(answer.plan)
        except InputError as error:
            self._end(str(error))
            return
        self._plan, self.stage = answer.plan, "following"

    def _follow(self) -> None:
        if self._mpc.rests:
            progress = self._mpc.progress
            phase = "" if progress is None else progress.phase
            self._mpc.leave()
            self._end("" if phase == "done" else phase)
        elif not self._mpc.is_following:
            self._end("ended, as the controller follows no plan any more")
