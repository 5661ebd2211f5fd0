"""Gaits for robots on wheels that can be steered: they roll, and step where their tracks leave the ground.

The straight way is the first that is looked at. Ways around, to the side, and with another yaw of the base
are further ones; each is taken at several paces, and its steps in several orders.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from rollgait.discover.candidate import DOUBT, Candidate, score, too_long
from rollgait.discover.crossings import Crossing, lengths
from rollgait.discover.orders import monotone, other_orders, straying, unevenness
from rollgait.discover.serial import gait_values
from rollgait.discover.timing import Pace, timed
from rollgait.discover.ways import Way, ways_of
from rollgait.errors import NotSolvedError
from rollgait.footing.route import BaseWay
from rollgait.scenario.scenario import Scenario

FLAT_PACE: Final = Pace(speed=0.5)
"""Where nothing is in the way: as fast as a goal is reached without haste."""
SLOWER: Final = 1.4
"""Times the time: what a motion is given that is not found in the usual one."""
FASTEST: Final = 0.6
"""Times the time: no gait is hurried more where the horizon is short."""
UNEVEN: Final = 30.0
"""What it counts in the score that front and hind feet get farther apart in height than a step, s per m."""
BASE_SHIFT: Final = 0.06
"""By so much the base is farther, or less far, at each step where feet are to land elsewhere, m."""
TOGETHER: Final = 0.1
"""Steps at places of the base not farther apart than this are taken at one place, m."""
STRAY: Final = 0.16
"""By so much the base may stray from where its feet want it, m: more is out of their boxes."""


def rolling(scenario: Scenario) -> Iterator[Candidate]:
    """The candidates for a robot on wheels; none where it has point feet, or wheels locked.

    Raises:
        NotSolvedError: there is no way over the ground; says where and why.
    """
    if all(leg.foot == "steerable" for leg in scenario.body.leg_list) or (
        scenario.ground.kind != "flat" and all(leg.foot != "point" for leg in scenario.body.leg_list)
    ):
        yield from _Rolling(scenario).candidates()


class _Rolling:
    """The ways of a scenario, and the gaits along them."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario, self.ways = scenario, ways_of(scenario)
        self.lever = self.ways.lever
        self.too_long: list[float] = []

    def candidates(self) -> Iterator[Candidate]:
        """The straight way and those around, each as it comes; only then what is tried instead."""
        ways = self.ways.promising
        usual = sorted((c for way in ways for c in self.usual(way)), key=lambda c: c.score)
        yield from usual
        others = [c for way in ways for c in (*self.others(way), *self.placed(way))]
        others += [c for way in self.ways.aside() for c in (*self.usual(way), *self.others(way))]
        others += [c for way in self.ways.steered() for c in self.usual(way)]
        yield from sorted(others, key=lambda c: c.score)
        if not usual and not others:
            raise NotSolvedError(too_long(min(self.too_long), self.scenario.horizon))

    # -- gaits -------------------------------------------------------------------------------------------

    def usual(self, way: Way) -> Iterator[Candidate]:
        """The gait along a way, as it comes."""
        yield from self.paced(self.name(way), way, way.steps, self.pace, self.doubt(way))
        if unevenness(way.steps) > self.ways.rise:  # then another order may be more promising
            yield from self.others(way)

    def others(self, way: Way) -> Iterator[Candidate]:
        """Other gaits along a way: slower, its steps in other orders."""
        name, doubt = self.name(way), self.doubt(way) + DOUBT
        yield from self.paced(
            f"{name}, {SLOWER:g} × the time", way, way.steps, self.pace.times(SLOWER), doubt
        )
        length = lengths(way.base, self.lever)
        per_metre = way.base.s[-1] / max(1e-9, float(length[-1]))
        for order in other_orders(way.steps, 0.1 * per_metre):
            stray = straying(order) / per_metre
            if stray <= STRAY:
                more = doubt + DOUBT * stray / STRAY
                yield from self.paced(f"{name}, another order", way, order, self.pace, more)

    def placed(self, way: Way) -> Iterator[Candidate]:
        """Gaits along a way with the base farther at each step, and not as far: so feet land elsewhere."""
        for which, shift in (("farther", BASE_SHIFT), ("less far", -BASE_SHIFT)) if way.steps else ():
            yield from self.shifted(way, f"{which} at each step", shift, self.doubt(way) + 2.0 * DOUBT)

    def shifted(self, way: Way, name: str, shift: float, doubt: float) -> Iterator[Candidate]:
        """A gait whose base is to be farther by a shift, m, at each step: the places are goals on its way."""
        length = lengths(way.base, self.lever)
        middles = np.interp(monotone([step.middle for step in way.steps]), way.base.s, length)
        gone = np.clip(middles + shift, 0.0, length[-1])
        places = np.interp(gone, length, way.base.s)
        plan = timed(way.steps, way.base.s, length, self.pace, places.tolist())
        if plan.horizon > self.scenario.horizon + 1e-9:
            return
        apart = places[np.diff(gone, prepend=-np.inf) > TOGETHER]
        s = np.round(np.append(np.arange(len(way.poses), dtype=float), apart), 6)
        poses = way.base.at(np.unique(s).astype(float))
        base = BaseWay.through(poses, self.lever)
        values = gait_values(base, poses, way.steps, plan, self.scenario.gait, self.lever)
        place = score(float(plan.horizon), len(way.steps), doubt)
        yield Candidate(f"{self.name(way)}, {name}", place, values)

    @property
    def pace(self) -> Pace:
        return FLAT_PACE if self.ways.flat else Pace()

    def name(self, way: Way) -> str:
        return way.name or ("as it comes" if way.steps else "driving")

    def doubt(self, way: Way) -> float:
        if not way.name or not way.steps:
            return 0.0
        straight = self.ways.straight
        is_alike = isinstance(straight, Way) and way.is_alike(straight)
        return 2.0 * DOUBT if is_alike else DOUBT  # what fails here fails there

    def paced(
        self, name: str, way: Way, steps: Sequence[Crossing], pace: Pace, doubt: float
    ) -> Iterator[Candidate]:
        """A gait, hurried where the horizon asks for it; none where it would have to be hurried too much."""
        length = lengths(way.base, self.lever)
        places = [float(p) for p in monotone([step.middle for step in steps])]
        plan = timed(steps, way.base.s, length, pace, places)
        if plan.horizon > self.scenario.horizon + 1e-9:
            factor = (self.scenario.horizon - 0.1) / plan.horizon
            hurried = timed(steps, way.base.s, length, pace.times(max(factor, FASTEST)), places)
            if hurried.horizon > self.scenario.horizon + 1e-9:
                self.too_long.append(hurried.horizon)
                return
            name, plan = f"{name}, hurried", hurried
        values = gait_values(way.base, way.poses, steps, plan, self.scenario.gait, self.lever)
        doubt += UNEVEN * max(0.0, unevenness(steps) - self.ways.rise)
        yield Candidate(name, score(float(plan.horizon), len(steps), doubt), values)
