"""Which plans of a data set are for nearly the same: starts for new ones."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.dataset.columns import CERTIFIED
from rollgait.dataset.reading import Reader
from rollgait.errors import InputError
from rollgait.scenario.library import find_scenario
from rollgait.scenario.scenario import Scenario

Array = NDArray[np.float64]

SECONDS_PER_METRE: Final = 10.0
"""A horizon that differs by so much, s, is as far as a metre: a plan is stretched to another one."""
OTHER_GROUND: Final = 1.0
"""Distance of ground of another kind, m."""


@dataclass(frozen=True)
class Index:
    """Certified plans by what they are for.

    Distance is Euclidean: places of start and goal in metres, their yaws in radians, the horizon by
    `SECONDS_PER_METRE`, ground of another kind `OTHER_GROUND`.

    Attributes:
        rows: (n,).
        places: start and goal (x, y, yaw each) and horizon, (n, 7), m and rad.
        labels: robot, gait and kind of ground, (n, 3).
    """

    rows: NDArray[np.int64]
    places: Array
    labels: NDArray[np.str_]

    @classmethod
    def of(cls, dataset: Reader) -> Index:
        """The index of a data set; reads seven columns, not the motions."""
        names = ["status", "robot_name", "gait", "ground", "start", "goal", "horizon"]
        table = dataset.table(names).to_pydict()
        good = [k for k, status in enumerate(table["status"]) if status == CERTIFIED]
        places = [_place(table["start"][k], table["goal"][k], table["horizon"][k]) for k in good]
        labels = [[str(table[name][k]) for name in names[1:4]] for k in good]
        rows = np.array([table["row"][k] for k in good], dtype=np.int64)
        return cls(rows, np.array(places).reshape(-1, 7), np.array(labels, dtype=str).reshape(-1, 3))

    def nearest(self, scenario: Scenario | str, count: int = 1) -> list[tuple[int, float]]:
        """Rows and their distances; see `Dataset.nearest`."""
        if count < 1:
            raise InputError("count", count, "must be at least 1")
        asked = find_scenario(scenario) if isinstance(scenario, str) else scenario
        x, y, _, yaw, *_ = asked.goal_at(np.array([asked.horizon]))[0]
        start = asked.start
        place = _place(
            (start.x, start.y, start.yaw_deg), (float(x), float(y), math.degrees(yaw)), asked.horizon
        )
        robot, gait, ground = self.labels.T
        fits = np.flatnonzero((robot == asked.body.name) & (gait == asked.gait.kind))
        apart = np.linalg.norm(self.places[fits] - place, axis=1)
        apart = np.hypot(apart, np.where(ground[fits] == asked.ground.kind, 0.0, OTHER_GROUND))
        order = np.argsort(apart, kind="stable")[:count]
        return [(int(self.rows[fits[k]]), float(apart[k])) for k in order]


def _place(
    start: tuple[float, float, float], goal: tuple[float, float, float], horizon: float
) -> list[float]:
    """As a row of `Index.places`; yaws in degrees."""
    ends = [value for x, y, yaw in (start, goal) for value in (x, y, math.radians(yaw))]
    return [*ends, horizon / SECONDS_PER_METRE]
