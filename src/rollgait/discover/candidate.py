"""What may come of a scenario whose gait is to be found: gaits, in the order in which they are tried."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

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
