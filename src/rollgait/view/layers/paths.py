"""Paths of the CoM and the feet: all of the way faint, the way behind the robot strong; touch-downs."""

from __future__ import annotations

import numpy as np
from viser import BatchedMeshHandle

from rollgait.plan.samples import Array
from rollgait.view import shapes
from rollgait.view.layers.layer import NOWHERE, Layer, Moving, linear, rgb, single
from rollgait.view.on_ground import ABOVE, normals, on_ground
from rollgait.view.paths import segments_of
from rollgait.view.rotations import from_z_to, wxyz
from rollgait.view.style import BASE_COLOUR, LEG_COLOURS

COARSE = 2
"""The past grows every so many frames, fifteen times a second: a tenth of the time of drawing."""
THIN, THICK = 0.009, 0.014
"""Thickness of the future and of the past, m."""
RING = 0.055
"""Radius of a touch-down, m."""
COM_COLOUR = "#F5C400"
FAINT = 0.55
"""How far the future is from its colour to white."""


class Paths(Layer):
    """Where the CoM and the feet were and will be."""

    title = "paths"
    for_ghost = True

    def draw(self) -> None:
        s = self.clip.samples
        self._way = np.stack([s.com_position, *s.foot_position.transpose(1, 0, 2)])
        ends = [segments_of(line) for line in self._way]
        self._ends = np.concatenate(ends)
        self._line = np.repeat(np.arange(len(ends)), [len(each) for each in ends])
        begin, end = self._way[self._line[:, None], self._ends].swapaxes(0, 1)
        self._drawn = -1
        self._from, self._chord = begin + np.array([0.0, 0.0, ABOVE]), end - begin
        low = THICK if not self.look.ghost else 0.0  # the past hides the future under it
        self._add("future", THIN, FAINT, low)
        if not self.look.ghost:
            self.past = self._add("past", THICK, 0.0, 0.0)
            self.show(0)

    def _add(self, name: str, thickness: float, light: float, down: float) -> BatchedMeshHandle:
        """All five lines as one batch of rods: lines proper take a software renderer three times as long."""
        shades = linear([rgb(self.look.colour or colour, light) for colour in (BASE_COLOUR, *LEG_COLOURS)])
        self._half = 0.5 * thickness
        vertices, faces = shapes.rod()
        return self.scene.add_batched_meshes_simple(
            self.at(name),
            vertices,
            faces,
            batched_wxyzs=single(wxyz(from_z_to(self._chord))),
            batched_positions=single(self._from - [0.0, 0.0, 0.5 * down]),
            batched_scales=single(self._scales(np.ones(len(self._line)))),
            batched_colors=shades[self._line],
            lod="off",
            cast_shadow=False,
            receive_shadow=False,
        )

    def _scales(self, share: Array) -> Array:
        """Of the rods, of which a share is seen, (m, 3)."""
        width = np.where(share > 0.0, self._half, NOWHERE)
        length = np.maximum(share * np.linalg.norm(self._chord, axis=1), NOWHERE)
        return np.column_stack([width, width, length])

    def show(self, index: int) -> None:
        last = len(self._way[0]) - 1
        index = index if index == last else index - index % COARSE
        if self.look.ghost or index == self._drawn:
            return
        self._drawn = index
        done = self._way[self._line, np.clip(index, *self._ends.T)] + [0.0, 0.0, ABOVE] - self._from
        share = np.einsum("ij,ij->i", done, self._chord) / np.einsum("ij,ij->i", self._chord, self._chord)
        self.past.batched_scales = single(self._scales(np.clip(share, 0.0, 1.0)))


class Footholds(Layer):
    """Where the feet touch down, and where they stand at first."""

    title = "footholds"

    def draw(self) -> None:
        s = self.clip.samples
        landed = np.vstack([np.ones((1, 4), dtype=bool), ~s.contact[:-1] & s.contact[1:]])
        frame, leg = np.nonzero(landed)
        place = on_ground(self.clip.terrain, s.foot_position[frame, leg])
        vertices, faces = shapes.ring()
        self.scene.add_batched_meshes_simple(
            self.at("rings"),
            vertices * RING,
            faces,
            batched_wxyzs=single(wxyz(from_z_to(normals(self.clip.terrain, place)))),
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
        yellow, black = self.look.of(COM_COLOUR), self.look.of(BASE_COLOUR)
        ball = 0.035 * vertices, faces
        self.ball = Moving(self.scene, self.at("ball"), ball, yellow, cast_shadow=False)
        disc, disc_faces = shapes.ring(inner=0.0)
        flat = 0.03 * disc, disc_faces
        self.disc = Moving(self.scene, self.at("disc"), flat, black, side="double", cast_shadow=False)
        below = self.clip.samples.com_position
        self._below = on_ground(self.clip.terrain, below, 2 * ABOVE)
        self._turn = wxyz(from_z_to(normals(self.clip.terrain, below)))
        self.show(0)

    def show(self, index: int) -> None:
        x, y, z = self.clip.samples.com_position[index]
        self.ball.move((x, y, z + 0.1 * self.clip.robot.height))
        self.disc.move(self._below[index], self._turn[index])
