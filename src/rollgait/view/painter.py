"""Polygons in space as polygons in a picture, the farthest first."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PIL import ImageDraw

from rollgait.plan.samples import Array
from rollgait.view.camera import FIELD_OF_VIEW, Camera

LARGEST: Final = 0.12
"""Edges longer than this are halved, m: the depth of a large triangle says little."""
MOST: Final = 100_000
"""Triangles of a thing, after which none is halved any more."""
NEAR: Final = 0.05
"""What is nearer to the camera is left out, m."""

Seen = Callable[[Array, Array], NDArray[np.bool_]]
"""Which polygons are seen, by the pixels of their middles (n, 2) and their depths (n,), m."""


@dataclass(frozen=True)
class Piece:
    """Polygons of one kind.

    Attributes:
        corners: (m, k, 3), world, m; k = 2 for lines.
        colours: red, green, blue, alpha, (m, 4).
        flat: whether it lies on the ground.
        width: of lines, m.
        casts: whether it casts a shadow.
    """

    corners: Array
    colours: NDArray[np.uint8]
    flat: bool
    width: float = 0.0
    casts: bool = False


def draw_pieces(
    pieces: Sequence[Piece],
    camera: Camera,
    size: tuple[int, int],
    draw: ImageDraw.ImageDraw,
    is_seen: Seen | None = None,
) -> None:
    """Draws pieces, the farthest polygons first; without those that are hidden."""
    polygons: list[tuple[float, list[float], tuple[int, ...], float]] = []
    scale = focal(size)
    for piece in pieces:
        if not len(piece.corners):
            continue
        pixels, depth = project(piece.corners, camera, size)
        seen = (depth > NEAR).all(axis=1)
        if is_seen is not None:
            seen &= is_seen(*project(piece.corners.mean(axis=1), camera, size))
        means = depth[seen].mean(axis=1)
        flat = pixels[seen].reshape(len(means), 2 * piece.corners.shape[1]).tolist()
        colours = map(tuple, piece.colours[seen].tolist())
        widths = (piece.width * scale / means).tolist()
        polygons += zip(means.tolist(), flat, colours, widths, strict=True)
    for _, corners, colour, width in sorted(polygons, key=itemgetter(0), reverse=True):
        if len(corners) == 4:
            draw.line(corners, fill=colour, width=max(1, round(width)))
        else:
            draw.polygon(corners, fill=colour)


def cut_short(lines: Array, longest: float) -> tuple[Array, NDArray[np.intp]]:
    """Segments (n, 2, 3) cut into equal pieces no longer than this (m), and of which each is a part."""
    count = np.maximum(np.ceil(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) / longest), 1.0).astype(int)
    number = np.repeat(np.arange(len(lines)), count)
    place = np.concatenate([np.zeros(0), *(np.arange(n) / n for n in count)])
    share = np.stack([place, place + 1.0 / count[number]], axis=1)[..., None]
    begin, end = lines[number, None, 0], lines[number, None, 1]
    return begin + share * (end - begin), number


def halved(corners: Array, largest: float = LARGEST, times: int = 4) -> tuple[Array, NDArray[np.intp]]:
    """The same surface with smaller triangles (n, 3, 3) where they are large, and of which each is a part.

    Args:
        corners: of the triangles, m.
        largest: sides longer than this are halved, m.
        times: how often at most.
    """
    number = np.arange(len(corners))
    for _ in range(times):
        size = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
        large = size > largest
        if not large.any() or len(corners) > MOST:
            break
        a, b, c = np.moveaxis(corners[large], 1, 0)
        ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        parts = [np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        corners = np.concatenate([corners[~large], *parts])
        number = np.concatenate([number[~large], *[number[large]] * len(parts)])
    return corners, number


def project(points: Array, camera: Camera, size: tuple[int, int]) -> tuple[Array, Array]:
    """Pixels (…, 2) and depths (…) of points (…, 3)."""
    seen = (points - camera.position) @ camera.axes.T
    across, depth = seen[..., :2], seen[..., 2]
    safe = np.maximum(depth, NEAR)[..., None]
    return focal(size) * across / safe + 0.5 * np.array(size), depth


def focal(size: tuple[int, int]) -> float:
    return float(0.5 * size[1] / np.tan(0.5 * FIELD_OF_VIEW))
