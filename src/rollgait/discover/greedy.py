"""Steps of feet that cannot do what the motion asks: fixed wheels that must turn or go sideways, point feet.

The base is carried to its goals on flat ground as fast as its feet allow. Each foot rolls as far as it can.
One that would leave its box before its turn comes again steps, one foot at a time, and lands where its
nominal place will be, as late as its box allows; meanwhile the base goes on so far that the others keep until
it is their turn. Feet that have stepped end at their nominal places. No solver is asked.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from rollgait.angles import turned
from rollgait.discover.candidate import Candidate, too_long
from rollgait.errors import NotSolvedError
from rollgait.footing.carried import NOTHING, Carried, Feet, carried_ways
from rollgait.footing.footing import FEET, Array
from rollgait.footing.pace import PEAK
from rollgait.robot.robot import GRAVITY, LEG_NAMES
from rollgait.scenario.gait import BaseGait
from rollgait.scenario.patterns import PATTERNS
from rollgait.scenario.scenario import Scenario

SWING: Final = 2.2
"""Length of a swing in units of √(height / g), s: half a second where the CoM is half a metre high."""
SHIFT: Final = 0.4
"""Time between two swings, in which the base moves over the feet that will stand, in swings."""
FEWEST: Final = 6
"""Intervals of a swing at least, as CENTAURO's have. With four no motion was found for small robots that take
many steps, or one that drives do not follow: they are given its edges rounded over an interval."""
OTHER_PACES: Final = (1.4, 0.8)
"""How much longer than usual, or shorter, all steps take in what else is tried."""
DOUBT_OF_PACE: Final = 20.0
"""What another pace than the usual counts in the score, s: that is tried last."""
SOON: Final = 0.3
"""Feet that must step within this of one another, in parts of the time between two steps, take turns."""
MOST: Final = 400
"""Steps, beyond which a way is given up."""

NARROW: Final = 0.05
"""Half-width of a box, as a share of its length, below which legs do not give way sideways."""

PAIR_PACES: Final = (1.0, 0.7)
"""How long steps of diagonal pairs take, in usual ones: two feet do not hold a robot for longer."""

PAIRED: Final = tuple(
    LEG_NAMES.index(other)
    for name in LEG_NAMES
    for pair in PATTERNS["trot"].groups
    if name in pair
    for other in pair
    if other != name
)
"""The leg across of each."""
CYCLE: Final = tuple(LEG_NAMES.index(name) for name in ("HR", "FR", "HL", "FL"))
"""Turns of feet that must step at the same time: a front foot after the hind one of its side."""


@dataclass(frozen=True)
class StepPace:
    """How steps follow one another, in intervals of the mesh.

    Attributes:
        interval: length of one, s.
        swing: length of a swing.
        shift: between two swings.
    """

    interval: float
    swing: int
    shift: int

    @classmethod
    def of(cls, scenario: Scenario, slower: float = 1.0) -> StepPace:
        """What suits a robot, on the mesh of the scenario if that is fine enough."""
        swing = slower * SWING * float(np.sqrt(scenario.body.height / GRAVITY))
        interval = min(scenario.interval, round(swing / FEWEST, 3))
        count = round(swing / interval)
        return cls(interval, count, max(1, round(SHIFT * count)))


def stepping(scenario: Scenario) -> Iterator[Candidate]:
    """The candidates for feet that cannot roll everywhere, on flat ground: the usual pace first, then others.

    Raises:
        NotSolvedError: they take longer than the horizon allows.
    """
    if scenario.ground.kind != "flat" or all(leg.foot == "steerable" for leg in scenario.body.leg_list):
        return
    ways = carried_ways(scenario)
    shortest = np.inf
    paces = [(slower, False) for slower in (1.0, *OTHER_PACES)]
    paces += [(slower, True) for slower in PAIR_PACES]
    speed = float(scenario.value_of("bounds", "swing_speed_max"))
    acceleration = float(scenario.value_of("bounds", "swing_acceleration_max") or np.inf)
    for number, (slower, in_pairs) in enumerate(paces):
        pace = StepPace.of(scenario, slower)
        found = []
        for way in ways:
            name = "steps on the direct way" if way is ways[-1] else "turns where that takes few steps"
            try:
                walk = walked(way, pace, in_pairs)
            except TooManyStepsError:
                continue
            if in_pairs and not (
                walk.has_pairs and walk.swing_speed <= speed and walk.swing_acceleration <= acceleration
            ):
                continue
            values = walk_values(scenario, walk)
            horizon = float(str(values["horizon"]))
            shortest = min(shortest, horizon)
            if horizon <= scenario.horizon + 1e-9:
                name = f"{name}, diagonal pairs" if in_pairs else name
                name = name if slower == 1.0 else f"{name}, {slower:g} × the time"
                found.append(Candidate(name, horizon + DOUBT_OF_PACE * number, values))
        yield from sorted(found, key=lambda candidate: candidate.score)
    if np.isinf(shortest):
        raise NotSolvedError(f"no way found: each that is known takes more than {MOST} steps{_why(scenario)}")
    if shortest > scenario.horizon + 1e-9:
        raise NotSolvedError(too_long(shortest, scenario.horizon))


def _why(scenario: Scenario) -> str:
    """What of a robot makes so many steps necessary, if that is known."""
    low, high = scenario.body.foot_boxes(scenario.bounds.box).swapaxes(0, 1)
    room = float(np.minimum(-low[:, 1], high[:, 1]).max())
    fixed = all(leg.foot == "fixed" for leg in scenario.body.leg_list)
    if not fixed or room > NARROW * float(np.max(high[:, 0] - low[:, 0])):
        return ""
    return (
        f"; its wheels do not steer and its legs give way sideways by {1e3 * room:.2g} mm only: it goes "
        "straight ahead, and turns by wheels that skid (legs.*.slip_max)"
    )


def greedy_gait(scenario: Scenario, way: Carried | None = None, pace: StepPace | None = None) -> Scenario:
    """The same scenario with the steps that must be taken, on its mesh, and the time that they need.

    Where nothing must step it drives.

    Args:
        scenario: on flat ground.
        way: of the base; the most promising one if not given.
        pace: how steps follow one another; the usual one if not given.

    Raises:
        InputError: the gait does not suit the scenario.
        TooManyStepsError: the way takes more than `MOST` steps.
    """
    way = carried_ways(scenario)[0] if way is None else way
    pace = StepPace.of(scenario) if pace is None else pace
    return scenario.with_values(walk_values(scenario, walked(way, pace)))


def walk_values(scenario: Scenario, walk: Walk) -> dict[str, object]:
    """What the steps of a walk set of a scenario."""
    h = walk.pace.interval
    asked = {
        name: value for name in BaseGait.model_fields if (value := getattr(scenario.gait, name)) is not None
    }
    gait: dict[str, Any] = {"kind": "schedule" if walk.steps else "drive", **asked}
    for leg, lift_off in walk.steps:
        swing = [round(k * h, 6) for k in (lift_off, lift_off + walk.pace.swing)]
        gait.setdefault(LEG_NAMES[leg], []).append(swing)
    return {"gait": gait, "interval": h, "horizon": round(walk.now * h, 6)}


class TooManyStepsError(Exception):
    """A way takes more than `MOST` steps."""


class Walk:
    """A base on its way by steps.

    Attributes:
        in_pairs: whether feet across from one another that both must step do so together.
        steps: leg and lift-off, the latter in intervals, in their order.
        now: in intervals.
        gone: how far the base has come, s of the way.
        longest: of the steps, m.
        trace: at the beginning of each interval: how far it had come then, and where each foot was nominal.
    """

    def __init__(self, way: Carried, pace: StepPace, in_pairs: bool = False) -> None:
        self.way, self.pace, self.feet, self.in_pairs = way, pace, Feet(way), in_pairs
        self.steps: list[tuple[int, int]] = []
        self.now, self.gone, self.longest = 0, 0.0, 0.0
        self.trace: list[tuple[float, tuple[int, ...]]] = []
        aside, turned = float(way.sideways[-1].sum()), float(way.base[-1, 2] - way.base[0, 2])
        to_the_right = (turned if abs(aside) < NOTHING else aside) < 0.0
        self.cycle = CYCLE[2:] + CYCLE[:2] if to_the_right else CYCLE  # mirrored, as the way is

    @property
    def has_pairs(self) -> bool:
        """Whether any feet have stepped together."""
        return len({lift_off for _, lift_off in self.steps}) < len(self.steps)

    @property
    def slot(self) -> float:
        """From one lift-off to the next, s."""
        return (self.pace.swing + self.pace.shift) * self.pace.interval

    def turn(self, leg: int) -> int:
        """How soon it is the turn of a foot among those that must step at the same time."""
        after = 0 if not self.steps else self.cycle.index(self.steps[-1][0]) + 1
        return (self.cycle.index(leg) - after) % FEET

    @property
    def swing_speed(self) -> float:
        """The highest speed of a foot in the air, m/s."""
        return PEAK * self.longest / (self.pace.swing * self.pace.interval)

    @property
    def swing_acceleration(self) -> float:
        """What the longest step takes at least from rest to rest, m/s²."""
        return 4.0 * self.longest / (self.pace.swing * self.pace.interval) ** 2

    def waits(self, legs: Sequence[int]) -> list[int]:
        """How many steps come before that of each of some feet, which step in this order."""
        result, count = dict[int, int](), 0
        for leg in legs:
            if self.in_pairs and PAIRED[leg] in result:
                result[leg] = result[PAIRED[leg]]
            else:
                result[leg], count = count, count + 1
        return [result[leg] for leg in legs]

    def go_on(self, intervals: int, rate: float = 1.0) -> None:
        """Time passes."""
        for _ in range(intervals):
            most = max(self.gone, self.way.open_until(self.now * self.pace.interval))
            self.trace.append((self.gone, tuple(self.feet.at)))
            self.gone = min(self.gone + rate * self.pace.interval, most)
            self.now += 1

    def approach(self, leg: int) -> None:
        """The base goes on as far as a foot needs that steps over an edge next. Raises `StuckError`."""
        needed = self.feet.lands_from(leg, self.gone)
        while self.gone < needed - 1e-9:
            self.go_on(1)

    def step(self, leg: int, others: list[tuple[float, int]], may_join: Collection[int] = ()) -> None:
        """A foot steps while the base goes on as far as the others allow, (until when they keep, leg).

        In pairs the foot across steps with it if it may join.
        """
        legs = [leg, *(other for other in may_join if self.in_pairs and other == PAIRED[leg])]
        others = [each for each in others if each[1] not in legs]
        waits = self.waits([other for _, other in others])
        rates = (
            (keeps - self.gone) / ((k + 1) * self.slot) for k, (keeps, _) in zip(waits, others, strict=True)
        )
        rate = max(0.0, min(1.0, *rates, 1.0))
        self.steps += [(each, self.now) for each in legs]
        before = [self._place(each) for each in legs]
        self.go_on(self.pace.swing, rate)
        for each, place in zip(legs, before, strict=True):
            self.feet.land(each, self.gone)
            self.longest = max(self.longest, float(np.linalg.norm(self._place(each) - place)))
        self.go_on(self.pace.shift, rate)

    def _place(self, leg: int) -> Array:
        """Where a foot is, (2,), m."""
        now = self.way.index(self.gone)
        offset = self.way.offsets(leg, self.feet.at[leg], slice(now, now + 1), self.feet.arc[leg])[0]
        return np.asarray(self.way.nominal[now, leg] + turned(offset, float(self.way.base[now, 2])))


def walked(way: Carried, pace: StepPace, in_pairs: bool = False) -> Walk:
    """A way gone to its end by the steps that must be taken, on flat ground in diagonal pairs if asked.

    Raises:
        TooManyStepsError: these are more than `MOST`.
        StuckError: a foot gets no farther.
    """
    if way.effort > 2 * MOST:  # a step crosses both halves of a box at most
        raise TooManyStepsError
    walk = Walk(way, pace, in_pairs)
    walk.go_on(pace.shift, rate=0.0)
    h = pace.interval
    while len(walk.steps) < MOST:
        keeps = [walk.feet.keeps_until(leg, walk.gone) for leg in range(FEET)]
        must = [(keeps[leg], leg) for leg in range(FEET) if np.isfinite(keeps[leg])]
        must.sort(key=lambda each: (round((each[0] - walk.gone) / (SOON * walk.slot)), walk.turn(each[1])))
        now = walk.now * h
        waits = walk.waits([leg for _, leg in must])
        slack = min(
            (
                way.there_at(at, now, walk.gone) - now - (k + 1) * walk.slot
                for k, (at, _) in zip(waits, must, strict=True)
            ),
            default=np.inf,
        )
        if slack < h:
            if walk.feet.lands_from(must[0][1], walk.gone) > max(walk.gone, min(must)[0]):
                must.sort()  # who must be first, where the turn of another would be beyond an edge
            walk.approach(must[0][1])
            walk.step(must[0][1], must[1:], [leg for _, leg in must])
            continue
        late = [leg for leg in range(FEET) if not walk.feet.is_settled(leg) and not np.isfinite(keeps[leg])]
        settling = [
            (way.there_at(walk.feet.may_settle(leg), now, walk.gone) - now - pace.swing * h, leg)
            for leg in late
        ]
        wait, _, leg = min(((wait, walk.turn(leg), leg) for wait, leg in settling), default=(np.inf, 0, 0))
        if wait < h:
            walk.step(leg, must, [other for wait, other in settling if wait < h])
        elif walk.gone < way.duration - 1e-9:
            walk.go_on(max(1, int(min(wait, slack, walk.slot) / h)))
        else:
            walk.go_on(max(0, int(way.begins[-1] / h) - walk.now) + pace.shift)
            return walk
    raise TooManyStepsError
