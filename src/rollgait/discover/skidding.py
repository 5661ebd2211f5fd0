"""Ways of robots on fixed wheels that may slip sideways: they turn by skidding, and drive. No step at all."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise, zip_longest
from typing import Final

import numpy as np

from rollgait.discover.candidate import DOUBT, Candidate, goals_along, score, too_long
from rollgait.errors import NotSolvedError
from rollgait.footing.footing import Array
from rollgait.footing.pace import goal_times, poses_of
from rollgait.footing.skidding import SkidWay, skid_ways, skids
from rollgait.scenario.scenario import Scenario

PAUSE: Final = 2.5
"""At the end, s: wheels come to rest and stick, and a robot with feedback turns to where it should be."""
PACES: Final = (1.0, 1.5)
"""How much longer than usual all takes."""

WEIGHTS: Final = {"goal": 5.0, "force": 0.3}
"""Times the usual weight, where the scenario gives none: a base that is held to its way, on forces that may
change as friction asks for, is found in half the iterations, and where it was not found before."""


def skidding(scenario: Scenario) -> Iterator[Candidate]:
    """The candidates for robots on wheels that may skid, on flat ground: the quickest way first.

    Raises:
        NotSolvedError: they take longer than the horizon allows.
    """
    if not skids(scenario):
        return
    found, shortest = [], np.inf
    for slower in PACES:
        legs: list[list[SkidWay]] = [
            skid_ways(scenario, a, b, slower) for a, b in pairwise(poses_of(scenario))
        ]
        for rank, ways in enumerate(zip_longest(*legs)):
            chosen = [way or own[0] for way, own in zip(ways, legs, strict=True)]
            values, horizon = _values(scenario, chosen)
            shortest = min(shortest, horizon)
            if horizon <= scenario.horizon + 1e-9:
                name = "skids: " + ", then ".join(dict.fromkeys(way.name for way in chosen))
                name = name if slower == 1.0 else f"{name}, {slower:g} × the time"
                doubt = DOUBT * (rank + (slower != 1.0))
                found.append(Candidate(name, score(horizon, 0, doubt), values))
    if not found:
        raise NotSolvedError(too_long(float(shortest), scenario.horizon))
    yield from sorted(found, key=lambda candidate: candidate.score)


def _values(scenario: Scenario, ways: list[SkidWay]) -> tuple[dict[str, object], float]:
    """What ways from goal to goal set of a scenario, and its horizon, s."""
    poses, begins, now = list[Array](), list[float](), 0.0
    for way, begin in zip(ways, goal_times(scenario), strict=True):
        now = max(now, begin)
        poses += list(way.poses[1:])
        begins += [now + float(way.durations[:k].sum()) for k in range(len(way.durations))]
        now += way.duration
    if not poses:  # it is there already
        poses, begins = [ways[0].poses[0]], [0.0]
    interval = scenario.interval
    horizon = round(float(interval * np.ceil((now + PAUSE) / interval - 1e-9)), 6)
    weights: dict[str, object] = {
        f"weights.{name}": round(times * float(scenario.value_of("weights", name)), 9)
        for name, times in WEIGHTS.items()
        if getattr(scenario.weights, name) is None
    }
    return {**weights, "goal": goals_along(np.array(poses), begins[1:]), "horizon": horizon}, horizon
