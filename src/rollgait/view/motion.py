"""What pictures ask of a plan: dense samples, goals, and when which leg is in the air."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from rollgait.footing.on_terrain import regions_for, standing
from rollgait.plan.plan import Plan
from rollgait.plan.samples import Array, Samples
from rollgait.scenario.scenario import Scenario
from rollgait.view.on_ground import is_plane

POINTS_PER_INTERVAL = 6
"""Enough for a cubic to look smooth in print."""
BEFORE_THE_BORDER = 1e-6
"""Part of an interval: a sample so close before its end still has this interval's inputs."""

SNAPSHOT_SPACING = 0.45
"""Way of the base between two pictures of it, m."""
TURN_LEVER = 0.5
"""m"""
MAX_SNAPSHOTS = 6


def dense_samples(plan: Plan) -> Samples:
    """Samples for lines, (n, …): both ends of every interval, so that a jump of an input is drawn upright."""
    inside = np.append(np.linspace(0.0, 1.0, POINTS_PER_INTERVAL)[:-1], 1.0 - BEFORE_THE_BORDER)
    schedule = plan.schedule
    times = schedule.node_times[:-1, None] + inside * schedule.lengths[:, None]
    return plan.sample(np.append(times.ravel(), plan.horizon))


def goal_poses(scenario: Scenario, times: Array) -> Array:
    """Goals at times (n,) as their ground asks: x, y, z of the CoM (m), yaw, pitch, roll (rad), (n, 6)."""
    poses = scenario.goal_at(times)
    if is_plane(scenario.terrain):
        return poses
    regions = regions_for(scenario)
    goals, number = np.unique(poses, axis=0, return_inverse=True)
    for goal in goals:
        base, _ = standing(scenario.body, regions, goal[:2], goal[3])
        if np.isfinite(base).all():
            goal[[2, 4, 5]] = base[[2, 4, 5]]
    return np.asarray(goals[number.reshape(-1)])


def swing_times(plan: Plan) -> Iterator[tuple[int, float, float]]:
    """(leg, lift-off, touch-down) of all swings, s."""
    nodes = plan.schedule.node_times
    for swing in plan.schedule.swings():
        yield swing.leg, float(nodes[swing.lift_off]), float(nodes[swing.touch_down])


def snapshot_times(plan: Plan, begin: float, end: float) -> NDArray[np.float64]:
    """Times at which pictures of the moving robot stand clear of each other, `end` among them.

    A turn counts as the way of a point `TURN_LEVER` from its axis.
    """
    s = dense_samples(plan)
    s = s.at((s.time >= begin) & (s.time <= end))
    place = np.column_stack([s.com_position[:, :2], TURN_LEVER * s.euler[:, 0]])
    spacing = SNAPSHOT_SPACING
    while len(kept := _apart(place, spacing)) > MAX_SNAPSHOTS:
        spacing *= 1.1
    return np.asarray(s.time[kept])


def _apart(place: NDArray[np.float64], spacing: float) -> list[int]:
    """Indices of the last place, and of others that keep their distance from it and from each other."""
    kept = [len(place) - 1]
    for index, here in enumerate(place):
        if np.linalg.norm(place[kept] - here, axis=1).min() >= spacing:
            kept.append(index)
    return sorted(kept)
