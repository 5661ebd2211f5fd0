"""Where base and feet go over ground that is not flat, before anything is solved.

The base goes from goal to goal; how far it has come is its progress s. A foot's track is its nominal place
below the base at each s. The track lies in regions here and there: its arcs. Each stance is given an arc, in
the order of the track, so that the foot need wait or hurry least; within it the foot rolls as the base goes
on, and waits where the arc ends. How the base goes on follows from its feet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from rollgait.errors import NotSolvedError
from rollgait.footing.footing import FEET, Array
from rollgait.ocp.lift import minimum_jerk
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario.schedule import ContactSchedule
from rollgait.terrain.regions import Regions, arcs

TRACK_STEP: Final = 0.01
"""Distance of the places of a track at which the ground is looked up, m."""
FEWEST: Final = 50
"""Fewest of them between two goals: a turn on the spot has no length."""
ROUNDS: Final = 3
"""How often base and feet are fitted to one another."""
SMOOTH: Final = 0.3
"""Time over which the progress of the base is smoothed, s: a body of this size does not jerk."""


@dataclass(frozen=True)
class Route:
    """Base and feet at times, in the plane.

    Attributes:
        times: (n,), s.
        base: x, y, yaw of the base, (n, 3), m and rad.
        feet: lowest points of the feet, (n, 4, 2), m.
    """

    times: Array
    base: Array
    feet: Array


@dataclass(frozen=True)
class _Way:
    """The way of the base: poses (m, 3) at progress s, (m,)."""

    s: Array
    pose: Array

    @classmethod
    def through(cls, poses: Array, lever: float) -> _Way:
        s, rows = [np.zeros(1)], [poses[:1]]
        for k, (a, b) in enumerate(pairwise(poses)):
            length = np.hypot(b[0] - a[0], b[1] - a[1]) + lever * abs(b[2] - a[2])
            count = max(FEWEST, int(np.ceil(length / TRACK_STEP)))
            share = np.arange(1, count + 1)[:, None] / count
            s.append(k + share[:, 0])
            rows.append(a + share * (b - a))
        return cls(np.concatenate(s), np.vstack(rows))

    def at(self, s: Array) -> Array:
        return np.stack([np.interp(s, self.s, column) for column in self.pose.T], axis=-1)

    def foot(self, s: Array, stance: Array) -> Array:
        """Nominal places (…, 2) of a foot below the base."""
        x, y, yaw = np.moveaxis(self.at(s), -1, 0)
        c, sine = np.cos(yaw), np.sin(yaw)
        return np.stack([x + c * stance[0] - sine * stance[1], y + sine * stance[0] + c * stance[1]], axis=-1)


def find_route(
    times: Array,
    progress: Array,
    poses: Array,
    stance: Array,
    regions: Sequence[Regions],
    schedule: ContactSchedule,
    rolls: Sequence[bool],
) -> Route:
    """The route of a motion.

    Args:
        times: at which it is wanted, (n,), s; the nodes of the schedule among them.
        progress: of the base at these times if nothing were in its way, (n,): k at goal number k.
        poses: start and goals, (x, y, yaw), (g + 1, 3).
        stance: nominal places of the feet, base-yaw frame, (4, 2) or (4, 3), m.
        regions: of the foot of each leg.
        schedule: the contacts.
        rolls: which feet roll: others stand still.

    Raises:
        NotSolvedError: nothing on the track of a foot can be stood on.
    """
    way = _Way.through(poses, float(np.linalg.norm(stance[:, :2], axis=1).max()))
    tracks = [way.foot(way.s, stance[leg]) for leg in range(FEET)]
    own_arcs = [_arcs(regions[leg], tracks[leg], way.s, schedule, leg) for leg in range(FEET)]
    s_base = progress
    s_feet = np.repeat(progress[:, None], FEET, axis=1)
    for _ in range(ROUNDS):
        for leg in range(FEET):
            s_feet[:, leg] = _foot_progress(times, s_base, own_arcs[leg], schedule, leg, rolls[leg])
        s_base = _smoothed(times, s_feet.mean(axis=1), progress[-1])
    feet = np.stack([way.foot(s_feet[:, leg], stance[leg]) for leg in range(FEET)], axis=1)
    return Route(times, way.at(s_base), feet)


def _arcs(regions: Regions, track: Array, s: Array, schedule: ContactSchedule, leg: int) -> Array:
    """Progress at which each arc of a track begins and ends, (m, 2)."""
    labels = regions.label(track)
    if (labels < 0).all() or (labels[0] < 0):
        place = np.round(track[0], 2).tolist()
        raise NotSolvedError(f"no motion found: {LEG_NAMES[leg]} cannot stand at its first place {place} m")
    found = arcs(labels.tolist())
    return np.array([[s[first], s[last]] for _, first, last in found])


def _foot_progress(
    times: Array, s_base: Array, own_arcs: Array, schedule: ContactSchedule, leg: int, rolls: bool
) -> Array:
    """Progress of a foot at times: in an arc while it stands, from one to the next while it swings."""
    nodes = schedule.node_times
    swings = [swing for swing in schedule.swings() if swing.leg == leg]
    borders = [0.0, *(t for w in swings for t in (nodes[w.lift_off], nodes[w.touch_down])), nodes[-1]]
    stances = np.array(borders).reshape(-1, 2)
    wanted = []
    for number, (begin, end) in enumerate(stances):
        inside = (times >= begin - 1e-9) & (times <= end + 1e-9)
        s = s_base[inside]
        if not rolls:
            last = number + 1 == len(stances)
            s = np.full_like(s, 0.0 if number == 0 else s[-1] if last else np.median(s))
        wanted.append((inside, s))
    chosen = _assign([s for _, s in wanted], own_arcs)
    result = np.empty_like(s_base)
    for (inside, s), arc in zip(wanted, chosen, strict=True):
        result[inside] = np.clip(s, *own_arcs[arc])
    for (begin, _), (_, end) in zip(stances[1:], stances[:-1], strict=True):
        air = (times > end + 1e-9) & (times < begin - 1e-9)
        a, b = np.interp([end, begin], times, result)  # the nodes are among the times
        result[air] = a + minimum_jerk((times[air] - end) / (begin - end))[0] * (b - a)
    return result


def _assign(stances: Sequence[Array], own_arcs: Array) -> list[int]:
    """An arc for each stance, in rising order, so that what the progress is clipped by adds up to least."""
    cost = np.array([[np.square(s - np.clip(s, *arc)).sum() for arc in own_arcs] for s in stances])
    best, choice = cost[0].copy(), []
    best[1:] = np.inf  # it stands in the first one now
    for row in cost[1:]:
        before = np.minimum.accumulate(best)
        which = np.array([int(np.argmin(best[: k + 1])) for k in range(len(best))])
        choice.append(which)
        best = before + row
    k = int(np.argmin(best))
    result = [k]
    for which in reversed(choice):
        k = int(which[k])
        result.append(k)
    return result[::-1]


def _smoothed(times: Array, s: Array, end: float) -> Array:
    """Progress of the base that is monotone, smooth, and begins and ends where it should."""
    even = np.linspace(times[0], times[-1], 4 * len(times))
    values = np.interp(even, times, s)
    width = max(1, round(SMOOTH / (even[1] - even[0])))
    kernel = np.hanning(2 * width + 3)[1:-1]
    padded = np.concatenate([np.full(width, values[0]), values, np.full(width, values[-1])])
    smooth = np.convolve(padded, kernel / kernel.sum(), mode="valid")[: len(even)]
    return np.maximum.accumulate(np.interp(times, even, smooth)).clip(0.0, end)
