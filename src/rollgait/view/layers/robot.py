"""The robot as the planner sees it: body, legs, wheels or point feet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from viser import BatchedMeshHandle

from rollgait.plan.samples import Array
from rollgait.view import shapes
from rollgait.view.clip import Clip
from rollgait.view.layers.layer import Layer, Moving, linear, single
from rollgait.view.rotations import from_z_to, matrix_from_axis, matrix_from_euler, turn_z, wxyz

LEG_RADIUS = 0.017
"""m"""
POINT_FOOT = 0.035
"""Radius at which a point foot is drawn of which none is known, m."""
BODY_COLOUR = "#3A3F47"
LEG_COLOUR = "#7A828C"
TYRE_COLOUR = "#22252A"
NOSE_COLOUR = "#E8EAED"


class Robot(Layer):
    """Body, legs and wheels, drawn from the plan."""

    title = "robot"
    for_ghost = True

    def draw(self) -> None:
        self.place(self.clip, self.clip.wheel_angle)
        opacity = self.look.opacity
        body = shapes.body(self.clip.robot)
        colour = self.look.of(BODY_COLOUR)
        self.body = Moving(self.scene, self.at("body"), body, colour, opacity=opacity, flat_shading=True)
        vertices, faces = shapes.ball()
        nose, colour = (0.03 * vertices, faces), self.look.of(NOSE_COLOUR)
        self.nose = Moving(self.scene, self.at("nose"), nose, colour, opacity=opacity)
        self._legs()
        self._feet()
        self.show(0)

    def place(self, clip: Clip, wheel_angle: Array) -> None:
        """Where everything is in the frames of a clip; angles of the wheels (n, 4), rad."""
        s, robot = clip.samples, clip.robot
        R = matrix_from_euler(s.euler)
        self._base = s.com_position, wxyz(R)
        fl, fr, *_ = shapes.hips(robot)
        front = np.append(0.5 * (fl + fr) + [shapes.NOSE, 0.0], 0.0)
        self._front = s.com_position + R @ front  # a light, so that front and back are told apart
        hip = np.concatenate([shapes.hips(robot), np.zeros((4, 1))], axis=1)
        self._leg_from = s.com_position[:, None] + np.einsum("nij,lj->nli", R, hip)
        way = _ankles(clip) - self._leg_from
        length = np.linalg.norm(way, axis=-1)
        self._leg_turn = wxyz(from_z_to(way.reshape(-1, 3))).reshape(-1, 4, 4)
        self._leg_scale = np.stack([np.full_like(length, LEG_RADIUS)] * 2 + [length], axis=-1)
        spin = np.stack([matrix_from_axis(np.array([0.0, 1.0, 0.0]), wheel_angle[:, i]) for i in range(4)], 1)
        self._foot_turn = wxyz(turn_z(_headings(clip)) @ spin)
        self._centre = s.foot_position + [0.0, 0.0, 1.0] * _radii(clip)[:, None]

    def _legs(self) -> None:
        vertices, faces = shapes.cylinder()
        self.legs = self.scene.add_batched_meshes_simple(
            self.at("legs"),
            vertices,
            faces,
            batched_wxyzs=single(self._leg_turn[0]),
            batched_positions=single(self._leg_from[0]),
            batched_scales=single(self._leg_scale[0]),
            batched_colors=linear([self.look.of(LEG_COLOUR)])[0],
            opacity=self.look.opacity,
            lod="off",
        )

    def _feet(self) -> None:
        """Wheels that turn, all in one batch per part, as each object costs time; balls for point feet."""
        legs = self.clip.robot.leg_list
        self._wheel_legs = [i for i, leg in enumerate(legs) if leg.has_wheel]
        self.wheels = []
        if self._wheel_legs:
            tyres = linear([self.look.of(TYRE_COLOUR)] * len(self._wheel_legs))
            self.wheels.append(self._wheel_part("tyres", shapes.tyre(1.0), tyres))
            self.wheels.append(self._wheel_part("rims", shapes.rim(1.0), self.look.legs()[self._wheel_legs]))
        self.balls = []
        vertices, faces = shapes.ball()
        for leg in set(range(4)) - set(self._wheel_legs):
            shape = vertices * (legs[leg].wheel_radius or POINT_FOOT), faces
            colour = self.look.leg(leg)
            ball = Moving(self.scene, self.at(f"foot{leg}"), shape, colour, opacity=self.look.opacity)
            self.balls.append((leg, ball))

    def _wheel_part(self, name: str, shape: shapes.Shape, colours: NDArray[np.uint8]) -> BatchedMeshHandle:
        """A part of all wheels; the shape is that of a wheel of radius 1."""
        vertices, faces = shape
        legs = self._wheel_legs
        return self.scene.add_batched_meshes_simple(
            self.at(name),
            vertices,
            faces,
            batched_wxyzs=single(self._foot_turn[0, legs]),
            batched_positions=single(self._centre[0, legs]),
            batched_scales=single(_radii(self.clip)[legs]),
            batched_colors=colours,
            opacity=self.look.opacity,
            flat_shading=True,
            lod="off",
            cast_shadow=name == "tyres",  # the rim's would lie within it
        )

    def show(self, index: int) -> None:
        position, turn = self._base
        self.body.move(position[index], turn[index])
        self.nose.move(self._front[index])
        self.legs.batched_positions = single(self._leg_from[index])
        self.legs.batched_wxyzs = single(self._leg_turn[index])
        self.legs.batched_scales = single(self._leg_scale[index])
        legs = self._wheel_legs
        for part in self.wheels:
            part.batched_positions = single(self._centre[index, legs])
            part.batched_wxyzs = single(self._foot_turn[index, legs])
        for leg, ball in self.balls:
            ball.move(self._centre[index, leg])


def _radii(clip: Clip) -> Array:
    """From the contact point to the centre of the wheel or of the ball, (4,), m."""
    return np.array([leg.wheel_radius or POINT_FOOT for leg in clip.robot.leg_list])


def _ankles(clip: Clip) -> Array:
    """Where the legs end: at the top of the wheel or in the ball, (n, 4, 3), m."""
    share = np.array([1.6 if leg.has_wheel else 1.0 for leg in clip.robot.leg_list])
    return np.asarray(clip.samples.foot_position + [0.0, 0.0, 1.0] * (share * _radii(clip))[:, None])


def _headings(clip: Clip) -> Array:
    """Headings of the wheels, (n, 4), rad; a locked one keeps that of the base."""
    locked = np.array([leg.foot == "point" for leg in clip.robot.leg_list])
    return np.where(locked, clip.samples.euler[:, :1], clip.samples.heading)
