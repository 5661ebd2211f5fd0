"""The clock of a plan: its swings, put off when they cannot begin, ended when feet land."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from rollgait.mpc.clock import FEET, GaitClock, TimedSwing
from rollgait.mpc.gaits import CyclicGait
from rollgait.mpc.plans.path import PlanPath, PlanSwing

Array = NDArray[np.float64]

FOLLOWED: Final = CyclicGait("plan")
"""In place of a gait while a plan is followed."""
EARLY_SHARE: Final = 0.6
"""From this share of a swing on, a foot that touches the ground may have landed: before, it leaves it."""
EARLY_HEIGHT: Final = 0.01
"""It has if it should be so much higher than where it is to land, m. Lower down it only touches as planned:
lifts end flat, and their last centimetres of way would be lost."""
LATE_MAX: Final = 0.15
"""So long a foot is waited for that has not found the ground where it should be, s."""
_SOON: Final = 1e-9
SINK_RATE: Final = 0.05
"""With which it is let down meanwhile, m/s."""


@dataclass(frozen=True, eq=False)
class FollowedSwing(TimedSwing):
    """A swing of a plan at the time at which it takes place.

    Attributes:
        path: the plan.
        planned: the swing there.
        waited: by how much its touch-down was put off, s.
    """

    path: PlanPath
    planned: PlanSwing
    waited: float = 0.0

    @property
    def foothold(self) -> Array:
        return self.planned.foothold[:2]

    @property
    def sunk(self) -> float:
        return SINK_RATE * self.waited

    def lands_early(self, time: float) -> bool:
        """Whether a foot that touches the ground at a time has landed."""
        own = self.planned
        passed = (time - self.lift_off) / (self.touch_down - self.lift_off)
        now = own.lift_off + passed * (own.touch_down - own.lift_off)
        z, _ = self.path.foot_height(own.leg, np.array([now]))
        return bool(passed >= EARLY_SHARE and z[0] - own.foothold[2] > EARLY_HEIGHT)

    def over(self, times: Array, begin: float, top: float, end: float) -> tuple[Array, Array]:
        """As the plan has it, from and to the ground as it is."""
        if self.planned.lift_off < 0.0:
            return self._going_on(times, end)
        own, length = self.planned, self.touch_down - self.lift_off
        passed, stretch = (times - self.lift_off) / length, (own.touch_down - own.lift_off) / length
        edges = np.array([own.lift_off, own.touch_down])
        (from_z, to_z), _ = self.path.foot_height(own.leg, edges)
        z, rate = self.path.foot_height(own.leg, own.lift_off + passed * (own.touch_down - own.lift_off))
        begin, end = begin - from_z, end - to_z - self.sunk
        return z + (1.0 - passed) * begin + passed * end, rate * stretch + (end - begin) / length

    @classmethod
    def lifts(cls, swings: Sequence[Self], times: Array) -> tuple[Array, Array]:
        height, rate = np.zeros((2, len(swings), times.size))
        for number, swing in enumerate(swings):
            inside = (times > swing.lift_off) & (times < swing.touch_down)
            height[number, inside], rate[number, inside] = swing.over(times[inside], 0.0, 0.0, 0.0)
        return height, rate

    def _going_on(self, times: Array, end: float) -> tuple[Array, Array]:
        """The same of a swing that had begun before its plan: from where the plan has the foot."""
        own = self.planned
        begin = self.lift_off - own.lift_off  # where the plan begins
        length = self.touch_down - begin
        passed, stretch = (times - begin) / length, own.touch_down / length
        (to_z,), _ = self.path.foot_height(own.leg, np.array([own.touch_down]))
        z, rate = self.path.foot_height(own.leg, passed * own.touch_down)
        gap = end - to_z - self.sunk
        return z + np.clip(passed, 0.0, 1.0) * gap, rate * stretch + gap / length


class PlanClock(GaitClock):
    """When the feet of a plan are where. A gait that is asked for ends the plan.

    Args:
        path: the plan.
        time: at which it begins, s.

    Attributes:
        held: whether the plan is stopped; no foot leaves the ground.
        shift: by how much all that is to come is later than planned, s.
    """

    def __init__(self, path: PlanPath, time: float) -> None:
        super().__init__("stand", time)
        self.path = path
        self._gait, self._origin = FOLLOWED, time
        self.held = False
        self.shift = 0.0
        self.lock(path.locked, time)
        self._done = [self._followed(swing) for swing in path.swings if swing.lift_off < 0.0]

    def _followed(self, swing: PlanSwing) -> FollowedSwing:
        lift_off, touch_down = self._origin + swing.lift_off, self._origin + swing.touch_down
        return FollowedSwing(swing.leg, lift_off, touch_down, 0.0, self.path, swing)

    @property
    def is_followed(self) -> bool:
        """Whether no gait has taken the plan's place."""
        return self._gait is FOLLOWED

    def plan_time(self, time: float) -> float:
        """Time of the plan at a time, s."""
        return time - self._origin

    def hold(self, duration: float) -> None:
        super().hold(duration)
        self.shift += duration

    def lock(self, locked: bool, time: float) -> None:
        """From `time` on wheels on the ground stand still, or roll."""
        self._locked_from = min(self._locked_from, time) if locked else math.inf

    def _planned(self, begin: float, end: float) -> list[TimedSwing]:
        if not self.is_followed:
            return super()._planned(begin, end)
        if self.held:
            return []
        origin = self._origin
        return [
            self._followed(swing)
            for swing in self.path.swings
            if begin < origin + swing.lift_off <= end or (swing.lift_off == 0.0 and begin == origin <= end)
        ]

    def waiting(self, time: float) -> NDArray[np.bool_]:
        """Feet that should have landed and have not, (4,)."""
        result = np.zeros(FEET, dtype=bool)
        for swing in self.swings(time, time + _SOON):
            result[swing.leg] |= isinstance(swing, FollowedSwing) and swing.waited > 0.0
        return result

    def landed(self, leg: int) -> PlanSwing | None:
        """The swing of a leg that has ended last; None if there was none lately."""
        own = [swing for swing in self._done if swing.leg == leg and isinstance(swing, FollowedSwing)]
        return own[-1].planned if own else None

    def land(self, time: float, period: float, touching: NDArray[np.bool_]) -> None:
        """Ends swings of feet that touch the ground, and puts off the ends of those that do not.

        Args:
            time: now, s.
            period: until this is asked again, s.
            touching: which feet press on the ground, (4,).
        """
        waits = False
        for number, swing in enumerate(self._done):
            if swing.touch_down <= time or not isinstance(swing, FollowedSwing):
                continue
            if touching[swing.leg]:
                if swing.lands_early(time):
                    self._done[number] = replace(swing, touch_down=time)
            elif swing.touch_down <= time + period and swing.waited < LATE_MAX:
                waits = True
                self._done[number] = replace(
                    swing, touch_down=swing.touch_down + period, waited=swing.waited + period
                )
        if waits:
            self.hold(period)
