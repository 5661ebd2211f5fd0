"""The ground: a plane with lines, or its triangles with lines laid over them."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from viser import SceneApi

from rollgait.plan.samples import Array
from rollgait.terrain import Terrain
from rollgait.terrain.mesh import mesh_of, window_around
from rollgait.view.ground_glb import ground_glb
from rollgait.view.layers.layer import Layer, single
from rollgait.view.on_ground import grid_lines, is_plane
from rollgait.view.software import SoftwareScene
from rollgait.view.standing_clip import KIND, places_of

FARTHEST: Final = 20.0
"""How far from the robot ground is drawn for what is only wished for, m: a goal may be anywhere."""
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
"""How every plane looks, as viser's `add_grid` names it: strong lines at every metre (sizes in m)."""
LINES: Final = ((0.5, (198, 203, 209), 0.004), (1.0, (150, 157, 166), 0.007))
"""Lines laid over ground that is no plane: distance (m), colour, thickness (m)."""


class Ground(Layer):
    """The ground."""

    title = "ground"

    def draw(self) -> None:
        s = self.clip.samples
        places = np.concatenate([s.foot_position.reshape(-1, 3), s.com_position])
        if self.clip.kind == KIND and self.clip.scenario is not None:  # it is to get there
            here = s.com_position[0, :2]
            wished = np.clip(places_of(self.clip.scenario), here - FARTHEST, here + FARTHEST)
            places = np.concatenate([places[:, :2], wished])
        low, high = window_around(places)
        if not is_plane(self.clip.terrain):
            add_terrain(self.scene, self.path, self.clip.terrain, low, high)
            return
        middle, size = 0.5 * (low + high), high - low
        self.scene.add_grid(
            self.at("grid"),
            width=float(size[0]),
            height=float(size[1]),
            cell_size=0.25,
            shadow_opacity=0.25,
            position=(float(middle[0]), float(middle[1]), self.clip.terrain.level),
            **GRID,
        )


def add_terrain(
    scene: SceneApi | SoftwareScene, path: str, terrain: Terrain, low: Array, high: Array
) -> None:
    """Adds the ground over a rectangle to a scene.

    Args:
        scene: where to.
        path: what its names begin with.
        terrain: the ground.
        low: smallest x and y, (2,), m.
        high: largest x and y, (2,), m.
    """
    mesh = mesh_of(terrain, low, high)
    if isinstance(scene, SoftwareScene):
        scene.add_ground_mesh(f"{path}/mesh", mesh)
    elif len(mesh.faces):
        scene.add_glb(f"{path}/mesh", ground_glb(mesh), cast_shadow=False, receive_shadow=0.25)
    for spacing, colour, thickness in LINES:
        lines = grid_lines(terrain, low, high, spacing)
        if len(lines):
            scene.add_line_segments(f"{path}/lines{spacing:g}", single(lines), colour, thickness=thickness)
