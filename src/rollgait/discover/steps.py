"""Steps of a gait as a list that can be changed: left out, put in, ordered anew, taken in pairs or singly."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Final

from rollgait.robot.robot import LEG_NAMES, LegName
from rollgait.scenario.gait import PAIR_SWING, BaseGait
from rollgait.scenario.patterns import PATTERNS
from rollgait.scenario.scenario import Scenario

DIGITS: Final = 6
"""Of times, s: so that a sum of slots is written as people write it."""
SINGLE_SWING: Final = 0.8
"""Part of its slot that a foot is in the air where a pair is taken apart."""
ROOM: Final = 0.4
"""Shortest pause into which a further step is put, s."""


@dataclass(frozen=True, order=True)
class Step:
    """Feet that are in the air together.

    Attributes:
        begin: lift-off, s.
        end: touch-down, s.
        legs: whose feet.
    """

    begin: float
    end: float
    legs: tuple[LegName, ...]

    def __str__(self) -> str:
        return f"{'+'.join(self.legs)} at {self.begin:g} s"


Steps = tuple[Step, ...]


def steps_of(scenario: Scenario) -> Steps:
    """The steps of its gait, in the order of their lift-offs."""
    legs: dict[tuple[float, float], tuple[LegName, ...]] = {}
    for leg, swings in scenario.gait.swings(scenario.horizon).items():
        for begin, end in swings:
            time = round(float(begin), DIGITS), round(float(end), DIGITS)
            legs[time] = (*legs.get(time, ()), leg)
    return tuple(sorted(Step(*time, together) for time, together in legs.items()))


def with_steps(scenario: Scenario, steps: Sequence[Step]) -> Scenario:
    """The same scenario with these steps; how wheels and clearances are stays as it is."""
    return scenario.with_values(steps_values(scenario, steps))


def steps_values(scenario: Scenario, steps: Sequence[Step]) -> dict[str, Any]:
    """What these steps set of a scenario."""
    gait: dict[str, Any] = {name: getattr(scenario.gait, name) for name in BaseGait.model_fields}
    gait["kind"] = "schedule" if steps else "drive"
    for step in sorted(steps):
        for leg in step.legs:
            gait.setdefault(leg, []).append([step.begin, step.end])
    return {"gait": gait}


def without(steps: Steps, number: int) -> Steps:
    """All but one."""
    return steps[:number] + steps[number + 1 :]


def one_more(steps: Steps, horizon: float) -> Steps:
    """A further step in the middle of the longest pause, of the foot that has stood longest.

    It takes as long as the others do in the mean. None where there is no room.
    """
    if not steps:
        return ()
    borders = [0.0, *(time for step in steps for time in (step.begin, step.end)), horizon]
    pauses = [(end - begin, begin) for begin, end in zip(borders[::2], borders[1::2], strict=True)]
    length, begin = max(pauses)
    swing = min(sum(step.end - step.begin for step in steps) / len(steps), length - ROOM)
    if swing < ROOM:
        return ()
    before = dict.fromkeys(LEG_NAMES, -1.0)
    for step in steps:
        if step.end <= begin + 1e-9:
            before.update(dict.fromkeys(step.legs, step.end))
    leg = min(LEG_NAMES, key=lambda name: before[name])
    lift_off = round(begin + 0.5 * (length - swing), DIGITS)
    return tuple(sorted((*steps, Step(lift_off, round(lift_off + swing, DIGITS), (leg,)))))


def orders(steps: Steps) -> Iterator[Steps]:
    """The same steps at the same times with other feet: each order of the feet once, the given one left out.

    Each foot steps as often as before, and none twice in a row.
    """
    given = tuple(step.legs for step in steps)
    for legs in _distinct(sorted(given)):
        if legs != given and all(a != b for a, b in pairwise(legs)):
            yield tuple(replace(step, legs=own) for step, own in zip(steps, legs, strict=True))


def _distinct(items: list[tuple[LegName, ...]]) -> Iterator[tuple[tuple[LegName, ...], ...]]:
    """Permutations of things of which some are alike, each once, in lexicographic order."""
    if not items:
        yield ()
    for number, item in enumerate(items):
        if number == 0 or items[number - 1] != item:
            yield from ((item, *rest) for rest in _distinct(items[:number] + items[number + 1 :]))


def in_pairs(steps: Steps) -> Steps:
    """Diagonal pairs in turn in place of single feet, half as many in as long; () if all are in groups."""
    count = (sum(len(step.legs) for step in steps) + 1) // 2
    if not count or all(len(step.legs) > 1 for step in steps):
        return ()
    begin, end = steps[0].begin, max(step.end for step in steps)
    slot = (end - begin) / count
    swing = min(PAIR_SWING * slot, max(step.end - step.begin for step in steps))
    pairs = PATTERNS["trot"].groups
    first = next((k for k, pair in enumerate(pairs) if steps[0].legs[0] in pair), 0)
    middles = [begin + (k + 0.5) * slot for k in range(count)]
    return tuple(
        Step(
            round(middle - 0.5 * swing, DIGITS),
            round(middle + 0.5 * swing, DIGITS),
            pairs[(first + k) % len(pairs)],
        )
        for k, middle in enumerate(middles)
    )


def one_by_one(steps: Steps, horizon: float) -> Steps:
    """Single feet in place of groups, each group in the time up to the next one; () without groups."""
    if all(len(step.legs) == 1 for step in steps):
        return ()
    result = []
    for step, following in zip(steps, (*(s.begin for s in steps[1:]), horizon), strict=True):
        slot = (min(following, 2.0 * step.end - step.begin + 1.0) - step.begin) / len(step.legs)
        for k, leg in enumerate(step.legs):
            begin = step.begin + k * slot
            result.append(Step(round(begin, DIGITS), round(begin + SINGLE_SWING * slot, DIGITS), (leg,)))
    return tuple(sorted(result))
