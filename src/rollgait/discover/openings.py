"""Openings that are too narrow: a robot whose feet stood nearer together would pass."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Protocol, Self

import numpy as np

from rollgait.discover.detours import SPACING
from rollgait.discover.refusals import place, up
from rollgait.footing.footing import Array
from rollgait.footing.route import BaseWay
from rollgait.terrain.regions import Regions

NARROWEST: Final = 0.1
"""Of the part of its width that a robot is thought to keep at least."""
GRAIN: Final = 0.01
"""To which the width is found, m."""
ASIDE: Final = 3.0
"""So far to both sides of the base an opening may reach, m."""


class Passed(Protocol):
    """A way that was found."""

    @property
    def base(self) -> BaseWay:
        """Where the base goes."""


class Ways(Protocol):
    """What is asked of the ways of a robot (`discover.ways.Ways`)."""

    @property
    def stance(self) -> Array:
        """Nominal places of the feet, (4, 3), m."""

    @property
    def regions(self) -> Sequence[Regions]:
        """Where each foot may be."""

    @property
    def rise(self) -> float:
        """Highest step, m."""

    def narrower(self, by: float) -> Self:
        """The ways of a robot whose feet stand nearer to its middle by so much (m)."""

    def any_way(self, steps: bool) -> Passed | None:
        """Some way to the goal."""


def opening_refusal(ways: Ways) -> str | None:
    """The sentence for an opening that is too narrow; None if there is none.

    Ground that is wider by twice an amount is passed as it is by a robot whose feet stand nearer to the
    middle by this amount.
    """
    half = float(np.abs(ways.stance[:, 1]).min())
    low, high = 0.0, (1.0 - NARROWEST) * half
    rolling = ways.narrower(high).any_way(steps=False)
    found = rolling or ways.narrower(high).any_way(steps=True)
    if found is None:
        return None
    while high - low > GRAIN:
        middle = 0.5 * (low + high)
        way = ways.narrower(middle).any_way(steps=rolling is None)
        low, high, found = (middle, high, found) if way is None else (low, middle, way)
    at, width = _narrowest(ways, found)
    more = up(2.0 * high + SPACING)  # wherever the opening lies between two places of the grid
    return f"the opening at {place(at)} m is {width:.2f} m wide, {more:.2f} m less than the robot needs"


def _narrowest(ways: Ways, way: Passed) -> tuple[Array, float]:
    """Middle and width of the narrowest place on a way, (2,) and m."""
    pose = way.base.pose
    aside = np.arange(0.0, ASIDE, GRAIN)
    left = np.stack([-np.sin(pose[:, 2]), np.cos(pose[:, 2])], axis=-1)
    terrain = ways.regions[0].terrain
    here = terrain.height(pose[:, 0], pose[:, 1])
    free = []
    for side in (1.0, -1.0):
        places = pose[:, None, :2] + side * aside[:, None] * left[:, None]
        heights = terrain.height(places[..., 0], places[..., 1])
        closed = ~(np.abs(heights - here[:, None]) <= ways.rise)
        free.append(np.where(closed.any(axis=1), aside[np.argmax(closed, axis=1)], ASIDE))
    number = int(np.argmin(free[0] + free[1]))
    middle = pose[number, :2] + 0.5 * (free[0][number] - free[1][number]) * left[number]
    return middle, float(free[0][number] + free[1][number])
