"""Gaits over ground that is not flat for feet that cannot roll everywhere there: point feet, fixed wheels.

The ways of the base are those of wheels. Along each the base is carried; its feet step where they must, into
places where they can stand, and where an edge is before them, over it.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any, Final

import numpy as np

from rollgait.discover.candidate import DOUBT, Candidate, goals_along, score, too_long
from rollgait.discover.greedy import StepPace, TooManyStepsError, Walk, walk_values, walked
from rollgait.discover.refusals import between, place, up
from rollgait.discover.ways import Way, ways_of
from rollgait.errors import NotSolvedError
from rollgait.footing.carried import LAND, REACH, STEP, WIDER_REACH, Carried, StuckError
from rollgait.footing.on_terrain import arcs_on
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario.scenario import Scenario

SLOWER: Final = 1.4
"""Times the time of steps on flat ground: they lead over edges."""
OTHER_PACES: Final = (2.0, 1.0)
"""The same of what else is tried."""
GRAIN: Final = 0.01
"""Distance of the places of a track on which feet stand, m, at the most."""
DOUBT_OF_WHEELS: Final = 4.0
"""What these gaits count where no foot is a point: mostly it does to step where the ground asks for it."""


def walking(scenario: Scenario) -> Iterator[Candidate]:
    """The candidates for feet that cannot roll everywhere, on ground that is not flat: the usual ones first.

    Raises:
        NotSolvedError: there is no way over the ground; says where and why.
    """
    if scenario.ground.kind == "flat" or all(leg.foot == "steerable" for leg in scenario.body.leg_list):
        return
    yield from _Walking(scenario).candidates()


class _Walking:
    """The ways of a scenario, and the steps along them."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario, self.ways = scenario, ways_of(scenario)
        self.refusals: list[str] = []

    def candidates(self) -> Iterator[Candidate]:
        """Each way at the usual pace; then at others, and to the side, or turned."""
        ways = self.ways.promising
        usual = sorted((c for way in ways for c in self.paced(way, SLOWER)), key=lambda c: c.score)
        yield from usual
        others = [c for way in ways for slower in OTHER_PACES for c in self.paced(way, slower)]
        others += [c for way in self.ways.aside() for c in self.paced(way, SLOWER)]
        yield from sorted(others, key=lambda c: c.score)
        if not usual and not others:
            raise NotSolvedError(self.refusals[0])

    def paced(self, way: Way, slower: float) -> Iterator[Candidate]:
        """The steps along a way at a pace; none where there are none, or they take too long."""
        try:
            walk = self.walked(way, StepPace.of(self.scenario, slower))
        except TooManyStepsError as error:
            self.refusals.append(f"no way found: it takes {error}")
            return
        except NotSolvedError as error:
            self.refusals.append(str(error))
            return
        values = way_values(self.scenario, walk, way)
        horizon = float(str(values["horizon"]))
        if horizon > self.scenario.horizon + 1e-9:
            self.refusals.append(too_long(horizon, self.scenario.horizon))
            return
        name = way.name or "steps on the straight way"
        name = name if slower == SLOWER else f"{name}, {slower / SLOWER:.2g} × the time"
        doubt = DOUBT * (bool(way.name) + (slower != SLOWER))
        if all(leg.foot != "point" for leg in self.scenario.body.leg_list):
            doubt += DOUBT_OF_WHEELS
        yield Candidate(name, score(horizon, len(walk.steps), doubt), values)

    def walked(self, way: Way, pace: StepPace) -> Walk:
        """A way gone; where a foot gets no farther, with more of the boxes."""
        legs = [np.array(leg) for leg in pairwise(way.poses)]
        stuck: StuckError | None = None
        for reach in (REACH, WIDER_REACH):
            arcs_of = arcs_on(self.ways.regions, self.ways.rise)
            carried = Carried.through(legs, self.scenario, arcs_of, [0.0] * len(legs), reach)
            try:
                return walked(carried, pace)
            except StuckError as error:
                stuck = error
        assert stuck is not None, "it is tried at least once"
        raise NotSolvedError(f"no way found: {_too_far(carried, stuck)}")


def way_values(scenario: Scenario, walk: Walk, way: Way) -> dict[str, Any]:
    """What the steps of a walk along a way set of a scenario."""
    gone = [place for place, _ in walk.trace]
    times = [
        walk.pace.interval * float(np.searchsorted(gone, reached - STEP)) for reached in walk.way.reached[:-1]
    ]
    return {**walk_values(scenario, walk), "goal": goals_along(way.poses[1:], times)}


def _too_far(way: Carried, stuck: StuckError) -> str:
    """The sentence for a foot that gets no farther."""
    leg, own = stuck.leg, way.arcs[stuck.leg]
    here, next_arc = way.nominal[own[way.arc_of(leg, stuck.at), 1], leg], way.arc_of(leg, stuck.at) + 1
    if next_arc == len(own):
        return f"{LEG_NAMES[leg]} gets no farther than {place(here)} m"
    there = way.nominal[own[next_arc, 0], leg]
    most = (1.0 - LAND) * way.box[leg, 1, 0] + way.box[leg, 0, 0]
    missing = max(0.0, float(np.linalg.norm(there - here)) - most) + 2.0 * GRAIN
    return (
        f"no landing between {between(np.array([here, there]))} for {LEG_NAMES[leg]}: "
        f"that is {up(missing):.2f} m more than a step"
    )
