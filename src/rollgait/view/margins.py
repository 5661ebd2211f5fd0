"""How far a motion is from slipping and from tipping, frame by frame."""

from __future__ import annotations

import numpy as np

from rollgait.plan.samples import Array
from rollgait.view.clip import Clip

PRESSED = 1.0
"""A foot pressed with less than this (N) has no friction to speak of."""


def friction_use(clip: Clip) -> Array:
    """Tangential force of each foot as a share of what friction allows, (n, 4), %; NaN in the air."""
    force = clip.samples.force
    pressed = clip.samples.contact & (force[..., 2] > PRESSED)
    most = clip.friction * np.where(pressed, force[..., 2], np.nan)
    return np.asarray(100.0 * np.linalg.norm(force[..., :2], axis=-1) / most)


def support_margin(clip: Clip) -> Array:
    """Distance of the CoM from the edge of the support polygon, from above, (n,), m; negative outside.

    The least of its distances from the edges; NaN with fewer than three feet on the ground.
    """
    s = clip.samples
    result = np.full(len(s.time), np.nan)
    for frame, contact in enumerate(s.contact):
        corners = [leg for leg in (0, 2, 3, 1) if contact[leg]]  # counter-clockwise
        if len(corners) < 3:
            continue
        a = s.foot_position[frame, corners, :2]
        edge = np.roll(a, -1, axis=0) - a
        way = s.com_position[frame, :2] - a
        inside = (edge[:, 0] * way[:, 1] - edge[:, 1] * way[:, 0]) / np.linalg.norm(edge, axis=1)
        result[frame] = inside.min()
    return result
