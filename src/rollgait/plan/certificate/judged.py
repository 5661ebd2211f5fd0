"""What the judge asks of a plan: a protocol, as a plan is judged by what knows no plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from numpy.typing import ArrayLike

from rollgait.plan.samples import Samples
from rollgait.robot.robot import Robot
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule

if TYPE_CHECKING:  # it needs the dynamics, which the judge does not
    from rollgait.plan.trajectory import Trajectory


class Judged(Protocol):
    """A planned motion; see `Plan`, which is one."""

    @property
    def robot(self) -> Robot:
        """The robot it is for."""

    @property
    def scenario(self) -> Scenario:
        """What was asked."""

    @property
    def schedule(self) -> ContactSchedule:
        """Which foot is on the ground when."""

    @property
    def trajectory(self) -> Trajectory:
        """What is stored of the motion: looked at for its intervals, and for numbers that are none."""

    @property
    def horizon(self) -> float:
        """T, s."""

    def sample(self, time: ArrayLike) -> Samples:
        """The motion at times within [0, T], s."""
