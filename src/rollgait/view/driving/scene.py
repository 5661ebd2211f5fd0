"""What is seen of a drive: the robot as it is now, the forces on it, what is asked for, what is predicted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from viser import BatchedMeshHandle, MeshHandle, SceneApi

from rollgait.plan.samples import Array, Samples, level_contact
from rollgait.robot.robot import Robot
from rollgait.terrain import Terrain
from rollgait.view import shapes
from rollgait.view.arrows import Arrows, arrow_poses
from rollgait.view.clip import Clip, Joints
from rollgait.view.driving.chain import Chain
from rollgait.view.driving.messages import Snapshot
from rollgait.view.layers.contact import FORCE_LENGTH
from rollgait.view.layers.ground import GRID, add_terrain
from rollgait.view.layers.layer import NOWHERE, SOLID, linear, rgb, single
from rollgait.view.layers.paths import RING, THICK
from rollgait.view.layers.robot import TYRE_COLOUR
from rollgait.view.layers.robot import Robot as PlannedRobot
from rollgait.view.meshes import COLOUR, whole_body_of
from rollgait.view.on_ground import ABOVE, is_plane, normals, on_ground
from rollgait.view.rotations import from_z_to, turn_z, wxyz
from rollgait.view.style import BASE_COLOUR, GOAL_COLOUR, LEG_COLOURS

GROUND_SIZE: Final = 12
"""Edge of the ground around the robot, m; a plane moves along by whole metres."""
DRAWN_ANEW: Final = 3.0
"""So far from its middle, m, the robot gets new ground around it, where that is no plane."""
SECONDS_AHEAD: Final = 1.2
"""The arrow of the command is the way in this time at this velocity, s."""
ARC_RADIUS: Final = 0.65
"""Of the arc that shows the turn rate, m."""
LOW: Final = 0.06
"""Height of arrow and arc over the ground, m."""
ARC_PARTS: Final = 12
BESIDE: Final = 0.15
"""How far outside of its foot a contact force is drawn, m: within the leg nobody would see it."""
PUSH_LENGTH: Final = 9.0
"""Of the arrow of a push as large as the robot's weight, in heights of the robot."""
PUSH_GAP: Final = 0.35
"""Between the tip of that arrow and the CoM, m: it must not end within the body."""
PUSH_COLOUR: Final = "#7B1FA2"
UP: Final = np.array([0.0, 0.0, ABOVE])
SWINGS: Final = 2
"""Footholds shown of each leg."""


class Pieces:
    """The whole body, piece by piece."""

    def __init__(self, scene: SceneApi, path: str, clip: Clip) -> None:
        self._chain = Chain(clip)
        self._frames = []
        self.handles: list[MeshHandle | BatchedMeshHandle] = []
        for number, piece in enumerate(self._chain.pieces):
            frame = scene.add_frame(f"{path}/{number}", show_axes=False)
            self._frames.append(frame)
            for (leg, wheel), shape in piece.shapes.items():
                colour = COLOUR if leg is None else TYRE_COLOUR if wheel else LEG_COLOURS[leg]
                name = f"{path}/{number}/{'body' if leg is None else 'wheel' if wheel else 'leg'}"
                handle = scene.add_mesh_simple(name, *shape, color=rgb(colour), flat_shading=True)
                if number == 0:
                    self.handles.append(handle)

    def show(self, snapshot: Snapshot) -> None:
        """Moves all pieces."""
        if snapshot.body is None:
            return
        R, p = self._chain.poses(snapshot.body)
        for frame, turn, place in zip(self._frames, wxyz(R), p, strict=True):
            frame.wxyz, frame.position = turn, place


class Planned:
    """The robot as the planner sees it, where no meshes or no joints are known."""

    def __init__(self, scene: SceneApi, path: str, clip: Clip) -> None:
        self._layer = PlannedRobot(scene, path, clip, SOLID)
        self._robot = clip.robot
        self.handles: list[MeshHandle | BatchedMeshHandle] = [self._layer.body.handle]

    def show(self, snapshot: Snapshot) -> None:
        """Moves all parts."""
        self._layer.place(clip_of(self._robot, snapshot), snapshot.wheel_angle[None])
        self._layer.show(0)


class LiveScene:
    """The scene of a drive.

    Args:
        scene: where it is drawn.
        robot: that is driven.
        snapshot: how it begins.
        terrain: the ground; if none, a plane under the feet.

    Attributes:
        follows: whether the robot stays in the middle and the ground moves.
        grips: what of the robot can be clicked and dragged: its base.
    """

    def __init__(
        self, scene: SceneApi, robot: Robot, snapshot: Snapshot, terrain: Terrain | None = None
    ) -> None:
        self._scene, self._robot = scene, robot
        self.follows = True
        self._root = scene.add_frame("/drive", show_axes=False)
        self._terrain = terrain or Terrain(float(snapshot.state.foot_position[:, 2].min()))
        self._middle = np.round(snapshot.state.com_position[:2])
        self._ground = self._add_ground()
        clip = clip_of(robot, snapshot)
        with_meshes = snapshot.body is not None and whole_body_of(robot) is not None
        self._body = (Pieces if with_meshes else Planned)(scene, "/drive/robot", clip)
        self.grips = self._body.handles
        self._shown: dict[str, Any] = {}
        self._moves: dict[str, Callable[[Snapshot], None]] = {}
        self._add_forces(snapshot)
        self._add_command(snapshot)
        self._add_prediction(snapshot)
        self.show(snapshot)

    @property
    def layers(self) -> tuple[str, ...]:
        """What can be switched off."""
        return tuple(self._shown)

    def switch(self, title: str, shown: bool) -> None:
        """Switches a layer on or off."""
        self._shown[title].visible = shown

    def show(self, snapshot: Snapshot) -> None:
        """Moves everything to where it is now."""
        x, y, _ = snapshot.state.com_position.tolist()
        if self.follows:
            self._root.position = (-x, -y, 0.0)
        self._move_ground(snapshot.state.com_position[:2])
        self._body.show(snapshot)
        for title, move in self._moves.items():
            if self._shown[title].visible:
                move(snapshot)

    # -- the layers --

    def _layer(self, title: str, move: Callable[[Snapshot], None]) -> str:
        path = f"/drive/{title.replace(' ', '-')}"
        self._shown[title] = self._scene.add_frame(path, show_axes=False)
        self._moves[title] = move
        return path

    def _add_ground(self) -> Any:
        if is_plane(self._terrain):
            return self._scene.add_grid(
                "/drive/ground",
                width=GROUND_SIZE,
                height=GROUND_SIZE,
                cell_size=0.5,
                position=(*self._middle.tolist(), self._terrain.level),
                **GRID,
            )
        half = 0.5 * GROUND_SIZE
        frame = self._scene.add_frame("/drive/ground", show_axes=False)
        add_terrain(self._scene, "/drive/ground", self._terrain, self._middle - half, self._middle + half)
        return frame

    def _move_ground(self, place: Array) -> None:
        """Keeps ground around the robot."""
        if is_plane(self._terrain):
            if self.follows:
                self._ground.position = (*np.round(place).tolist(), self._terrain.level)
        elif np.abs(place - self._middle).max() > DRAWN_ANEW:
            self._middle = np.round(place)
            self._ground.remove()
            self._ground = self._add_ground()

    def _add_forces(self, snapshot: Snapshot) -> None:
        scale = FORCE_LENGTH * self._robot.height / self._robot.weight

        def poses(s: Snapshot) -> Any:
            outwards = s.state.foot_position - s.state.com_position
            outwards[:, 2] = 0.0
            beside = BESIDE * outwards / np.linalg.norm(outwards, axis=1, keepdims=True)
            return arrow_poses(s.state.foot_position + beside, scale * s.force)

        path = self._layer("contact forces", lambda s: arrows.move(poses(s)))
        arrows = Arrows(self._scene, path, poses(snapshot), SOLID.legs())

    def _add_command(self, snapshot: Snapshot) -> None:
        """What is asked for, and the push."""
        colours = linear([rgb(GOAL_COLOUR), rgb(PUSH_COLOUR)])
        scale = PUSH_LENGTH * self._robot.height / self._robot.weight

        def poses(s: Snapshot) -> Any:
            ahead = np.array([s.command.forward, s.command.lateral, 0.0]) * SECONDS_AHEAD
            place = s.state.com_position
            ends = on_ground(self._terrain, np.stack([place, place + turn_z(s.state.euler[0]) @ ahead]), LOW)
            push = scale * s.pushed
            length = float(np.linalg.norm(push))
            tail = place - push * (1.0 + PUSH_GAP / max(length, PUSH_GAP))
            return arrow_poses(np.stack([ends[0], tail]), np.stack([ends[1] - ends[0], push]))

        def arc(s: Snapshot) -> Array:
            angle = np.linspace(0.0, s.command.turn_rate * SECONDS_AHEAD, ARC_PARTS + 1) + s.state.euler[0]
            around = ARC_RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)
            return on_ground(self._terrain, s.state.com_position[:2] + around, LOW)

        def move(s: Snapshot) -> None:
            arrows.move(poses(s))
            rods.move(*_ends(arc(s)[None]))

        path = self._layer("command", move)
        arrows = Arrows(self._scene, path, poses(snapshot), colours)
        rods = Rods(self._scene, f"{path}/arc", [GOAL_COLOUR] * ARC_PARTS, 2.0 * THICK)

    def _add_prediction(self, snapshot: Snapshot) -> None:
        """Where the CoM and the feet shall go, and where they shall touch down."""
        count = len(snapshot.com_path) - 1
        rings, faces = shapes.ring()

        def lines(s: Snapshot) -> Array:
            com = on_ground(self._terrain, s.com_path, 0.0)  # under the robot: within it nobody would see it
            return np.asarray(np.concatenate([com[None], s.foot_path.transpose(1, 0, 2)]) + UP)

        def move(s: Snapshot) -> None:
            rods.move(*_ends(lines(s)))
            places, seen = footholds(s)
            marks.batched_positions = single(on_ground(self._terrain, places))
            marks.batched_wxyzs = single(wxyz(from_z_to(normals(self._terrain, places))))
            marks.batched_scales = single(np.where(seen, 1.0, NOWHERE))

        path = self._layer("prediction", move)
        colours = np.repeat([BASE_COLOUR, *LEG_COLOURS], count).tolist()
        rods = Rods(self._scene, f"{path}/paths", colours, THICK)
        marks: Any = self._scene.add_batched_meshes_simple(
            f"{path}/footholds",
            rings * RING,
            faces,
            batched_wxyzs=single(np.tile([1.0, 0.0, 0.0, 0.0], (4 * SWINGS, 1))),
            batched_positions=single(np.zeros((4 * SWINGS, 3))),
            batched_scales=single(np.full(4 * SWINGS, NOWHERE)),
            batched_colors=np.repeat(SOLID.legs(), SWINGS, axis=0),
            side="double",
            lod="off",
            cast_shadow=False,
        )


class Rods:
    """Straight rods that move together."""

    def __init__(self, scene: SceneApi, path: str, colours: list[str], thickness: float) -> None:
        vertices, faces = shapes.rod()
        self._half = 0.5 * thickness
        many = len(colours)
        self._handle = scene.add_batched_meshes_simple(
            path,
            vertices,
            faces,
            batched_wxyzs=single(np.tile([1.0, 0.0, 0.0, 0.0], (many, 1))),
            batched_positions=single(np.zeros((many, 3))),
            batched_scales=single(np.full((many, 3), NOWHERE)),
            batched_colors=linear([rgb(colour) for colour in colours]),
            lod="off",
            cast_shadow=False,
            receive_shadow=False,
        )

    def move(self, begin: Array, end: Array) -> None:
        """From points to points, (n, 3)."""
        way = end - begin
        length = np.linalg.norm(way, axis=1)
        seen = length > ABOVE
        way[~seen] = [0.0, 0.0, 1.0]
        width = np.where(seen, self._half, NOWHERE)
        self._handle.batched_positions = single(begin)
        self._handle.batched_wxyzs = single(wxyz(from_z_to(way)))
        self._handle.batched_scales = single(np.column_stack([width, width, np.where(seen, length, NOWHERE)]))


def footholds(snapshot: Snapshot) -> tuple[Array, Array]:
    """Where the feet are predicted to touch down, (4 · SWINGS, 3), and which of these are any."""
    places, seen = np.zeros((4, SWINGS, 3)), np.zeros((4, SWINGS), dtype=bool)
    contact = snapshot.foot_contact
    for leg in range(4):
        landings = np.flatnonzero(~contact[:-1, leg] & contact[1:, leg])[:SWINGS]
        for number, node in enumerate(landings):
            places[leg, number] = snapshot.foot_path[node + 1, leg]
            seen[leg, number] = True
    return places.reshape(-1, 3), seen.reshape(-1)


def clip_of(robot: Robot, snapshot: Snapshot) -> Clip:
    """A clip of one frame."""
    state, body = snapshot.state, snapshot.body
    samples = Samples(
        time=np.array([state.time]),
        com_position=state.com_position[None],
        euler=state.euler[None],
        com_velocity=state.com_velocity[None],
        euler_rate=state.euler_rate[None],
        foot_position=state.foot_position[None],
        foot_velocity=np.zeros((1, 4, 3)),
        heading=state.heading[None],
        heading_rate=np.zeros((1, 4)),
        speed=state.speed[None],
        force=snapshot.force[None],
        contact=snapshot.contact[None],
        **level_contact(state.foot_position[None]),
    )
    joints = None
    if body is not None:
        parts = (body.base_position, body.base_quaternion, body.joint_position)
        joints = Joints(snapshot.joint_names, *(values[None] for values in parts))
    return Clip("drive", "drive", robot, samples, Terrain(), (), (), "", True, joints)


def _ends(lines: Array) -> tuple[Array, Array]:
    """Ends of the segments of lines (m, n, 3): twice (m · (n − 1), 3)."""
    return lines[:, :-1].reshape(-1, 3), lines[:, 1:].reshape(-1, 3)
