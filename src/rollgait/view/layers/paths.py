"""Paths of the CoM and the feet: all of the way faint, the way behind the robot strong; touch-downs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from viser import LineSegmentsHandle

from rollgait.view import shapes
from rollgait.view.layers.layer import Layer, linear, rgb, segments, single
from rollgait.view.style import BASE_COLOUR, LEG_COLOURS

CHUNK = 24
"""Frames in a piece of the paths: a piece is switched as a whole. Every piece costs the browser time."""
COARSE = 3
"""Every so many frames have a point of the paths: 10 a second."""
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
        self._lines = [s.com_position, *(s.foot_position[:, leg] for leg in range(4))]
        self.pieces = []
        if self.look.ghost:
            self._add("way", slice(None), THIN, FAINT)
            return
        for begin in range(0, len(s.time) - 1, CHUNK):
            piece = slice(begin, begin + CHUNK + 1)
            future = self._add(f"future{begin:05d}", piece, THIN, FAINT)
            past = self._add(f"past{begin:05d}", piece, THICK, 0.0)
            past.visible = False
            self.pieces.append((begin + CHUNK // 2, future, past))

    def _add(self, name: str, piece: slice, thickness: float, light: float) -> LineSegmentsHandle:
        """All five lines in a piece of the time."""
        parts = [segments(line[piece][_coarse(len(line[piece]))]) for line in self._lines]
        shades = [
            np.broadcast_to(linear([rgb(self.look.colour or colour, light)]), part.shape)
            for colour, part in zip([BASE_COLOUR, *LEG_COLOURS], parts, strict=True)
        ]
        points = np.concatenate(parts) + np.array([0.0, 0.0, ABOVE])
        return self.scene.add_line_segments(
            self.at(name), single(points), np.concatenate(shades), thickness=thickness
        )

    def show(self, index: int) -> None:
        for begin, future, past in self.pieces:
            behind = begin <= index
            if past.visible != behind:
                past.visible, future.visible = behind, not behind


def _coarse(count: int) -> NDArray[np.intp]:
    """Some of `count` points, both ends among them."""
    return np.unique(np.append(np.arange(0, count, COARSE), count - 1))


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
