"""The ground: a grid with lines at every metre and every 0.25 m."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from rollgait.view.layers.layer import Layer

MARGIN = 1.0
"""Ground around the motion, m."""
LIGHT = 0.4
"""Weight of the fine lines; together with the others 1, or viser overshoots where they cross."""
GRID: Final[dict[str, Any]] = {
    "cell_color": (205, 210, 216),
    "cell_thickness": LIGHT,
    "section_size": 1.0,
    "section_color": (95, 105, 120),
    "section_thickness": 1.0 - LIGHT,
    "plane_color": (248, 249, 250),
    "plane_opacity": 1.0,
    "fade_strength": 0.0,
}
"""How every ground looks, as viser's `add_grid` names it: strong lines at every metre (sizes in m)."""


class Ground(Layer):
    """The ground."""

    title = "ground"

    def draw(self) -> None:
        s = self.clip.samples
        points = np.concatenate([s.foot_position[..., :2].reshape(-1, 2), s.com_position[:, :2]])
        low = np.floor(points.min(axis=0) - MARGIN)
        high = np.ceil(points.max(axis=0) + MARGIN)
        middle, size = 0.5 * (low + high), high - low
        self.scene.add_grid(
            self.at("grid"),
            width=float(size[0]),
            height=float(size[1]),
            cell_size=0.25,
            shadow_opacity=0.25,
            position=(float(middle[0]), float(middle[1]), self.clip.ground),
            **GRID,
        )
