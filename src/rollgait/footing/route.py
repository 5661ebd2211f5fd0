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
from rollgait.robot.robot import LEG_NAMES, turn_lever
from rollgait.scenario.schedule import ContactSchedule
from rollgait.terrain.regions import Regions, arcs

TRACK_STEP: Final = 0.01
"""Distance of the places of a track at which the ground is looked up, m."""
FEWEST: Final = 50
"""Fewest of them between two goals: a turn on the spot has no length."""
BESIDE: Final = 1.5
"""Arcs no farther apart than this, in steps of the track, have nothing between them."""
ROUNDS: Final = 3
"""How often base and feet are fitted to one another."""
SKIPPING: Final = 1.0
"""What it costs to step over an arc, in squares of progress: more than to wait for the foot."""
SKIPPED_AT_MOST: Final = 1
"""Arcs that one step may lead over."""
SMOOTH: Final = 0.3
"""Time over which the progress of the base is smoothed, s: a body of this size does not jerk."""
FITTING: Final = 40
"""How often it is moved between what its feet want, and smoothed again: enough for both to agree."""


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
class BaseWay:
    """The way of the base: poses (x, y, yaw), (m, 3), at progress s, (m,)."""

    s: Array
    pose: Array

    @classmethod
    def through(cls, poses: Array, lever: float) -> BaseWay:
        """Straight from pose to pose.

        Args:
            poses: start and goals, (g + 1, 3), m and rad.
            lever: what a turn of 1 rad counts as, m.
        """
        s, rows = [np.zeros(1)], [poses[:1]]
        for k, (a, b) in enumerate(pairwise(poses)):
            length = np.hypot(b[0] - a[0], b[1] - a[1]) + lever * abs(b[2] - a[2])
            count = max(FEWEST, int(np.ceil(length / TRACK_STEP)))
            share = np.arange(1, count + 1)[:, None] / count
            s.append(k + share[:, 0])
            rows.append(a + share * (b - a))
        return cls(np.concatenate(s), np.vstack(rows))

    def at(self, s: Array) -> Array:
        """Poses at progress s, (…, 3)."""
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
    rise_max: float,
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
        rise_max: highest step, m.

    Raises:
        NotSolvedError: nothing on the track of a foot can be stood on.
    """
    way = BaseWay.through(poses, turn_lever(stance))
    tracks = [way.foot(way.s, stance[leg]) for leg in range(FEET)]
    own_arcs = []
    for leg, (region, track) in enumerate(zip(regions, tracks, strict=True)):
        own_arcs.append(track_arcs(region, track, way.s, rise_max))
        if not len(own_arcs[-1]):
            place = np.round(track[0], 2).tolist()
            raise NotSolvedError(
                f"no motion found: {LEG_NAMES[leg]} cannot stand at its first place {place} m"
            )
        _require_a_way(leg, own_arcs[-1], track, way.s, schedule)
    s_base = progress
    s_feet = np.repeat(progress[:, None], FEET, axis=1)
    for _ in range(ROUNDS):
        low, high = np.full_like(times, 0.0), np.full_like(times, progress[-1])
        for leg in range(FEET):
            s_feet[:, leg], window = _foot_progress(
                times, s_base, own_arcs[leg], schedule, leg, rolls[leg], BESIDE * float(np.diff(way.s).max())
            )
            low, high = np.maximum(low, window[0]), np.minimum(high, window[1])
        if (low == 0.0).all() and (high == progress[-1]).all():
            break  # nothing is in the way
        s_base = _within(times, s_base, low, high, progress[-1])
    feet = np.stack([way.foot(s_feet[:, leg], stance[leg]) for leg in range(FEET)], axis=1)
    return Route(times, way.at(s_base), feet)


def _require_a_way(leg: int, own_arcs: Array, track: Array, s: Array, schedule: ContactSchedule) -> None:
    """Raises `NotSolvedError` where the foot cannot get to the goal: for want of ground, or of steps."""
    name = LEG_NAMES[leg]
    if own_arcs[-1, 1] < s[-1] - 1e-9:
        place = _place(track, s, own_arcs[-1, 1])
        raise NotSolvedError(
            f"no motion found: {name} gets as far as {place} m; beyond, there is nothing on its way that it "
            "could step to, as high or low as a leg can"
        )
    steps = sum(swing.leg == leg for swing in schedule.swings())
    if steps + 1 < len(own_arcs) and not _reaches(own_arcs, steps):
        place = _place(track, s, own_arcs[steps, 1])
        raise NotSolvedError(
            f"no motion found: {name} cannot roll on from {place} m; the gait has {steps} steps of it, "
            f"its way needs {len(own_arcs) - 1}"
        )


def _place(track: Array, s: Array, at: float) -> list[float]:
    return [round(float(np.interp(at, s, column)), 2) for column in track.T]


def _reaches(own_arcs: Array, steps: int) -> bool:
    """Whether some steps may lead over several arcs at a time."""
    return steps > 0 and len(own_arcs) <= (SKIPPED_AT_MOST + 1) * steps + 1


def track_arcs(regions: Regions, track: Array, s: Array, rise_max: float) -> Array:
    """Progress at which each arc of a track begins and ends, (m, 2): of those that a foot can step to.

    Args:
        regions: of the foot.
        track: its places, (n, 2), m.
        s: progress there, (n,).
        rise_max: by how much higher or lower than the arc before one may lie, m: the floor of a ditch is no
            foothold.
    """
    found = arcs(regions.label(track).tolist())
    if not found or found[0][1] > 0:
        return np.zeros((0, 2))
    kept = [found[0][1:]]
    for _, first, last in found[1:]:
        ends = regions.surface.height(*track[[kept[-1][1], first]].T)
        if abs(ends[1] - ends[0]) <= rise_max:
            kept.append((first, last))
    return np.array([[s[first], s[last]] for first, last in kept])


def _foot_progress(
    times: Array,
    s_base: Array,
    own_arcs: Array,
    schedule: ContactSchedule,
    leg: int,
    rolls: bool,
    gap: float,
) -> tuple[Array, Array]:
    """Progress of a foot at times, and between which values that of the base would suit it, (n,) and (2, n).

    It is in an arc while the foot stands, and goes from one to the next while it swings. Arcs no farther
    apart than `gap` follow one another directly.
    """
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
    window = np.stack([np.full_like(s_base, 0.0), np.full_like(s_base, own_arcs[-1, 1])])
    for (inside, s), arc in zip(wanted, chosen, strict=True):
        result[inside] = np.clip(s, *own_arcs[arc])
        run = _run(own_arcs, arc, gap)
        low = 0.0 if run[0] == 0 else own_arcs[run[0], 0]
        high = np.inf if run[1] == len(own_arcs) - 1 else own_arcs[run[1], 1]
        window[:, inside] = np.array([[low], [high]])
    for (begin, _), (_, end) in zip(stances[1:], stances[:-1], strict=True):
        air = (times > end + 1e-9) & (times < begin - 1e-9)
        a, b = np.interp([end, begin], times, result)  # the nodes are among the times
        result[air] = a + minimum_jerk((times[air] - end) / (begin - end))[0] * (b - a)
    return result, window


def _run(own_arcs: Array, arc: int, gap: float) -> tuple[int, int]:
    """First and last of the arcs about one between which there is nothing: a kink keeps no base waiting."""
    first = last = arc
    while first > 0 and own_arcs[first, 0] - own_arcs[first - 1, 1] <= gap:
        first -= 1
    while last + 1 < len(own_arcs) and own_arcs[last + 1, 0] - own_arcs[last, 1] <= gap:
        last += 1
    return first, last


def _assign(stances: Sequence[Array], own_arcs: Array) -> list[int]:
    """An arc for each stance, in rising order, so that what the progress is clipped by adds up to least.

    The first stance is in the first arc, the last one in the last, as far as there are stances.
    """
    cost = np.array([[np.square(s - np.clip(s, *arc)).mean() for arc in own_arcs] for s in stances])
    number = np.arange(len(own_arcs))
    skipped = np.maximum(number[:, None] - number - 1, 0)  # rows: to, columns: from
    step = np.where(number[:, None] >= number, SKIPPING * skipped, np.inf)
    best, choice = cost[0].copy(), []
    best[1:] = np.inf  # it stands in the first one now
    for row in cost[1:]:
        total = best + step
        choice.append(np.argmin(total, axis=1))
        best = total.min(axis=1) + row
    reached = np.isfinite(best)
    last = len(own_arcs) - 1  # the goal is in the last one
    k = last if reached[last] else int(np.flatnonzero(reached)[-1])
    result = [k]
    for which in reversed(choice):
        k = int(which[k])
        result.append(k)
    return result[::-1]


def _within(times: Array, s: Array, low: Array, high: Array, end: float) -> Array:
    """Progress that keeps between two curves, as far as it can, and is monotone and smooth."""
    middle, crossed = 0.5 * (low + high), low > high
    low, high = np.where(crossed, middle, low), np.where(crossed, middle, high)
    even = np.linspace(times[0], times[-1], len(times))
    value, least, most = (np.interp(even, times, curve) for curve in (s, low, high))
    width = max(1, round(SMOOTH / (even[1] - even[0])))
    kernel = np.hanning(2 * width + 3)[1:-1]
    kernel /= kernel.sum()
    for _ in range(FITTING):
        value = np.maximum.accumulate(np.clip(value, least, most))
        padded = np.concatenate([np.full(width, 0.0), value, np.full(width, end)])
        value = np.convolve(padded, kernel, mode="valid")
    return np.asarray(np.interp(times, even, value).clip(0.0, end))
