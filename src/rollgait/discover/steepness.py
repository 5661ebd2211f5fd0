"""Flights of steps: how far front feet get above or below hind feet, and by how much treads are too short."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from rollgait.discover.crossings import Crossing, lengths
from rollgait.discover.orders import other_orders, unevenness
from rollgait.discover.refusals import EDGE
from rollgait.footing.footing import FEET, Array
from rollgait.footing.route import BaseWay
from rollgait.terrain.regions import Regions

STEEP: Final = 0.63
"""So far front feet get above or below hind feet, a step among it, in heights of the CoM: CENTAURO climbs
four stairs of 0.15 m with treads of 0.32 m, and of 0.12 m with 0.20 m, and neither with 0.30 m nor 0.18 m
with 0.36 m."""
GRAIN: Final = 0.01
"""By which treads are made longer until they are long enough, m."""
RESERVE: Final = 0.02
"""What they are longer then, m: steps are ordered by places that are looked up every centimetre."""
LONGEST: Final = 100
"""How often: a tread of a metre more is longer than any robot needs."""
NEAR: Final = 0.1
"""Steps nearer to one another than this may change places in the order, m."""


def lacking(way: BaseWay, stance: Array, regions: Sequence[Regions], rise_max: float, height: float) -> float:
    """By how much treads on a way are too short for the robot as a whole, m, wherever its feet can stand.

    Args:
        way: of the base.
        stance: nominal places of the feet, base-yaw frame, (4, 2) or (4, 3), m.
        regions: of the foot of each leg.
        rise_max: highest step, m: what rises or falls by more is no stair.
        height: of the CoM over the ground, m.
    """
    edges = []
    length = lengths(way)
    for leg in range(FEET):
        rise = np.nan_to_num(np.diff(regions[leg].terrain.height(*way.foot(way.s, stance[leg]).T)))
        jumps = np.flatnonzero(np.abs(rise) > EDGE)
        for run in np.split(jumps, np.flatnonzero(np.diff(jumps) > 1) + 1):
            total = float(rise[run].sum())
            if len(run) and abs(total) <= rise_max:
                edges.append(_at(Crossing(leg, 0.0, 0.0, total), float(length[run].mean())))
    return _lacking(edges, height)


def _at(step: Crossing, length: float) -> Crossing:
    return replace(step, leaves=length, lands=length)


def _lacking(edges: Sequence[Crossing], height: float) -> float:
    for times in range(LONGEST):
        if _least(_stretched(edges, times * GRAIN)) <= STEEP * height:
            return times * GRAIN + RESERVE if times else 0.0
    return 0.0


def _stretched(edges: Sequence[Crossing], more: float) -> list[Crossing]:
    """The same edges (at lengths, m), each of a leg farther from the one before it."""
    result = []
    for leg in range(FEET):
        own = sorted((edge for edge in edges if edge.leg == leg), key=lambda edge: edge.middle)
        result += [_at(edge, edge.middle + number * more) for number, edge in enumerate(own)]
    return result


def _least(edges: Sequence[Crossing]) -> float:
    """How far front feet get above or below hind feet in the best order that is tried, a step among it, m."""
    usual = sorted(edges, key=lambda edge: edge.middle)
    step = max((abs(edge.rise) for edge in usual), default=0.0)
    return min(unevenness(order) for order in (usual, *other_orders(usual, NEAR))) + step
