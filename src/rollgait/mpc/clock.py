"""The gait in continuous time: which foot is in the air when, and how high.

A change of gait takes effect at the next lift-off, never in mid-swing: swings that have begun are finished,
those that have not are forgotten, and the new gait begins after a short stand in which the weight can shift.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from rollgait.mpc.gaits import CyclicGait, find_gait
from rollgait.ocp.lift import minimum_jerk

Array = NDArray[np.float64]

FEET: Final = 4
BRAKING: Final = 1.5
"""Before wheels are locked the robot may brake for so long, s."""
LEAD: Final = 0.6
"""Between a change of gait and its first lift-off all feet stand, s: time to shift the weight."""
KEPT: Final = 2.0
"""How long swings of the past are kept, s; nothing asks for older ones."""
KNOWN: Final = 2.0
"""How far ahead swings are looked for at least, s: a horizon."""
_SAME: Final = 1e-9


@dataclass(frozen=True)
class TimedSwing:
    """One swing: leg 0 … 3, lift-off and touch-down in s, height in its middle in m."""

    leg: int
    lift_off: float
    touch_down: float
    clearance: float

    @property
    def foothold(self) -> Array | None:
        """Where it must land, (2,), m; None where that is open."""
        return None

    @property
    def sunk(self) -> float:
        """By how much it may be below the ground as it is known, m: it has not found that there."""
        return 0.0

    def over(self, times: Array, begin: float, top: float, end: float) -> tuple[Array, Array]:
        """z of the foot and its rate at times within the swing, (n,), m and m/s.

        Args:
            times: (n,), s.
            begin: z of the ground that it leaves, m.
            top: highest ground on its way, m.
            end: z of the ground where it lands, m.
        """
        apex = max(top, end) + self.clearance
        share, rate, rises = _risen(times, self.lift_off, self.touch_down)
        foot = np.where(rises, begin, end)
        return foot + (apex - foot) * share, (apex - foot) * rate

    @classmethod
    def lifts(cls, swings: Sequence[Self], times: Array) -> tuple[Array, Array]:
        """Heights over level ground and their rates at times (n,), in and beside the swings: (m, n) each."""
        lift_off, touch_down = _ends(swings)
        share, rate, _ = _risen(times, lift_off[:, None], touch_down[:, None])
        clearance = np.array([swing.clearance for swing in swings])[:, None]
        return clearance * share, clearance * rate


def _risen(
    times: Array, lift_off: Array | float, touch_down: Array | float
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Share of its full height that a foot has at times, its rate, 1/s, and whether the foot still rises."""
    half = 0.5 * (touch_down - lift_off)
    rise, fall = (times - lift_off) / half, (touch_down - times) / half
    rises = rise < fall
    share, slope = minimum_jerk(np.minimum(rise, fall))
    return share, np.where(rises, slope, -slope) / half, rises


def _ends(swings: Sequence[TimedSwing]) -> tuple[Array, Array]:
    """Lift-offs and touch-downs, (m,), s."""
    ends = np.array([(swing.lift_off, swing.touch_down) for swing in swings])
    return ends[:, 0], ends[:, 1]


@dataclass
class _Known:
    """Swings that were found: beginning, origin and gait of which, up to which time, s."""

    of: tuple[float, float, CyclicGait, int] | None = None
    end: float = -math.inf
    swings: list[TimedSwing] = field(default_factory=list)


class GaitClock:
    """Swings in the past and the future, by gait. Times only go on: see `advance`."""

    def __init__(self, gait: str, time: float = 0.0) -> None:
        self._gait = find_gait(gait)
        self._origin = time + LEAD
        self._locked_from = time if self._gait.wheels == "locked" else math.inf
        self._time = time
        self._done: list[TimedSwing] = []
        self._known = _Known()

    @property
    def gait(self) -> CyclicGait:
        """The gait that decides about the next lift-off."""
        return self._gait

    def request(self, gait: str, time: float) -> None:
        """From `time` on another gait; swings in progress are finished. Raises `UnknownNameError`."""
        new = find_gait(gait)
        if new == self._gait:
            return
        self.advance(time)
        standing = max([time, *(swing.touch_down for swing in self._done)])
        if new.wheels != "locked":
            self._locked_from = math.inf
        elif not self.locked(time):
            standing += BRAKING
            self._locked_from = standing
        self._gait, self._origin = new, standing + LEAD

    def pending(self, time: float, period: float) -> list[int]:
        """Legs that are to leave the ground within a period from now."""
        return [swing.leg for swing in self._planned(max(time, self._time), time + period)]

    def hold(self, duration: float) -> None:
        """Puts off all swings that have not begun."""
        self._origin += duration

    def locked(self, time: float) -> bool:
        """Whether wheels on the ground stand still at a time."""
        return time >= self._locked_from

    @property
    def locked_from(self) -> float:
        """Since or from when wheels on the ground stand still, s; infinite where they roll."""
        return self._locked_from

    @property
    def brakes(self) -> bool:
        """Whether the robot shall come to rest: the gait says so, or it is about to lock its wheels."""
        return self._gait.brakes or (self._gait.wheels == "locked" and not self.locked(self._time))

    def advance(self, time: float) -> None:
        """Lets the past be past: what began before `time` can no longer change."""
        if time > self._time:
            self._done = self._begun(time)
            self._time = time

    def _begun(self, time: float) -> list[TimedSwing]:
        """Swings that have begun by `time`, without those long ago."""
        recent = [swing for swing in self._done if swing.touch_down > time - KEPT]
        return recent + self._planned(self._time, time)

    def _planned(self, begin: float, end: float) -> list[TimedSwing]:
        """Swings of the present gait with `begin` < lift-off ≤ `end`.

        A step of the controller asks for them again and again, each time somewhat farther or less far.
        """
        known, gait = self._known, self._gait
        if gait.swing <= 0.0:
            return []
        if known.of != (begin, self._origin, gait, len(self._done)) or end > known.end:
            until = max(end, begin + KNOWN)
            known.of, known.end = (begin, self._origin, gait, len(self._done)), until
            known.swings = self._found(begin, until)
        return [swing for swing in known.swings if swing.lift_off <= end]

    def _found(self, begin: float, end: float) -> list[TimedSwing]:
        result, gait = [], self._gait
        latest = {swing.leg: swing.lift_off for swing in self._done}
        for leg, phase in enumerate(gait.phase):
            begin_leg = max(begin, latest.get(leg, -math.inf) + gait.swing)
            first = self._origin + phase * gait.period
            cycle = max(0, math.ceil((begin_leg - first) / gait.period - _SAME))
            while (lift_off := first + cycle * gait.period) <= end:
                if lift_off > begin_leg:
                    result.append(TimedSwing(leg, lift_off, lift_off + gait.swing, gait.clearance))
                cycle += 1
        return result

    def swings(self, begin: float, end: float) -> list[TimedSwing]:
        """All swings that touch the time from `begin` to `end`, s."""
        every = [*self._done, *self._planned(self._time, end)]
        return [swing for swing in every if swing.lift_off < end and swing.touch_down > begin]

    def stance_share(self, edges: Array) -> Array:
        """Share of each interval between `edges` (N + 1,) in which each foot stands, (N, 4)."""
        share: Array = np.ones((edges.size - 1, FEET))
        swings = self.swings(float(edges[0]), float(edges[-1]))
        if not swings:
            return share
        begins, ends = edges[:-1], edges[1:]
        from_on, until = (np.minimum(np.maximum(time[:, None], begins), ends) for time in _ends(swings))
        for swing, in_air in zip(swings, (until - from_on) / (ends - begins), strict=True):
            share[:, swing.leg] -= in_air
        share[share < _SAME] = 0.0
        return share

    def contact(self, time: float) -> NDArray[np.bool_]:
        """Which feet stand at a time, (4,)."""
        result = np.ones(FEET, dtype=bool)
        for swing in self.swings(time, time + _SAME):
            result[swing.leg] &= not swing.lift_off <= time < swing.touch_down
        return result

    def stride(self, times: Array) -> Array:
        """How long before the middle of its stance each foot is (after it: negative), (n, 4), s.

        In swing it goes back to the beginning of a stance. Without steps it is always in the middle.
        """
        result, gait = np.zeros((times.size, FEET)), self._gait
        half = 0.5 * (gait.period - gait.swing)
        if gait.swing <= 0.0:
            return result
        swings = self.swings(float(times[0]), float(times[-1]) + gait.period)
        for leg in range(FEET):
            own = [swing for swing in swings if swing.leg == leg]
            for k, time in enumerate(times.tolist()):
                ahead = [swing for swing in own if swing.touch_down > time]
                if not ahead:
                    continue
                swing = min(ahead, key=lambda one: one.lift_off)
                if time < swing.lift_off:
                    result[k, leg] = np.clip(swing.lift_off - half - time, -half, half)
                else:
                    share = (time - swing.lift_off) / (swing.touch_down - swing.lift_off)
                    result[k, leg] = (2.0 * share - 1.0) * half
        return result

    def lift(self, times: Array) -> tuple[Array, Array]:
        """Height of each foot above the ground and its rate at times (n,): (n, 4) in m and m/s."""
        height, rate = np.zeros((times.size, FEET)), np.zeros((times.size, FEET))
        swings = self.swings(float(times.min()), float(times.max()) + _SAME)
        for kind in {type(swing) for swing in swings}:
            own = [swing for swing in swings if type(swing) is kind]
            for swing, its_height, its_rate in zip(own, *kind.lifts(own, times), strict=True):
                height[:, swing.leg] += its_height  # two swings of a foot are never at once
                rate[:, swing.leg] += its_rate
        return height, rate
