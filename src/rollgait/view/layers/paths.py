"""Paths of the CoM and the feet: all of the way faint, the way behind the robot strong; touch-downs."""

from __future__ import annotations

import numpy as np
from viser import LineSegmentsHandle

from rollgait.plan.samples import Array
from rollgait.view import shapes
from rollgait.view.layers.layer import Layer, linear, rgb, segments, single
from rollgait.view.style import BASE_COLOUR, LEG_COLOURS

COARSE = 2
"""Every so many frames have a point of the paths, and the past grows: fifteen a second."""
THIN, THICK = 0.006, 0.014
"""Thickness of the future and of the past, m."""
ABOVE = 0.004
"""Height over the ground of what lies on it, m: it must not flicker."""
RING = 0.055
"""Radius of a touch-down, m."""
FAINT = 0.55
"""How far the future is from its colour to white."""


class Paths(Layer):
    """Where the CoM and the feet were and will be."""

    title = "paths"
    for_ghost = True

    def draw(self) -> None:
        s = self.clip.samples
        self._kept = np.unique(np.append(np.arange(0, len(s.time), COARSE), len(s.time) - 1))
        lines = [s.com_position, *(s.foot_position[:, leg] for leg in range(4))]
        self._way = np.stack([segments(line[self._kept]) for line in lines])
        self._drawn = -1
        low = THICK if not self.look.ghost else 0.0  # the past hides the future under it
        self._add("future", self._way + np.array([0.0, 0.0, ABOVE - 0.5 * low]), THIN, FAINT)
        if not self.look.ghost:
            self.past = self._add("past", self._past(0), THICK, 0.0)

    def _add(self, name: str, way: Array, thickness: float, light: float) -> LineSegmentsHandle:
        """All five lines as one; way: (5, m, 2, 3)."""
        shades = linear([rgb(self.look.colour or colour, light) for colour in (BASE_COLOUR, *LEG_COLOURS)])
        colours = np.broadcast_to(shades[:, None, None], way.shape).reshape(-1, 2, 3)
        return self.scene.add_line_segments(
            self.at(name), single(way.reshape(-1, 2, 3)), colours, thickness=thickness
        )

    def _past(self, count: int) -> Array:
        """The first `count` segments of each line; the others have no length, (5, m, 2, 3)."""
        way: Array = self._way + np.array([0.0, 0.0, ABOVE])
        way[:, count:] = way[:, max(count - 1, 0), -1][:, None, None]
        return way

    def show(self, index: int) -> None:
        count = int(np.searchsorted(self._kept[1:], index, side="right"))
        if not self.look.ghost and count != self._drawn:
            self._drawn = count
            self.past.points = single(self._past(count).reshape(-1, 2, 3))


class Footholds(Layer):
    """Where the feet touch down, and where they stand at first."""

    title = "footholds"

    def draw(self) -> None:
        s = self.clip.samples
        landed = np.vstack([np.ones((1, 4), dtype=bool), ~s.contact[:-1] & s.contact[1:]])
        frame, leg = np.nonzero(landed)
        place = s.foot_position[frame, leg]
        place[:, 2] = self.clip.ground + ABOVE
        vertices, faces = shapes.ring()
        self.scene.add_batched_meshes_simple(
            self.at("rings"),
            vertices * RING,
            faces,
            batched_wxyzs=single(np.tile([1.0, 0.0, 0.0, 0.0], (len(leg), 1))),
            batched_positions=single(place),
            batched_colors=self.look.legs()[leg],
            side="double",
            lod="off",
            cast_shadow=False,
        )


class Com(Layer):
    """The CoM, and the point under it on the ground."""

    title = "CoM"

    def draw(self) -> None:
        vertices, faces = shapes.ball()
        self.ball = self.scene.add_mesh_simple(
            self.at("ball"), vertices * 0.035, faces, color=self.look.of("#F5C400"), cast_shadow=False
        )
        disc, disc_faces = shapes.ring(inner=0.0)
        self.disc = self.scene.add_mesh_simple(
            self.at("disc"),
            disc * 0.03,
            disc_faces,
            color=self.look.of(BASE_COLOUR),
            side="double",
            cast_shadow=False,
        )
        self.show(0)

    def show(self, index: int) -> None:
        x, y, z = self.clip.samples.com_position[index]
        self.ball.position = (x, y, z + 0.1 * self.clip.robot.height)
        self.disc.position = (x, y, self.clip.ground + 2 * ABOVE)
