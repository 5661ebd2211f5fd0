"""Maps as sensors give them: cells of 4 cm, noise of 1 cm, holes, nothing under the robot."""

from __future__ import annotations

from typing import Final

import numpy as np

from rollgait.terrain import Block, Gap, Ramp, Step, Terrain
from tests.terrain.worlds import Array

CELL: Final = 0.04
SIGMA: Final = 0.01
MISSING: Final = 0.05
HALF: Final = 2.0
"""m: the maps reach from −HALF to HALF in both directions."""
STANDS: Final = np.array([-1.0, 0.0])
"""Where the robot stands that made the map."""
HIDES: Final = np.array([0.35, 0.25])
"""m: half the sides of what it hides."""


def _bumps() -> Terrain:
    x = np.arange(-1.1 * HALF, 1.1 * HALF, 0.01)
    z = 0.015 * np.sin(2.0 * np.pi * x[:, None] / 0.8) * np.cos(2.0 * np.pi * x[None] / 0.9)
    return Terrain.from_map(z, 0.01, (x[0], x[0]))


RISE = float(1.5 * np.tan(np.radians(15.0)))
WORLDS: Final = {
    "step": Terrain.from_parts([Step(x=0.31, height=0.15)]),
    "ramp": Terrain.from_parts([Ramp(x=0.3, length=1.5, slope_deg=15.0), Step(x=1.8, height=RISE)]),
    "gap": Terrain.from_parts([Gap(x=0.5, length=0.3)]),
    "bumps": _bumps(),
    "kerb": Terrain.from_parts([Block(x=1.2, y=0.8, yaw_deg=12.0, length=3.0, width=1.0, height=0.1)]),
}


def measured(world: Terrain, seed: int, hidden: bool = True) -> tuple[Array, Array, Array]:
    """Coordinate of the nodes (n,) in x and in y, true heights (n, n), and those that the sensor gives, m.

    Where the nodes lie over the world's edges differs with the seed.
    """
    rng = np.random.default_rng(seed)
    x = rng.uniform(-0.5, 0.5) * CELL + np.arange(-HALF, HALF + 1e-9, CELL)
    truth = world.height(x[:, None], x[None])
    given = truth + SIGMA * rng.standard_normal(truth.shape)
    given[rng.random(truth.shape) < MISSING] = np.nan
    if hidden:
        along, across = np.abs(x - STANDS[0]) < HIDES[0], np.abs(x - STANDS[1]) < HIDES[1]
        given[along[:, None] & across[None]] = np.nan
    return x, truth, given
