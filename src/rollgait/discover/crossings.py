"""Where feet must step: their tracks leave what they can roll on, and go on behind it.

The base goes from pose to pose; s is how far it has come, k at pose number k. A foot's track is its nominal
place below the base at each s. Where one arc of the track ends and the next begins, the foot must swing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rollgait.footing.footing import FEET, Array
from rollgait.footing.route import BaseWay, track_arcs
from rollgait.terrain.regions import Regions


@dataclass(frozen=True)
class Crossing:
    """A place where a foot must step.

    Attributes:
        leg: 0 … 3.
        leaves: progress of the base at which the foot, at its nominal place, can roll no further.
        lands: progress at which it would be at the first place where it can stand again.
        rise: by how much higher that is, m.
    """

    leg: int
    leaves: float
    lands: float
    rise: float = 0.0

    @property
    def middle(self) -> float:
        """Progress half-way."""
        return 0.5 * (self.leaves + self.lands)


def crossings(way: BaseWay, stance: Array, regions: Sequence[Regions], rise_max: float) -> list[Crossing]:
    """All crossings on the way of the base, in the order of their middles.

    Args:
        way: of the base.
        stance: nominal places of the feet, base-yaw frame, (4, 2) or (4, 3), m.
        regions: of the foot of each leg.
        rise_max: highest step, m.
    """
    result = []
    for leg in range(FEET):
        found = track_arcs(regions[leg], way.foot(way.s, stance[leg]), way.s, rise_max)
        for (_, leaves), (lands, _) in pairwise(found):
            ends = way.foot(np.array([leaves, lands]), stance[leg])
            low, high = regions[leg].surface.height(*ends.T)
            result.append(Crossing(leg, float(leaves), float(lands), float(high - low)))
    return sorted(result, key=lambda crossing: crossing.middle)


def lengths(way: BaseWay, lever: float = 0.0) -> Array:
    """How far the base has gone at each place of its way, (m,), m.

    Args:
        way: of the base.
        lever: what a turn of 1 rad counts as, m.
    """
    change = np.abs(np.diff(way.pose, axis=0))
    steps = np.hypot(change[:, 0], change[:, 1]) + lever * change[:, 2]
    return np.concatenate([[0.0], np.cumsum(steps)])
