"""The whole body as few pieces: what moves as one is one piece, whose pose is found in microseconds.

Legs move; all else is fixed to the base as it stood in the first frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollgait.robot.link_poses import Poses, axis_of, link_poses
from rollgait.robot.urdf_files import read_urdf
from rollgait.view import shapes
from rollgait.view.clip import Clip
from rollgait.view.driving.messages import Array, Body
from rollgait.view.meshes import Part, parts_of, whole_body_of
from rollgait.view.rotations import matrix_from_axis, matrix_from_quaternion


@dataclass(frozen=True)
class Joint:
    """A joint: piece it hangs on, place and turn there."""

    parent: int
    R: Array
    p: Array


@dataclass(frozen=True)
class Piece:
    """What moves as one: shapes in its own frame, by kind of surface (None: the body; else leg and wheel)."""

    shapes: dict[tuple[int | None, bool], shapes.Shape]


class Chain:
    """The legs of a whole body.

    Args:
        clip: of one frame with the joints known: its parts are what is shown.

    Attributes:
        pieces: the base, then one for each joint of the legs.
    """

    def __init__(self, clip: Clip) -> None:
        body, joints = whole_body_of(clip.robot), clip.joints
        if body is None or joints is None:
            raise ValueError("the whole body of this clip is not known")
        urdf = read_urdf(body.urdf)
        column = {name: number for number, name in enumerate(joints.names)}
        poses = link_poses(urdf, joints.names, joints.position, joints.base_position, joints.base_quaternion)
        still = link_poses(
            urdf, joints.names, 0.0 * joints.position, joints.base_position, joints.base_quaternion
        )
        elements = {element.get("name", ""): element for element in urdf.root.findall("joint")}
        root = Poses(matrix_from_quaternion(joints.base_quaternion), joints.base_position)
        carrier: dict[str, int] = {}  # link at the end of a joint → number of its piece
        frames = [(root, root)]
        self._joints: list[Joint] = []
        axes, columns = list[Array](), list[int]()
        for _, leg in body.leg_list():
            above = 0
            for joint in urdf.chain(leg.frame):
                if joint.name not in column or joint.kind == "fixed":
                    continue
                if joint.child not in carrier:
                    parent = frames[above][1]
                    R, p = _relative(parent, still[joint.child])
                    self._joints.append(Joint(above, R, p))
                    axes.append(axis_of(elements[joint.name]))
                    columns.append(column[joint.name])
                    carrier[joint.child] = len(frames)
                    frames.append((poses[joint.child], still[joint.child]))
                above = carrier[joint.child]
        self._axes, self._columns = np.reshape(axes, (-1, 3)), np.array(columns, dtype=np.intp)
        pieces: list[dict[tuple[int | None, bool], list[shapes.Shape]]] = [{} for _ in frames]
        for part in parts_of(clip):
            chain = [carrier[j.child] for j in urdf.chain(part.name) if j.child in carrier]
            number = chain[-1] if chain else 0
            pieces[number].setdefault((part.leg, part.wheel), []).append(
                _seen_from(frames[number][0], part, poses)
            )
        self.pieces = [Piece({key: shapes.joined(*each) for key, each in piece.items()}) for piece in pieces]

    def poses(self, body: Body) -> tuple[Array, Array]:
        """R (m, 3, 3) and p (m, 3) of the pieces, world."""
        R = np.empty((len(self.pieces), 3, 3))
        p = np.empty((len(self.pieces), 3))
        R[0], p[0] = matrix_from_quaternion(body.base_quaternion), body.base_position
        turns = matrix_from_axis(self._axes, body.joint_position[self._columns])  # at once: that is quick
        for number, (joint, turn) in enumerate(zip(self._joints, turns, strict=True), start=1):
            above = R[joint.parent]
            R[number] = above @ joint.R @ turn
            p[number] = p[joint.parent] + above @ joint.p
        return R, p


def _relative(parent: Poses, child: Poses) -> tuple[Array, Array]:
    """R and p of a frame in another one, at the first frame."""
    return parent.R[0].T @ child.R[0], parent.R[0].T @ (child.p[0] - parent.p[0])


def _seen_from(frame: Poses, part: Part, poses: dict[str, Poses]) -> shapes.Shape:
    R, p = _relative(frame, poses[part.name])
    vertices, faces = part.shape
    return vertices @ R.T + p, faces
