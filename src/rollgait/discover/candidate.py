"""What may come of a scenario whose gait is to be found: gaits, in the order in which they are tried."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from rollgait.footing.footing import Array
from rollgait.scenario.scenario import Scenario


@dataclass(frozen=True)
class Candidate:
    """A gait that may do.

    Attributes:
        name: what is particular about it, for people.
        score: s; the smaller the sooner it is tried.
        values: dotted keys that make it of the scenario: its gait, its horizon, goals on its way.
    """

    name: str
    score: float
    values: Mapping[str, object] = field(default_factory=dict)

    def of(self, scenario: Scenario) -> Scenario:
        """The scenario with this gait. Raises `InputError` where it does not suit."""
        return scenario.with_values(self.values)

    @property
    def key(self) -> str:
        """Equal for candidates that are the same but for their names."""
        return json.dumps(self.values, sort_keys=True)


STEP_TIME: Final = 0.5
"""What a step counts in the score beside its time, s: who rolls cannot stumble."""
DOUBT: Final = 2.0
"""What any alternative counts in the score, s: what comes as it comes is mostly right."""


def score(horizon: float, steps: int, doubt: float) -> float:
    """Where a candidate stands in the order, s: how long it takes, its steps, and what speaks against it."""
    return horizon + STEP_TIME * steps + doubt


def too_long(horizon: float, longest: float) -> str:
    """What is said where the quickest motion takes longer than allowed, s."""
    return (
        f"no motion found: the quickest one that is known takes {horizon:g} s, the horizon is {longest:g} s"
    )


Proposer = Callable[[Scenario], Iterable[Candidate]]
"""From a scenario that drives, with its reserves, to gaits for it.

Its horizon is the longest allowed. It raises `NotSolvedError` where there is no way, with the place and the
reason, and yields nothing where it does not know this kind of feet or of ground.
"""


def goals_along(poses: Array, times: Sequence[float]) -> dict[str, object]:
    """The goal of a way through poses, as a value of a scenario.

    Args:
        poses: after the start, x, y, yaw, (n, 3), m and rad: the last one is the goal.
        times: when the base passes them, but for the last, (n − 1,), s.
    """
    rows = [
        {"x": round(float(x), 6), "y": round(float(y), 6), "yaw_deg": round(float(np.degrees(yaw)), 6)}
        for x, y, yaw in poses
    ]
    then = [{"at": round(float(at), 6), **row} for at, row in zip(times, rows[1:], strict=True)]
    return {**rows[0], "then": then}
