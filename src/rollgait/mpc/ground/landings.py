"""Swings over ground that is not level: where each begins and lands, and how high it goes between."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.mpc.clock import GaitClock, TimedSwing
from rollgait.mpc.ground.around import GroundAround
from rollgait.mpc.ground.raster import HEIGHT, STEP_ROOM

Array = NDArray[np.float64]

STICKY: Final = 0.06
"""A foothold that was chosen stays unless another one is nearer to what is wanted by so much, m."""
RELEASED: Final = 0.03
"""It is given up when what is wanted is so far inside of what is allowed, m."""
SETTLED: Final = 0.5
"""From this share of a swing on, its foothold stays whatever happens."""
PROBES: Final = 9
"""Places on the way of a swing at which the ground is looked at."""
_SAME: Final = 1e-6
"""Swings whose lift-offs differ by less are one, s."""


@dataclass
class Landing:
    """A swing of the horizon.

    Attributes:
        lift_off: when it begins, s: tells swings of one leg apart.
        begin: where the foot leaves the ground, (3,), m.
        place: where it is to land, (2,), m.
        chosen: foothold in place of the nominal one, which is forbidden; None if it is not.
        side: from the nominal place to the chosen one, a unit vector.
        top: highest surface on its way, m.
        end: height of the surface where it lands, m.
    """

    lift_off: float
    begin: Array
    place: Array
    side: Array
    chosen: Array | None = None
    top: float = 0.0
    end: float = 0.0

    def profile(self, swing: TimedSwing, times: Array) -> tuple[Array, Array]:
        """z of the foot and its rate at times within the swing, (n,), m and m/s."""
        return swing.over(times, float(self.begin[2]), self.top, self.end)


class Landings:
    """Remembers what was decided about the next swing of each leg.

    Args:
        around: the ground.
    """

    def __init__(self, around: GroundAround) -> None:
        self._around = around
        self._next: dict[int, Landing] = {}
        self._stood: Array = np.zeros((4, 3))

    def begin(self, feet: Array) -> None:
        """Forgets all swings; the feet (4, 3) stand."""
        self._next.clear()
        self._stood = feet.copy()

    def stand(self, contact: NDArray[np.bool_], feet: Array) -> None:
        """Notes where feet (4, 3) stand that are on the ground."""
        self._stood[contact] = feet[contact]

    def of(self, swing: TimedSwing) -> Landing | None:
        """What was decided about a swing; None if nothing was."""
        known = self._next.get(swing.leg)
        return known if known is not None and abs(known.lift_off - swing.lift_off) < _SAME else None

    def update(
        self, clock: GaitClock, time: float, interval: float, xy: Array, wanted: Array
    ) -> list[tuple[TimedSwing, Landing]]:
        """The swings of the horizon in the order of time, and where they begin and land.

        Args:
            clock: which foot is in the air when.
            time: of the first node, s.
            interval: between nodes, s.
            xy: places of the feet at the nodes, (N + 1, 4, 2), m.
            wanted: nominal places, as `xy`.
        """
        end = time + interval * (xy.shape[0] - 1)
        result: list[tuple[TimedSwing, Landing]] = []
        first: dict[int, Landing] = {}
        for swing in sorted(clock.swings(time, end), key=lambda one: one.lift_off):
            leg, raster = swing.leg, self._around.of(swing.leg)
            landing, under_way = self.of(swing), swing.lift_off <= time
            if landing is None:
                landing = Landing(swing.lift_off, self._stood[leg].copy(), xy[0, leg], np.zeros(2))
            if not under_way:
                place = between(xy[:, leg], (swing.lift_off - time) / interval)
                landing.begin = np.array([*place, raster.look(place)[HEIGHT]])
            share = (swing.touch_down - time) / interval
            passed = (time - swing.lift_off) / (swing.touch_down - swing.lift_off)
            place, given = between(xy[:, leg], share), swing.foothold
            if given is None:
                self._decide(landing, leg, passed, place, between(wanted[:, leg], share))
            else:
                landing.place = given
            self._look(landing, leg, passed, place)
            first.setdefault(leg, landing)
            result.append((swing, landing))
        self._next = first
        return result

    def _decide(self, landing: Landing, leg: int, passed: float, place: Array, nominal: Array) -> None:
        """Where a swing lands: at `place`, as the last solution has it, or at the nearest allowed place.

        Args:
            landing: what was decided before; changed.
            leg: 0 … 3.
            passed: share of the swing that is over; negative before it.
            place: where the last solution lands, (2,), m.
            nominal: where it is wanted, (2,), m.
        """
        raster = self._around.of(leg)
        if passed < SETTLED:
            room = float(raster.look(nominal)[STEP_ROOM])
            old, new = landing.chosen, None
            if room < 0.0:
                new = raster.nearest_foothold(nominal)
                if old is not None and _distance(old, nominal) < _distance(new, nominal) + STICKY:
                    new = old
            elif old is not None and room < RELEASED:
                new = old
            if new is not None and new is not old:
                landing.side = (new - nominal) / max(_distance(new, nominal), _SAME)
            landing.chosen = new
        landing.place = place if landing.chosen is None else landing.chosen

    def _look(self, landing: Landing, leg: int, passed: float, place: Array) -> None:
        """Looks at the ground on the way of a swing and where it lands; arguments as those of `_decide`."""
        raster = self._around.of(leg)
        way = landing.begin[:2] + np.linspace(0.0, 1.0, PROBES)[:, None] * (landing.place - landing.begin[:2])
        heights = raster.look(np.vstack([way, place]))[:, HEIGHT]
        landing.top = float(max(heights[:-1].max(), landing.begin[2]))
        # near its end it comes down where it is, though it may still be drawn elsewhere
        landing.end = float(heights[-1] if passed > SETTLED else heights[-2])


def between(rows: Array, place: float) -> Array:
    """A row between two, counted in rows; the first or last beyond the ends."""
    k = int(np.clip(np.floor(place), 0, len(rows) - 2))
    share = float(np.clip(place - k, 0.0, 1.0))
    return np.asarray((1.0 - share) * rows[k] + share * rows[k + 1])


def _distance(a: Array, b: Array) -> float:
    return float(np.hypot(*(a - b)))
