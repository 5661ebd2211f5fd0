"""The ground of a picture: drawn once for a camera, and how far away it is: it hides what is behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from rollgait.plan.samples import Array
from rollgait.terrain import Terrain
from rollgait.terrain.relief import LIGHT
from rollgait.view.camera import Camera
from rollgait.view.on_ground import heights
from rollgait.view.painter import NEAR, Piece, draw_pieces, project

BACKGROUND: Final = (255, 255, 255)
BEHIND: Final = 0.08
"""So far behind the ground something is hidden by it, m: more than the ground's triangles are deep."""
SHADOW: Final = 46
"""Opacity of a shadow, of 255."""
DARK: Final = (60, 66, 75)
BOUNCES: Final = 3
"""Corrections of the place to which a shadow falls: the ground there is not as high as where it began."""


@dataclass(frozen=True, eq=False)
class Backdrop:
    """The ground as a picture.

    Attributes:
        picture: what is seen of it.
        depth: how far away it is, (height, width), m; infinite where there is none.
    """

    picture: Image.Image
    depth: NDArray[np.float32]

    def is_seen(self, pixels: Array, depth: Array) -> NDArray[np.bool_]:
        """Which things at pixels (n, 2) and depths (n,), m, it does not hide."""
        rows, columns = self.depth.shape
        column, row = np.clip(np.nan_to_num(pixels.T), -1e6, 1e6).astype(np.intp)
        inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
        result = np.ones(len(pixels), dtype=bool)
        result[inside] = depth[inside] <= self.depth[row[inside], column[inside]] + BEHIND
        return result


def backdrop_of(pieces: Sequence[Piece], camera: Camera, size: tuple[int, int]) -> Backdrop:
    """Draws the ground.

    Args:
        pieces: triangles hide and are hidden; what is flat is laid over them in this order.
        camera: from where.
        size: width and height, pixels.
    """
    picture = Image.new("RGB", size, BACKGROUND)
    draw = ImageDraw.Draw(picture, "RGBA")
    solid = [piece for piece in pieces if not piece.flat]
    draw_pieces(solid, camera, size, draw)
    far = Image.new("F", size, np.inf)
    _draw_depth(solid, camera, size, ImageDraw.Draw(far))
    result = Backdrop(picture, np.asarray(far))
    for piece in pieces:
        if piece.flat:
            draw_pieces([piece], camera, size, draw, result.is_seen)
    return result


def _draw_depth(
    pieces: Sequence[Piece], camera: Camera, size: tuple[int, int], draw: ImageDraw.ImageDraw
) -> None:
    every = np.concatenate([np.zeros((0, 3, 3)), *(piece.corners for piece in pieces)])
    pixels, depth = project(every, camera, size)
    seen = (depth > NEAR).all(axis=1)
    pixels, depth = pixels[seen], depth[seen].mean(axis=1)
    for k in np.argsort(-depth):
        draw.polygon(pixels[k].ravel().tolist(), fill=float(depth[k]))


def draw_shadows(
    pieces: Sequence[Piece], terrain: Terrain, camera: Camera, backdrop: Backdrop, picture: Image.Image
) -> None:
    """Darkens where the light does not reach the ground."""
    mask = Image.new("L", picture.size, 0)
    draw = ImageDraw.Draw(mask)
    every = np.concatenate([np.zeros((0, 3, 3)), *(piece.corners for piece in pieces)])
    fallen = every
    for _ in range(BOUNCES):
        way = every[..., 2] - heights(terrain, fallen)
        fallen = every - LIGHT * (way / LIGHT[2])[..., None]
    pixels, depth = project(fallen, camera, picture.size)
    seen = (depth > NEAR).all(axis=1)
    seen &= backdrop.is_seen(*project(fallen.mean(axis=1), camera, picture.size))
    for corners in pixels[seen].reshape(-1, 6).tolist():
        draw.polygon(corners, fill=SHADOW)
    picture.paste(Image.new("RGB", picture.size, DARK), mask=mask)
