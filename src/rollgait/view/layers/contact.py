"""What happens where the feet touch the ground: forces, friction cones, support polygon, headings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rollgait.plan.samples import Array
from rollgait.view import shapes
from rollgait.view.arrows import ArrowPoses, Arrows, arrow_poses
from rollgait.view.clip import Clip
from rollgait.view.layers.layer import NOWHERE, Layer, single
from rollgait.view.on_ground import ABOVE, frames, normals
from rollgait.view.rotations import from_z_to, wxyz

FORCE_LENGTH = 1.7
"""Length of an arrow for the whole weight of the robot, as a share of its height."""
CONE_HEIGHT = 0.28
"""m"""
HEADING_LENGTH, HEADING_WIDTH = 0.3, 0.07
"""m"""
AROUND = [0, 1, 3, 2]
"""The feet in the order around the robot."""


class Forces(Layer):
    """Contact forces on the robot, from the contact points."""

    title = "forces"

    def draw(self) -> None:
        clip = self.clip
        scale = FORCE_LENGTH * clip.robot.height / clip.robot.weight
        self._poses = arrow_poses(clip.samples.foot_position, scale * clip.samples.force)
        self.arrows = Arrows(self.scene, self.path, self._at(0), self.look.legs())

    def _at(self, index: int) -> ArrowPoses:
        return ArrowPoses(*(values[index] for values in self._poses))

    def show(self, index: int) -> None:
        self.arrows.move(self._at(index))


class Cones(Layer):
    """Friction cones: while the force stays inside, the foot does not slip."""

    title = "friction cones"
    shown = False

    def draw(self) -> None:
        clip = self.clip
        vertices, faces = shapes.cone()
        place = clip.samples.foot_position
        shape = CONE_HEIGHT * np.stack([clip.friction, clip.friction, np.ones_like(clip.friction)], axis=-1)
        self._size = np.where(clip.samples.contact[..., None], shape, NOWHERE)
        self._turn = wxyz(from_z_to(normals(clip.terrain, place).reshape(-1, 3)).reshape(*place.shape, 3))
        self.cones = self.scene.add_batched_meshes_simple(
            self.at("cones"),
            vertices,
            faces,
            batched_wxyzs=single(self._turn[0]),
            batched_positions=single(place[0]),
            batched_scales=single(self._size[0]),
            batched_colors=self.look.legs(0.3),
            opacity=0.35,
            side="double",
            lod="off",
            cast_shadow=False,
        )

    def show(self, index: int) -> None:
        self.cones.batched_positions = single(self.clip.samples.foot_position[index])
        self.cones.batched_wxyzs = single(self._turn[index])
        self.cones.batched_scales = single(self._size[index])


class Support(Layer):
    """The polygon of the feet on the ground."""

    title = "support polygon"

    def draw(self) -> None:
        self._corners = _corners(self.clip)
        self.area = self.scene.add_mesh_simple(
            self.at("area"),
            single(self._polygon(0)),
            np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32),
            color=(0, 150, 136),
            opacity=0.22,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

    def _polygon(self, index: int) -> Array:
        feet = self.clip.samples.foot_position[index].copy()
        feet[:, 2] = np.fmax(feet[:, 2], self.clip.foot_ground[index]) + ABOVE  # soft contacts sink in
        return np.asarray(feet[self._corners[index]])

    def show(self, index: int) -> None:
        self.area.vertices = single(self._polygon(index))


class Headings(Layer):
    """Where the wheels head, on the ground."""

    title = "wheel headings"

    @classmethod
    def suits(cls, clip: Clip) -> bool:
        return any(leg.foot != "point" for leg in clip.robot.leg_list)

    def draw(self) -> None:
        s = self.clip.samples
        self._turn = wxyz(frames(self.clip.terrain, s.foot_position, s.heading))
        self._at = s.foot_position + np.array([0.0, 0.0, 2 * ABOVE])
        vertices, faces = shapes.flat_arrow(HEADING_LENGTH, HEADING_WIDTH)
        self.arrows = self.scene.add_batched_meshes_simple(
            self.at("arrows"),
            vertices,
            faces,
            batched_wxyzs=single(self._turn[0]),
            batched_positions=single(self._at[0]),
            batched_colors=self.look.legs(),
            side="double",
            lod="off",
            cast_shadow=False,
        )

    def show(self, index: int) -> None:
        self.arrows.batched_positions = single(self._at[index])
        self.arrows.batched_wxyzs = single(self._turn[index])


def _corners(clip: Clip) -> NDArray[np.intp]:
    """For each frame four feet in the order around the robot, (n, 4); one in the air is its neighbour."""
    result = np.tile(np.array(AROUND), (len(clip.time), 1))
    for frame, contact in enumerate(clip.samples.contact):
        standing = [leg for leg in AROUND if contact[leg]]
        if standing:
            result[frame] = (standing * 4)[:4] if len(standing) < 3 else (*standing, standing[-1])[:4]
    return result
