"""Arrows in space as two batches, shafts and heads: where they are, how they are turned, how large."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from viser import SceneApi

from rollgait.plan.samples import Array
from rollgait.view import shapes
from rollgait.view.layers.layer import NOWHERE, single
from rollgait.view.rotations import from_z_to, wxyz

SHAFT, HEAD, HEAD_LENGTH = 0.02, 0.042, 0.11
"""Radii of an arrow and the length of its head, m."""
SHORTEST = 1e-3
"""What is shorter is not seen, m."""


class ArrowPoses(NamedTuple):
    """Turns (…, 4) of arrows; places and scales (…, 3) of their shafts and heads."""

    turn: Array
    shaft_at: Array
    shaft_scale: Array
    head_at: Array
    head_scale: Array


def arrow_poses(start: Array, vector: Array) -> ArrowPoses:
    """Arrows from points (…, 3) along vectors (…, 3), m."""
    length = np.linalg.norm(vector, axis=-1)
    seen = length > SHORTEST
    head = np.minimum(HEAD_LENGTH, 0.6 * length)
    direction = np.where(seen[..., None], vector, [0.0, 0.0, 1.0])
    unit = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    wide = np.where(seen, np.minimum(1.0, head / HEAD_LENGTH), NOWHERE)
    return ArrowPoses(
        turn=wxyz(from_z_to(unit.reshape(-1, 3))).reshape(*unit.shape[:-1], 4),
        shaft_at=start,
        shaft_scale=_scales(SHAFT * wide, np.maximum(length - head, NOWHERE)),
        head_at=start + unit * (length - head)[..., None],
        head_scale=_scales(HEAD * wide, np.maximum(head, NOWHERE)),
    )


class Arrows:
    """Arrows that move together.

    Args:
        scene: where they are.
        path: of their names.
        poses: of n arrows, (n, …).
        colours: (n, 3), linear.
    """

    def __init__(self, scene: SceneApi, path: str, poses: ArrowPoses, colours: NDArray[np.uint8]) -> None:
        def batch(name: str, shape: shapes.Shape, at: Array, scale: Array) -> Any:
            return scene.add_batched_meshes_simple(
                f"{path}/{name}",
                *shape,
                batched_wxyzs=single(poses.turn),
                batched_positions=single(at),
                batched_scales=single(scale),
                batched_colors=colours,
                lod="off",
                cast_shadow=False,
            )

        self.shafts = batch("shafts", shapes.cylinder(), poses.shaft_at, poses.shaft_scale)
        self.heads = batch("heads", shapes.arrow_head(), poses.head_at, poses.head_scale)

    def move(self, poses: ArrowPoses) -> None:
        """Moves them."""
        for handle, at, scale in (
            (self.shafts, poses.shaft_at, poses.shaft_scale),
            (self.heads, poses.head_at, poses.head_scale),
        ):
            handle.batched_positions = single(at)
            handle.batched_wxyzs = single(poses.turn)
            handle.batched_scales = single(scale)


def _scales(radius: Array, length: Array) -> Array:
    return np.stack([radius, radius, length], axis=-1)
