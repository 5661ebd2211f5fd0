"""Colours of ground by height and slope: light, so that the robot stands out."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.terrain.polygons import Array

LEVEL_COLOUR: Final = (232, 235, 238)
"""Of the plane that all lies on."""
HIGH_COLOUR: Final = (224, 202, 160)
"""Of the highest ground: sand."""
LOW_COLOUR: Final = (150, 176, 204)
"""Of the lowest ground: water."""
LIGHT: Final = np.array([0.35, -0.5, 0.79])
"""Direction to the light, world: what faces it is bright."""
AMBIENT: Final = 0.58
"""Brightness of what the light does not reach, as a share of that of level ground."""
SPAN_MIN: Final = 0.15
"""Heights that differ by less than this, m, have not the whole range of colours."""
BRIGHTEST: Final = 1.06
"""Most that a slope is brighter than level ground."""


def face_colours(corners: Array, level: float | None) -> NDArray[np.uint8]:
    """A colour for each triangle (n, 3, 3): red, green and blue, (n, 3).

    Args:
        corners: of the triangles, world, m.
        level: height of the plane that all lies on, m; if None, the median is taken for it.
    """
    if not len(corners):
        return np.zeros((0, 3), dtype=np.uint8)
    height = corners[..., 2].max(axis=1)  # walls have the colour of what they carry
    height = height - (np.median(height) if level is None else level)
    share = np.zeros_like(height)
    for sign in (1.0, -1.0):
        span = max(float((sign * height).max()), SPAN_MIN)
        share += sign * np.clip(sign * height / span, 0.0, 1.0)
    return tinted(share, _brightness(corners))


def tinted(share: Array, brightness: Array) -> NDArray[np.uint8]:
    """Colours (n, 3) of heights as shares of the range, −1 to 1, at a brightness (n,)."""
    ends = np.array([LOW_COLOUR, LEVEL_COLOUR, HIGH_COLOUR], dtype=float)
    colours = np.stack([np.interp(share, [-1.0, 0.0, 1.0], channel) for channel in ends.T], axis=-1)
    return np.clip(np.round(colours * brightness[..., None]), 0, 255).astype(np.uint8)


def _brightness(corners: Array) -> Array:
    """Of triangles, (n,); that of level ground is 1."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    facing = np.clip(normal @ LIGHT / LIGHT[2], 0.0, None)
    return np.asarray(np.minimum(AMBIENT + (1.0 - AMBIENT) * facing, BRIGHTEST))
