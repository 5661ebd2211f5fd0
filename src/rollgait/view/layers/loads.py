"""What the robot carries, as boxes, and what pulls at it, as arrows."""

from __future__ import annotations

from typing import Final

import numpy as np

from rollgait.plan.samples import Array
from rollgait.robot.loads import Load, Wrench
from rollgait.view import shapes
from rollgait.view.arrows import ArrowPoses, Arrows, arrow_poses
from rollgait.view.clip import Clip
from rollgait.view.layers.layer import Layer, Moving, linear, rgb
from rollgait.view.rotations import matrix_from_euler, wxyz

DENSITY: Final = 1000.0
"""Of a load whose size is not known, kg/m³: as heavy as water."""
PULL_LENGTH: Final = 7.0
"""Length of an arrow for a pull as large as the robot's weight, as a share of its height: pulls are mostly a
tenth of that. Likewise a torque, against weight times height."""
LOAD_COLOUR: Final = "#A47148"
PULL_COLOUR: Final = "#7B1FA2"
LIGHT: Final = 0.45
"""How far the colour of a torque is on its way to white."""


class Loads(Layer):
    """Boxes where the loads are on the base; an arrow from where a force acts, a lighter one for a torque."""

    title = "loads"
    for_ghost = False

    @classmethod
    def suits(cls, clip: Clip) -> bool:
        return bool(clip.robot.loads or clip.wrenches)

    def draw(self) -> None:
        clip = self.clip
        s, loads = clip.samples, clip.robot.loads or ()
        R_world_base = matrix_from_euler(s.euler)
        self._turn = wxyz(R_world_base)
        self._places = [s.com_position + R_world_base @ place_of(load, clip) for load in loads]
        self.boxes = [
            Moving(
                self.scene,
                self.at(f"box{k}"),
                shapes.box(edges_of(load)),
                self.look.of(LOAD_COLOUR),
                flat_shading=True,
            )
            for k, load in enumerate(loads)
        ]
        self.arrows: Arrows | None = None
        if clip.wrenches:
            self._poses = _poses(clip, R_world_base)
            colours = linear([rgb(PULL_COLOUR), rgb(PULL_COLOUR, LIGHT)] * len(clip.wrenches))
            self.arrows = Arrows(self.scene, self.path, self._at(0), colours)
        self.show(0)

    def _at(self, index: int) -> ArrowPoses:
        return ArrowPoses(*(values[index] for values in self._poses))

    def show(self, index: int) -> None:
        for box, places in zip(self.boxes, self._places, strict=True):
            box.move(places[index], self._turn[index])
        if self.arrows is not None:
            self.arrows.move(self._at(index))


def edges_of(load: Load) -> Array:
    """Edges of the box that stands for a load, (3,), m: its own, or those of a cube of water of its mass."""
    return np.array(load.size) if load.size is not None else np.full(3, (load.mass / DENSITY) ** (1.0 / 3.0))


def place_of(load: Load | Wrench, clip: Clip) -> Array:
    """Where something is fixed to the base, from the CoM, base frame, (3,), m."""
    return np.asarray(np.array(load.at) - clip.robot.com_offset)


def _poses(clip: Clip, R_world_base: Array) -> ArrowPoses:
    """Of the arrows of all wrenches at all frames, force and torque in turn, (n, 2 n_w, …)."""
    s, robot = clip.samples, clip.robot
    by_force = PULL_LENGTH * robot.height / robot.weight
    starts, vectors = [], []
    for wrench in clip.wrenches:
        acts = (s.time >= wrench.start) & (s.time < (np.inf if wrench.end is None else wrench.end))
        start = s.com_position + R_world_base @ place_of(wrench, clip)
        for vector in (np.array(wrench.force), np.array(wrench.torque) / robot.height):
            turned = R_world_base @ vector if wrench.frame == "base" else np.tile(vector, (len(s.time), 1))
            starts.append(start)
            vectors.append(by_force * acts[:, None] * turned)
    return arrow_poses(np.stack(starts, axis=1), np.stack(vectors, axis=1))
