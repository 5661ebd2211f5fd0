"""Phases of a schedule: what lies between two changes of contacts or goals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.ocp.timed import Durations
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario.gait import Schedule, Swing
from rollgait.scenario.mesh import Mesh
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule
from rollgait.scenario.timing import Timing

Array = NDArray[np.float64]

SWING_INTERVALS: Final = 4
"""Of a phase in which a foot swings, while times are sought: an even number has a node in the middle."""
STANCE_INTERVALS: Final = 4
"""The fewest of another phase."""
LONGEST: Final = 0.35
"""s; of an interval while times are sought: longer ones are no motion of the robot any more."""
ROOM, ROOM_PRICED = 2.5, 1.5
"""How many times its share of the horizon a phase without a swing can last at least; the second where the
horizon has a price."""
SAME_TIME: Final = 1e-6
"""s; events that are less apart are one."""


@dataclass(frozen=True)
class Phases:
    """The phases of a schedule.

    Attributes:
        borders: times at which they begin and, at last, end, (P + 1,), s.
        contact: which foot is on the ground in each, (4, P).
        pinned: which borders cannot move but the first, (P,), the ends of phases: goals change there.
    """

    borders: Array
    contact: NDArray[np.bool_]
    pinned: NDArray[np.bool_]

    @classmethod
    def of(cls, scenario: Scenario, schedule: ContactSchedule) -> Phases:
        """Those of a scenario whose contacts change as a schedule says."""
        times = schedule.node_times
        changes = times[:-1][schedule.changes]
        switches = np.array([later.at for later in scenario.goal.then if 0.0 < later.at < times[-1]])
        inner = np.sort(np.concatenate([changes, switches]))
        if inner.size:
            inner = inner[np.append(True, np.diff(inner) > SAME_TIME)]
        borders = np.concatenate([[0.0], inner, [times[-1]]])
        middles = 0.5 * (borders[:-1] + borders[1:])
        contact = schedule.contact[:, schedule.mesh.interval_at(middles)]
        apart = np.abs(borders[1:, None] - switches[None, :]).min(axis=1, initial=np.inf)
        return cls(borders, contact, apart <= SAME_TIME)

    @property
    def count(self) -> int:
        """P."""
        return self.borders.size - 1

    @property
    def lengths(self) -> Array:
        """How long each lasts, (P,), s."""
        return np.diff(self.borders)

    @property
    def swings(self) -> NDArray[np.bool_]:
        """In which a foot swings, (P,)."""
        return np.asarray(~self.contact.all(axis=0))

    def whole_swings(self) -> NDArray[np.bool_]:
        """Which feet in which phases swing from lift-off to touch-down, (4, P)."""
        padded = np.hstack([np.ones((4, 1), dtype=bool), self.contact, np.ones((4, 1), dtype=bool)])
        return np.asarray(~self.contact & padded[:, :-2] & padded[:, 2:])

    def on_mesh(self, counts: NDArray[np.intp]) -> ContactSchedule:
        """The schedule with so many intervals of one length in each phase."""
        lengths = np.repeat(self.lengths / counts, counts)
        return ContactSchedule(np.repeat(self.contact, counts, axis=1), Mesh(lengths))

    def lasting(self, lengths: Array) -> Phases:
        """The same phases with other lengths (P,), s."""
        borders = np.concatenate([[0.0], np.cumsum(lengths)])
        return Phases(borders, self.contact, self.pinned)

    def coarse(self, timing: Timing) -> NDArray[np.intp]:
        """Intervals of each phase while times are sought, (P,): they depend on no time but the horizon."""
        room = ROOM if timing.price is None else ROOM_PRICED
        all_of_it = self.borders[-1] / LONGEST
        stance = max(STANCE_INTERVALS, math.ceil(min(room / self.count, 1.0) * all_of_it))
        return np.where(self.swings, SWING_INTERVALS, stance)

    def fine(self, interval: float) -> NDArray[np.intp]:
        """Intervals of each phase of about a length (s), (P,); even where a foot swings."""
        counts = np.maximum(1, np.round(self.lengths / interval)).astype(np.intp)
        even = 2 * np.maximum(1, np.round(0.5 * self.lengths / interval)).astype(np.intp)
        return np.where(self.swings, even, counts)

    def is_fine(self, timing: Timing, interval: float) -> bool:
        """Whether swings have as many intervals on the mesh of the end as while times were sought.

        Where the horizon has a price, the shortest swing is asked: others are hardly longer.
        """
        if timing.price is not None:
            return bool(SWING_INTERVALS * interval >= timing.swing[0] - SAME_TIME)
        return bool((self.fine(interval)[self.swings] == SWING_INTERVALS).all())

    def durations(
        self,
        timing: Timing,
        counts: NDArray[np.intp],
        interval: float,
        longest_interval: float,
        longest: float,
    ) -> Durations:
        """What limits the times, with so many intervals in each phase.

        Args:
            timing: limits of swings and of what is between them.
            counts: (P,).
            interval: of the mesh on which the motion is planned in the end, s.
            longest_interval: while times are sought, s.
            longest: T, or the largest T if it has a price, s.
        """
        whole = self.whole_swings()
        shortest = np.full(self.count, timing.stance_min)
        longest_phase = np.full(self.count, np.inf)
        shortest[whole.any(axis=0)] = timing.swing[0]
        longest_phase[whole.any(axis=0)] = timing.swing[1]
        length = np.stack([shortest, np.minimum(longest_phase, counts * longest_interval)]) / counts
        ends = np.cumsum(counts) - 1
        node_time = np.full((2, counts.sum()), [[-np.inf], [np.inf]])
        node_time[:, ends[self.pinned]] = self.borders[1:][self.pinned]
        node_time[:, -1] = (0.0 if timing.price is not None else longest), longest
        first = np.zeros(counts.sum(), dtype=bool)
        first[np.concatenate([[0], ends[:-1] + 1])] = True
        return Durations(
            first=first,
            length=np.repeat(length, counts, axis=1),
            node_time=node_time,
            clocked=np.repeat(~self.contact & ~whole, counts, axis=1),
            swing=np.array(timing.swing),
            price=timing.price or 0.0,
            spacing=interval,
        )

    def gait(self, scenario: Scenario, nodes: Array) -> Schedule:
        """The contacts as a gait whose times are given, on a mesh of these nodes (s)."""
        swings: list[tuple[Swing, ...]] = []
        for leg in range(len(LEG_NAMES)):
            padded = np.concatenate([[True], self.contact[leg], [True]]).astype(int)
            edges = np.diff(padded)
            pairs = zip(np.flatnonzero(edges == -1), np.flatnonzero(edges == 1), strict=True)
            swings.append(tuple((float(self.borders[a]), float(self.borders[b])) for a, b in pairs))
        own = scenario.gait
        return Schedule(
            wheels=own.wheels,
            clearance=own.clearance,
            clearance_over=own.clearance_over,
            nodes=tuple(map(float, nodes)),
            FL=swings[0],
            FR=swings[1],
            HL=swings[2],
            HR=swings[3],
        )
