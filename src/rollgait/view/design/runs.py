"""What was solved or opened since the page began, and how two of them compare."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from rollgait.plan.plan import Plan
from rollgait.plan.work import mechanical_work
from rollgait.scenario.scenario import Scenario
from rollgait.view.clip import Clip
from rollgait.view.panels.motion import brief

RUNS_MAX: Final = 20
"""Runs that are kept: the oldest goes first."""


@dataclass(frozen=True)
class Run:
    """A motion.

    Attributes:
        name: that tells it from the others.
        clip: what is shown of it.
        asked: the scenario that was asked for; None if the file does not say it.
    """

    name: str
    clip: Clip
    asked: Scenario | None


class Runs:
    """The runs, in the order in which they came."""

    def __init__(self) -> None:
        self._runs: list[Run] = []
        self._count = 0

    def __iter__(self) -> Any:
        return iter(self._runs)

    def __len__(self) -> int:
        return len(self._runs)

    def add(self, clip: Clip, asked: Scenario | None) -> Run:
        """Keeps a run; its name is its number and what a person calls it."""
        self._count += 1
        run = Run(f"{self._count}  {clip.name}", clip, asked)
        self._runs = [*self._runs, run][-RUNS_MAX:]
        return run

    def replace(self, old: Clip, new: Clip) -> None:
        """The same run with more known of it."""
        self._runs = [Run(run.name, new, run.asked) if run.clip is old else run for run in self._runs]

    def remove(self, run: Run) -> None:
        """Forgets a run."""
        self._runs = [each for each in self._runs if each is not run]

    def of(self, clip: Clip | None) -> Run | None:
        """The run of which a clip is."""
        return next((run for run in self._runs if run.clip is clip), None)

    def named(self, name: str) -> Run | None:
        """The run of this name."""
        return next((run for run in self._runs if run.name == name), None)


def figures(clip: Clip) -> dict[str, str]:
    """What a motion is like, in rows that compare. m, s, N, J."""
    s = clip.samples
    way = float(np.linalg.norm(np.diff(s.com_position, axis=0), axis=1).sum())
    rows = {
        "verdict": brief(clip.verdict),
        "time": f"{clip.horizon:.4g} s",
        "way of the CoM": f"{way:.3g} m",
        "largest speed": f"{np.linalg.norm(s.com_velocity, axis=1).max():.3g} m/s",
        "smallest normal force": f"{_smallest_force(clip):.3g} N",
    }
    return rows if clip.plan is None else {**rows, **_figures_of_plan(clip.plan)}


def _figures_of_plan(plan: Plan) -> dict[str, str]:
    rows = plan.certificate().rows
    judged = [row for row in rows if row.limit is not None and row.verdict != "not promised"]
    nearest = max(judged, key=lambda row: row.nearness, default=None)
    return {
        "gait": plan.scenario.gait.kind,
        "steps": str(sum(1 for _ in plan.schedule.swings())),
        "cost": f"{plan.statistics.cost:.4g}",
        "mechanical work": f"{mechanical_work(plan):.3g} J",
        "nearest to its limit": "–" if nearest is None else f"{nearest.name} {nearest.leg or ''}".strip(),
        "solved in": f"{plan.statistics.solve_time:.2g} s",
    }


def _smallest_force(clip: Clip) -> float:
    """Of the feet that stand, N."""
    normal = clip.samples.force[..., 2][clip.samples.contact]
    return float(normal.min()) if normal.size else 0.0


def differences(first: Scenario, second: Scenario) -> dict[str, tuple[str, str]]:
    """Which keys of two scenarios differ, with both values; "–" where one says nothing."""
    one, other = _flat(first.to_brief_dict()), _flat(second.to_brief_dict())
    keys = [*one, *(key for key in other if key not in one)]
    return {key: (one.get(key, "–"), other.get(key, "–")) for key in keys if one.get(key) != other.get(key)}


def _flat(data: Any, prefix: str = "") -> dict[str, str]:
    """Nested data by their dotted keys."""
    if isinstance(data, dict):
        items: Any = data.items()
    elif isinstance(data, list) and any(isinstance(each, dict) for each in data):
        items = enumerate(data)
    else:
        return {} if data is None else {prefix: f"{data:.6g}" if isinstance(data, float) else str(data)}
    found: dict[str, str] = {}
    for key, value in items:
        found |= _flat(value, f"{prefix}.{key}" if prefix else str(key))
    return found
