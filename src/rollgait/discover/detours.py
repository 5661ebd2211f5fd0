"""Ways around: the cheapest one on a grid of poses, and the few poses at which it turns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from rollgait.discover.passages import OVER, Passages
from rollgait.footing.footing import Array

SPACING: Final = 0.1
"""Of the places of the base, m."""
TURN: Final = np.radians(15.0)
"""Largest turn from one layer of the grid to the next, rad."""
STEP_COST: Final = 0.5
"""What a step costs, in m that the base could have gone: 1.4 s."""
OVER_COST: Final = 0.5
"""What it costs beside that to be over what a foot steps over, in m per m and foot."""
LOOK: Final = 0.05
"""Distance of the poses at which a straight way is looked at, m."""
NEAR: Final = 0.2
"""So far from the goal the grid may end, m."""
WORTH: Final = 0.25
"""By so much a straight way may cost more than the way on the grid that it replaces, m: the grid has but
eight directions."""


@dataclass(frozen=True, eq=False)
class Network:
    """The grid of poses between a start and a goal.

    Attributes:
        passages: where the robot can be.
        poses: of the nodes, (layers, nx, ny, 3).
        lever: what a turn of 1 rad counts as, m.
        steps: whether feet may step; else they only roll.
    """

    passages: Passages
    poses: Array
    lever: float
    steps: bool

    @classmethod
    def between(
        cls, passages: Passages, start: Array, goal: Array, low: Array, high: Array, lever: float, steps: bool
    ) -> Network:
        """The grid in a window; the start is one of its nodes."""
        layers = 1 + int(np.ceil(abs(goal[2] - start[2]) / TURN - 1e-9))
        yaw = np.linspace(start[2], goal[2], layers)
        first = np.floor((low - start[:2]) / SPACING).astype(int)
        last = np.ceil((high - start[:2]) / SPACING).astype(int)
        x, y = (start[k] + SPACING * np.arange(first[k], last[k] + 1) for k in range(2))
        grid = np.stack(np.meshgrid(yaw, x, y, indexing="ij"), axis=-1)[..., [1, 2, 0]]
        return cls(passages, grid, lever, steps)

    def path(self, start: Array, goal: Array) -> Array | None:
        """The cheapest way from the start to near the goal, poses (n, 3), both among them; None if none."""
        labels = self.passages.labels(self.poses)
        blocked = self.passages.blocked(self.poses, labels)
        if not self.steps:
            blocked |= (labels < 0).any(axis=-1)
        shape = blocked.shape
        number = np.arange(blocked.size).reshape(shape)
        rows, columns, costs = [], [], []
        for move in [(0, 1, 0), (0, 0, 1), (0, 1, 1), (0, 1, -1), (1, 0, 0)]:
            here = tuple(slice(max(0, -d), n - max(0, d)) for d, n in zip(move, shape, strict=True))
            there = tuple(slice(max(0, d), n - max(0, -d)) for d, n in zip(move, shape, strict=True))
            cost = self._costs(self.poses[here], labels[here], self.poses[there], labels[there])
            open_ = ~(blocked[here] | blocked[there])
            if not self.steps:
                open_ &= (labels[here] == labels[there]).all(axis=-1)
            for a, b in ((here, there), (there, here)):
                rows.append(number[a][open_])
                columns.append(number[b][open_])
                costs.append(cost[open_])
        if not sum(len(row) for row in rows):
            return None
        size = (blocked.size, blocked.size)
        graph = coo_array((np.concatenate(costs), (np.concatenate(rows), np.concatenate(columns))), size)
        begin, ends = self._nearest(start, blocked), self._near(goal, blocked)
        if begin is None or not len(ends):
            return None
        distance, before = dijkstra(graph.tocsr(), indices=begin, return_predecessors=True)
        flat = self.poses.reshape(-1, 3)
        total = distance[ends] + self._length(flat[ends], goal)
        if not np.isfinite(total).any():
            return None
        node, nodes = int(ends[np.argmin(total)]), list[int]()
        while node >= 0:
            nodes.append(node)
            node = int(before[node])
        middle = flat[nodes[::-1]]
        result = np.vstack([start, middle, goal])
        kept = np.append(True, np.abs(np.diff(result, axis=0)).max(axis=1) > 1e-9)
        return np.asarray(result[kept])

    def pulled(self, path: Array) -> Array:
        """The few poses of a way at which it must turn."""
        labels = self.passages.labels(path)
        cost = np.append(0.0, np.cumsum(self._costs(path[:-1], labels[:-1], path[1:], labels[1:])))
        kept, at, last = [0], 0, len(path) - 1
        while at < last:
            for to in range(last, at, -1):
                if to == at + 1 or self.straight(path[at], path[to]) <= cost[to] - cost[at] + WORTH:
                    kept.append(to)
                    at = to
                    break
        return np.asarray(path[kept])

    def straight(self, a: Array, b: Array) -> float:
        """The cost of the straight way between two poses, m; infinite if there is none."""
        count = max(1, int(np.ceil(self._length(a[None], b)[0] / LOOK)))
        poses = a + (b - a) * np.linspace(0.0, 1.0, count + 1)[:, None]
        labels = self.passages.labels(poses)
        blocked = self.passages.blocked(poses, labels)
        ends = slice(1, -1)  # start and goal were judged exactly, the grid may be wrong about them
        if blocked[ends].any() or (not self.steps and (labels[ends] < 0).any()):
            return float("inf")
        if not self.steps and (labels[ends] != labels[1]).any():
            return float("inf")
        return float(self._costs(poses[:-1], labels[:-1], poses[1:], labels[1:]).sum())

    def _costs(self, a: Array, own: NDArray[np.intp], b: Array, other: NDArray[np.intp]) -> Array:
        length = self._length(a, b)
        begins = (own >= 0) & (other != own)
        over = ((own == OVER) | (other == OVER)).sum(axis=-1)
        ends = (other >= 0) & (other != own)
        return np.asarray(
            length * (1.0 + OVER_COST * over) + 0.5 * STEP_COST * (begins.astype(int) + ends).sum(axis=-1)
        )

    def _length(self, a: Array, b: Array) -> Array:
        change = np.abs(b - a)
        return np.asarray(np.hypot(change[..., 0], change[..., 1]) + self.lever * change[..., 2])

    def _nearest(self, pose: Array, blocked: NDArray[np.bool_]) -> int | None:
        near = self._near(pose, blocked)
        if not len(near):
            return None
        return int(near[np.argmin(self._length(self.poses.reshape(-1, 3)[near], pose))])

    def _near(self, pose: Array, blocked: NDArray[np.bool_]) -> NDArray[np.intp]:
        distance = self._length(self.poses, pose).ravel()
        return np.flatnonzero((distance < NEAR) & ~blocked.ravel())
