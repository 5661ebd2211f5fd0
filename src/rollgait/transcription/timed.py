"""The condensed transcription of a problem with times of its own.

The state also tells the time t, the length s of the interval before, and for how long each foot whose swing
has more than one phase has been in the air. The first interval of a phase chooses its length ds, the others
of the phase have the same:

    h = inside · s + ds,   t⁺ = t + h,   s⁺ = h,   a⁺ = clocked · (a + h)

with inside = 0 and ds free at the first interval, 1 and 0 at the others. So the next stage knows all that it
needs, as structure-exploiting solvers want it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Final

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.ocp.instant import Body
from rollgait.ocp.timed import TimedProblem
from rollgait.plan.condensed import CondensedTrajectory
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario.mesh import Mesh
from rollgait.scenario.schedule import ContactSchedule
from rollgait.transcription.code import CodeStore, StageSymbols
from rollgait.transcription.condensed import (
    CARRIED,
    FEET,
    Condensed,
    EndStage,
    Interval,
    IntervalStage,
    Layouts,
    decoded,
    encoded,
    make_layout,
    start_values,
)
from rollgait.transcription.guess import MotionGuess
from rollgait.transcription.nlp import Block, Nlp
from rollgait.transcription.stage import RowNumbers, make_stage

Array = NDArray[np.float64]

UNIT: Final = 0.1
"""s; unit of the lengths of intervals among the variables, so that they are about 1."""
CLOCKS: Final = 2 + FEET
"""t, s, and a of each foot."""
TIME, LENGTH, IN_AIR = 0, 1, slice(2, CLOCKS)
"""Where these stand among the clocks of a node."""
LENGTH_ROWS, TIME_ROWS, SWING_ROWS = "phase_length", "node_time", "swing_time"
"""Names of the rows that limit times."""


@dataclass(frozen=True)
class Timed(Condensed):
    """The transcribed problem; its motions last as long as they like."""

    problem: TimedProblem

    name = "condensed"

    @property
    def layout(self) -> Layouts:
        """Order of the variables."""
        return _layout(self.problem)

    def encode(self, motion: MotionGuess) -> Array:
        """The free variables that come nearest to a motion with the times of the problem's schedule."""
        rows, last = encoded(self.problem, motion)
        clocks, stretch = _clocks(self.problem)
        place = [make_layout(self.problem.robot).last] * CLOCKS
        rows = np.hstack([np.insert(rows, place, clocks[:-1], axis=1), stretch[:, None]])
        return np.concatenate([rows.ravel(), last, clocks[-1]])[self.nlp.free]

    def decode(self, w: Array) -> CondensedTrajectory:
        """The motion that free variables mean."""
        rows = self.layout.rows(self.nlp.all_variables(w), self.problem.schedule.intervals)
        return decoded(self.problem, self.layout, rows, self.lengths(w))

    def lengths(self, w: Array) -> Array:
        """Lengths of the intervals, (N,), s."""
        durations = self.problem.durations
        rows = self.layout.rows(self.nlp.all_variables(w), durations.first.size)
        chosen = rows[:, self.layout.node.size + self.layout.inputs["stretch"].start]
        number = np.maximum.accumulate(np.where(durations.first, np.arange(durations.first.size), 0))
        return np.asarray(UNIT * chosen[number])

    def schedule(self, w: Array) -> ContactSchedule:
        """The contacts at the times that were found."""
        return ContactSchedule(self.problem.schedule.contact, Mesh(self.lengths(w)))


def transcribe(problem: TimedProblem, store: CodeStore | None = None) -> Timed:
    """The problem as an NLP; `store` keeps the code of its stages."""
    layout, count, durations = _layout(problem), problem.schedule.intervals, problem.durations
    first = durations.first
    opening = np.arange(count) == 0
    numbers = {
        "inside": (~first)[None, :].astype(float),
        "opening": opening[None, :].astype(float),
        "clocked": durations.clocked.astype(float),
        "time_price": np.full((1, count), durations.price),
    }
    rows = {
        CARRIED: RowNumbers(holds=np.arange(count) < count - 1),
        LENGTH_ROWS: RowNumbers(*np.where(first, durations.length, 0.0)[:, None] / UNIT),
        TIME_ROWS: RowNumbers(*durations.node_time[:, None]),
    }
    low, high = durations.swing
    for leg, touches_down in enumerate(durations.touches_down):
        rows[f"{SWING_ROWS}_{leg}"] = RowNumbers(low, high, touches_down)
    interval = make_stage(_TimedStage(layout), problem, store, rows, numbers)
    end = make_stage(_TimedEnd(layout), problem, store)
    blocks = [
        Block(interval, layout.variables(count), next_state=layout.defined(interval.code.rows)),
        Block(end, layout.last_variables(count), first=count),
    ]
    initial = start_values(problem, layout, [0.0, 1.0, *[0.0] * FEET])
    return Timed(problem, Nlp(blocks, layout.total(count), initial, again=True))


def _layout(problem: TimedProblem) -> Layouts:
    return make_layout(problem.robot, CLOCKS, 1)


class _TimedInterval(Interval):
    """An interval whose length is a variable."""

    def body_of(self, symbols: StageSymbols) -> Body:
        self.clock = self.node[self.layout.node["clock"]]
        self.stretch = self.u[self.layout.inputs["stretch"]]
        self.next_length = symbols["inside"] * self.clock[LENGTH] + self.stretch
        self.clocked = symbols["clocked"]
        h, opening = UNIT * self.next_length, symbols["opening"]
        before = opening * h + (1.0 - opening) * UNIT * self.clock[LENGTH]
        # costs are integrated over the length that the body says
        symbols.body = replace(symbols.body, interval=h, interval_before=before)
        return symbols.body

    @property
    def in_air(self) -> ca.SX:
        """For how long each foot has been in the air at the end, if a clock times it, 4, s."""
        return ca.SX(self.clock[IN_AIR] + self.body.interval)

    @property
    def next_clock(self) -> ca.SX:
        time = self.clock[TIME] + self.body.interval
        return ca.SX(ca.vertcat(time, self.next_length, self.clocked * self.in_air))


@dataclass(frozen=True)
class _TimedStage(IntervalStage):
    """The stage of an interval whose length is a variable."""

    name: ClassVar[str] = "timed interval"

    def interval(self, symbols: StageSymbols) -> Interval:
        return _TimedInterval(symbols, self.layout)

    def own_rows(self, symbols: StageSymbols, interval: Interval) -> None:
        assert isinstance(interval, _TimedInterval)
        symbols.add_cost("time", symbols["time_price"] * interval.body.interval)
        symbols.add_rows(interval.stretch, LENGTH_ROWS, unit="s")
        symbols.add_rows(interval.next_node[self.layout.node["clock"]][TIME], TIME_ROWS, unit="s")
        for leg in range(len(LEG_NAMES)):
            symbols.add_rows(
                interval.in_air[leg], SWING_ROWS, leg=leg, unit="s", source=f"{SWING_ROWS}_{leg}"
            )


@dataclass(frozen=True)
class _TimedEnd(EndStage):
    """The stage of the end of the horizon, which also has clocks."""

    name: ClassVar[str] = "timed end"


def _clocks(problem: TimedProblem) -> tuple[Array, Array]:
    """What the clocks say at the nodes of the problem's schedule, (N + 1, 6), and ds, (N,)."""
    lengths, durations = problem.schedule.lengths, problem.durations
    clocks = np.zeros((lengths.size + 1, CLOCKS))
    clocks[:, TIME] = problem.schedule.node_times
    clocks[0, LENGTH], clocks[1:, LENGTH] = 1.0, lengths / UNIT
    for k, h in enumerate(lengths):
        clocks[k + 1, IN_AIR] = durations.clocked[:, k] * (clocks[k, IN_AIR] + h)
    return clocks, np.where(durations.first, lengths / UNIT, 0.0)
