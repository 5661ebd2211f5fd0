"""Random grounds and places on them."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from rollgait.terrain import Terrain

Array = NDArray[np.float64]

RADIUS = 0.124
"""m: the wheel of centauro."""


def rounded(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high).map(lambda value: round(value, 4))


def heights() -> st.SearchStrategy[float]:
    return rounded(0.02, 0.3).flatmap(lambda h: st.sampled_from([h, -h]))


def placed(kind: str, **sizes: st.SearchStrategy[Any]) -> st.SearchStrategy[dict[str, Any]]:
    place = {"x": rounded(-1.0, 1.0), "y": rounded(-1.0, 1.0), "yaw_deg": rounded(-180.0, 180.0)}
    return st.fixed_dictionaries({"kind": st.just(kind), **place, **sizes})


lengths = rounded(0.2, 1.5)
widths = st.none() | lengths
parts = st.one_of(
    placed("ramp", length=lengths, width=lengths, slope_deg=rounded(2.0, 30.0)),
    placed("step", height=heights(), width=widths),
    placed("stairs", steps=st.integers(1, 4), rise=heights(), tread=rounded(0.2, 0.5), width=widths),
    placed("gap", length=rounded(0.05, 0.5), width=widths),
    placed("block", length=lengths, width=lengths, height=heights()),
)
worlds = st.lists(parts, min_size=1, max_size=3).map(Terrain.from_parts)
seeds = st.integers(0, 2**32 - 1)


def places(seed: int, count: int = 200, half: float = 1.5) -> Array:
    return np.random.default_rng(seed).uniform(-half, half, (count, 2))


def turned(points: Array, yaw: float) -> Array:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.asarray(points @ np.array([[c, s], [-s, c]]))


def ball(radius: float, count: int = 60) -> Array:
    """Offsets from the centre of a ball to columns that fill its shadow, (n, 2)."""
    steps = np.linspace(-radius, radius, count)
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    return np.asarray(grid[np.linalg.norm(grid, axis=1) < radius])
