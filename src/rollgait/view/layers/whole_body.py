"""The whole body: the meshes of its links."""

from __future__ import annotations

from rollgait.view.clip import Clip
from rollgait.view.layers.layer import Layer, Moving
from rollgait.view.layers.robot import TYRE_COLOUR
from rollgait.view.meshes import COLOUR, parts_of, whole_body_of
from rollgait.view.style import LEG_COLOURS


class WholeBody(Layer):
    """The links of the whole body, where the joints are known."""

    title = "whole body"
    for_ghost = True

    @classmethod
    def suits(cls, clip: Clip) -> bool:
        return clip.joints is not None and whole_body_of(clip.robot) is not None

    def draw(self) -> None:
        self.parts = []
        for part in parts_of(self.clip):
            colour = COLOUR if part.leg is None else TYRE_COLOUR if part.wheel else LEG_COLOURS[part.leg]
            look = self.look.of(colour)
            moving = Moving(
                self.scene, self.at(part.name), part.shape, look, opacity=self.look.opacity, flat_shading=True
            )
            self.parts.append((moving, part))
        self.show(0)

    def show(self, index: int) -> None:
        for moving, part in self.parts:
            moving.move(part.position[index], part.turn[index])
