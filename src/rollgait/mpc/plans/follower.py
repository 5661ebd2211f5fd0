"""Follows plans one after the other: goes on, waits at a safe phase when pushed off, ends in a stand."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from rollgait.mpc.command import PoseCommand
from rollgait.mpc.plans.clock import PlanClock
from rollgait.mpc.plans.joining import check_continues, check_joins, whole_turns
from rollgait.mpc.plans.path import PlanPath, Row
from rollgait.mpc.plans.wanted import Wanted
from rollgait.mpc.reference import LEASH, Reference, ReferenceMaker
from rollgait.plant.state import RobotState

Array = NDArray[np.float64]
Phase = Literal["joining", "going", "holding", "done", "given up", "stopped"]

PUSHED_OFF: Final = (0.05, 0.09, 0.05)
"""From so far off on the plan waits while all feet stand: place of the CoM (m), yaw (rad), a foot (m)."""
BACK: Final = (0.015, 0.03, 0.05)
"""It goes on when the robot is as near as this."""
AT_REST: Final = 0.03
"""And moves no faster over the ground, m/s."""
STEERED: Final = 0.1
"""And its wheels point where they shall, rad."""
PATIENCE: Final = 10.0
"""A robot that is not back after so long is given up: it stands where it is, s."""
CRUISE: Final = 0.1
"""With which it goes back, m/s."""
BRAKING: Final = 1.0
"""With which the robot comes to rest along the plan where that waits, and speeds up again, m/s²."""
RATE_SLOPE_MAX: Final = 4.0
"""A plan that hardly moves stops and goes on no faster, 1/s."""
LATE: Final = 0.04
"""From so far behind the plan on, time on its way, it goes slower, s."""
SLOWED: Final = 0.7
"""By this factor."""
MOVING: Final = 0.05
"""A plan that moves more slowly has nobody behind it, m/s."""
NEAR: Final = 0.01
"""Nearer than this it no longer rolls to its place, m: the legs do the rest."""
NEAR_YAW: Final = 0.01
"""The same of the yaw, rad."""
AWAY: Final = 0.03
"""Farther it rolls again, m."""
AWAY_YAW: Final = 0.03
"""The same of the yaw, rad."""


@dataclass(frozen=True)
class Progress:
    """How far the following of plans is.

    Attributes:
        phase: `joining` a plan at its beginning, `going`, `holding` at a safe phase, `done`, `given up`, or
            `stopped` as it was asked to.
        number: of the plan, from 0.
        plan_time: time of the plan now, s.
        shift: by how much it is late, s.
        holds: how often it had to wait because the robot was pushed off.
    """

    phase: Phase
    number: int
    plan_time: float
    shift: float
    holds: int


class PlanFollower:
    """What to do about plans.

    Args:
        paths: the plans, in order.
        reference: leads the robot back to where the plan waits.
        period: of the controller, s.
        note: hears what is not as planned.
    """

    def __init__(
        self,
        paths: Sequence[PlanPath],
        reference: ReferenceMaker,
        period: float,
        note: Callable[[str], None],
    ) -> None:
        self._paths, self._reference, self._period, self._note = tuple(paths), reference, period, note
        self._number, self._holds = 0, 0
        self._phase: Phase = "joining"
        self._since, self._rate = 0.0, 1.0
        self._halts = False

    def halt(self) -> None:
        """The plan that is followed ends when all feet stand next and it can come to rest."""
        self._halts = True

    @property
    def rests(self) -> bool:
        """Whether it has ended, and stands still."""
        return self._phase in ("done", "given up", "stopped") and self._rate <= 0.0

    @property
    def path(self) -> PlanPath:
        """The plan that is followed now."""
        return self._paths[self._number]

    def begin(self, state: RobotState) -> PlanClock:
        """Begins to follow, from a state. Raises `InputError` if the first plan begins elsewhere."""
        check_joins(self.path, state, "where the robot is")
        return self._join(state)

    def _join(self, state: RobotState) -> PlanClock:
        path, time = self.path, state.time
        path.turn(whole_turns(path.at(np.zeros(1)), float(state.euler[0])))
        self.clock = PlanClock(path, time)
        self._phase, self._since, self._rate = "joining", time, 0.0
        self._wait(path.at(np.zeros(1)), time)
        return self.clock

    def replace(self, path: PlanPath, state: RobotState, time: float) -> PlanClock:
        """From `time` on another plan in place of this one, which begins in motion.

        Raises `InputError` if it does not begin as the robot moves at its state then; nothing has changed.
        """
        path.turn(whole_turns(path.at(np.zeros(1)), float(state.euler[0])))
        clock = PlanClock(path, time)
        check_continues(path, state, self.clock.contact(time), clock.contact(time))
        clock.shift = self.clock.shift
        number = self._number + 1
        self._paths = (*self._paths[:number], path, *self._paths[number:])
        self._number, self._phase, self._rate, self.clock = number, "going", 1.0, clock
        return clock

    def progress(self, time: float) -> Progress:
        """How far it is at a time."""
        s = float(np.clip(self.clock.plan_time(time), 0.0, self.path.length))
        return Progress(self._phase, self._number, s, self.clock.shift, self._holds)

    def twist(self, time: float) -> tuple[float, float, float]:
        """Forward and lateral velocity (m/s) and yaw rate (rad/s) of the plan at a time."""
        return self.path.at(np.array([self.clock.plan_time(time)])).twist

    # -- in every step -----------------------------------------------------------------------------------

    def update(self, state: RobotState, touching: NDArray[np.bool_] | None) -> PlanClock:
        """Decides whether the plan goes on. Returns its clock: another one where the next plan begins."""
        clock, time, period = self.clock, state.time, self._period
        if touching is not None:
            clock.land(time, period, touching)
        here = self.path.at(np.array([self._time_in_plan(time)]))
        stands = bool(clock.contact(time).all())
        slope, wanted_rate = _rate_slope(here), 1.0
        if self._phase == "going":
            if stands and clock.plan_time(time) >= self.path.length - 1e-9:
                self._phase = "done"
                if self._number + 1 < len(self._paths):
                    self._number += 1
                    return self._join(state)
                self._wait(here, time)
            elif stands and self._halts and self._can_stop(time, slope):
                self._phase, clock.held = "stopped", True
            elif stands and self._is_off(state, here, PUSHED_OFF) and self._can_stop(time, slope):
                self._phase, self._since, self._holds = "holding", time, self._holds + 1
                self._note("pushed off the plan: it waits")
                clock.held = True
            elif stands and _behind(state, here) > LATE:
                wanted_rate = SLOWED
        elif self._phase in ("joining", "holding"):
            if self._halts:
                self._phase = "stopped"
            elif self._rate > 0.0:
                pass  # still comes to rest
            elif self._is_back(state, here):
                if self._phase == "holding":
                    self._note(f"back after {time - self._since:.2f} s: the plan goes on")
                else:
                    clock.shift = 0.0  # a plan that begins late is not late
                self._phase, clock.held = "going", False
                if self._time_in_plan(time) == 0.0:
                    self._rate = 1.0  # a plan begins at rest
                clock.lock(self.path.locked, time)
            elif time - self._since > PATIENCE:
                self._phase = "given up"
                self._note(f"not back on the plan after {PATIENCE:g} s: it is given up")
        elif self._phase == "done" and self._rate <= 0.0:
            self._rest(state, here)
        if clock.held:
            wanted_rate = 0.0
        if clock.pending(time, period) or not stands:
            self._rate = 1.0
        else:
            before, step = self._rate, slope * period
            self._rate += float(np.clip(wanted_rate - self._rate, -step, step))
            if clock.held and before > 0.0 >= self._rate:
                self._wait(here, time)
        if self._rate < 1.0:
            late = clock.shift
            clock.hold((1.0 - self._rate) * period)
            if self._phase == "done":
                clock.shift = late  # nothing is to come
        return clock

    def _rest(self, state: RobotState, here: Row) -> None:
        """At its end the robot rests on wheels that stand still: the legs bring the base to its place."""
        if _is_near(state, here):
            self.clock.lock(True, state.time)
        elif self._is_off(state, here, (AWAY, AWAY_YAW, np.inf)):
            self.clock.lock(False, state.time)

    def _can_stop(self, time: float, slope: float) -> bool:
        """Whether the plan can come to rest before its next lift-off."""
        s = self.clock.plan_time(time)
        ahead = [swing.lift_off - s for swing in self.path.swings if swing.lift_off > s]
        return min(ahead, default=np.inf) > 0.5 * self._rate**2 / slope

    def _time_in_plan(self, time: float) -> float:
        return float(np.clip(self.clock.plan_time(time), 0.0, self.path.length))

    def _wait(self, here: Row, time: float) -> None:
        self.clock.held = True
        self.clock.lock(False, time)
        self._reference.begin_at(here.pose, here.twist)

    def _is_off(self, state: RobotState, here: Row, limits: tuple[float, float, float]) -> bool:
        away = np.hypot(*(state.com_position - here.com_position[0])[:2])
        feet = np.linalg.norm((state.foot_position - here.foot_position[0])[:, :2], axis=1)
        turned = abs(state.euler[0] - here.euler[0, 0])
        return bool(away > limits[0] or turned > limits[1] or feet.max() > limits[2])

    def _is_back(self, state: RobotState, here: Row) -> bool:
        if self._is_off(state, here, BACK) or np.hypot(*state.com_velocity[:2]) > AT_REST:
            return False
        steers = np.array([leg.foot == "steerable" for leg in self.path.robot.leg_list])
        return bool((np.abs(state.heading - here.heading[0])[steers] < STEERED).all())

    # -- the horizon -------------------------------------------------------------------------------------

    def wanted(self, state: RobotState, elapsed: float, count: int, interval: float) -> Wanted:
        """What the next `count` intervals shall look like."""
        s, steps = self.clock.plan_time(state.time), interval * np.arange(count + 1)
        if self.clock.held and self._rate <= 0.0:
            return self._held(state, self._time_in_plan(state.time), elapsed, count, interval)
        now = self.path.at(np.array([s]))
        # how the plan will go on: to rest, or soon as fast as planned
        rate = np.clip(self._rate + (-1.0 if self.clock.held else 1.0) * _rate_slope(now) * steps, 0.0, 1.0)
        edges = s + np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * interval)])
        rows = self.path.at(edges).slowed(rate)
        in_air = ~np.array([self.clock.contact(float(state.time + step)) for step in steps])
        pose = np.vstack([rows.com_position.T, rows.euler[:, 0]])
        rate = np.vstack([rows.com_velocity.T, rows.euler_rate[:, 0]])
        # at another pace than planned the forces are those of the plan's own
        waits = self.clock.waiting(state.time)
        own_edges: Array = np.asarray(edges if rate.min() == 1.0 else s + steps)
        force, motion = self.path.means(own_edges)
        period = min(self._period, interval)
        now_force, now_motion = self.path.means(s + np.array([0.0, period]))
        # a foot begins to wait within a period of its touch-down
        _, landed = self.path.means(s + period + np.array([0.0, period]))
        away = pose[:2, 0] - state.com_position[:2]
        distance = float(np.hypot(*away))
        if distance > LEASH:
            pose[:2] -= ((1.0 - LEASH / distance) * away)[:, None]
        reference = Reference(pose, rate, rows.heading.T, rows.speed.T, np.zeros((2, 4, count + 1)))
        return Wanted(
            reference=reference,
            tilt=rows.euler[:, 1:].T,
            climb=rows.com_velocity[:, 2],
            foot_position=rows.foot_position,
            com_position=rows.com_position,
            in_air=in_air,
            force=force,
            waits=waits,
            landed=landed[0, :, 0],
            lead=(now_force[0] - force[0], self._rate * (now_motion[0] - motion[0])),
        )

    def _held(self, state: RobotState, s: float, elapsed: float, count: int, interval: float) -> Wanted:
        """Back to where the plan waits, or standing there."""
        rows = self.path.at(np.full(count + 1, s))
        x, y, yaw = rows.pose
        command = PoseCommand(x=x, y=y, yaw_deg=float(np.degrees(yaw)), cruise=CRUISE)
        found = self._reference.look_ahead(state, command, self.clock, elapsed, count, interval)
        rests = self.clock.locked(state.time)
        near = rests or _is_near(state, rows)
        pose = np.vstack([found.pose[:2], rows.com_position[:, 2], found.pose[3]])
        if near:
            pose[:2], pose[3] = rows.com_position[:, :2].T, yaw
            still = np.zeros_like(found.speed)
            found = replace(found, rate=np.zeros_like(found.rate), heading=rows.heading.T, speed=still)
        return Wanted(
            reference=replace(found, pose=pose),
            tilt=rows.euler[:, 1:].T,
            climb=np.zeros(count + 1),
            foot_position=rows.foot_position,
            com_position=rows.com_position,
            in_air=np.zeros((count + 1, 4), dtype=bool),
            force=np.broadcast_to(self.path.static_force(s), (count, 4, 3)),
            waits=np.zeros(4, dtype=bool),
            landed=np.zeros(4),
            lead=(np.zeros((4, 3)), np.zeros((4, 2))),
            rests=rests,
        )


def _is_near(state: RobotState, here: Row) -> bool:
    """Whether a robot is so near its place that the legs can do the rest."""
    away = np.hypot(*(state.com_position - here.com_position[0])[:2])
    return bool(away < NEAR and abs(state.euler[0] - here.euler[0, 0]) < NEAR_YAW)


def _rate_slope(here: Row) -> float:
    """How fast a plan may stop and go on, in shares of its own speed per second."""
    fastest = float(np.abs(here.speed[0]).max())
    return min(RATE_SLOPE_MAX, BRAKING / max(fastest, 1e-3))


def _behind(state: RobotState, here: Row) -> float:
    """By how much a robot is behind on its way, s."""
    velocity = here.com_velocity[0, :2]
    square = float(velocity @ velocity)
    if square < MOVING**2:
        return 0.0
    return float((here.com_position[0, :2] - state.com_position[:2]) @ velocity) / square
