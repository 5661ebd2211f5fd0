"""Shapes as triangles: vertices (V, 3) in m, faces (F, 3). Nothing here knows a viewer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rollgait.plan.samples import Array
from rollgait.robot.robot import Robot

Faces = NDArray[np.uint32]
Shape = tuple[Array, Faces]

BODY_SCALE = 0.6
"""Corners of the body where the places of the hips are not known: this part of the nominal stance."""
NOSE = 0.08
"""How far the front of the body stands out in its middle, m."""
WHEEL_WIDTH = 0.55
"""Width of a wheel as a share of its radius."""
SPOKES = 5


def joined(*shapes: Shape) -> Shape:
    """Several shapes as one."""
    offsets = np.cumsum([0, *(len(vertices) for vertices, _ in shapes[:-1])])
    vertices = np.concatenate([vertices for vertices, _ in shapes])
    faces = np.concatenate([faces + offset for (_, faces), offset in zip(shapes, offsets, strict=True)])
    return vertices, faces.astype(np.uint32)


def prism(outline: Array, low: float, high: float) -> Shape:
    """An outline (n, 2), counter-clockwise and star-shaped about its mean, extended in z."""
    n = len(outline)
    middle = outline.mean(axis=0)
    ring = np.vstack([outline, middle])
    vertices = np.vstack([np.column_stack([ring, np.full(n + 1, z)]) for z in (low, high)])
    i, j = np.arange(n), (np.arange(n) + 1) % n
    top, bottom = n + 1, 0
    faces = np.concatenate(
        [
            np.stack([bottom + j, bottom + i, np.full(n, bottom + n)], axis=1),
            np.stack([top + i, top + j, np.full(n, top + n)], axis=1),
            np.stack([bottom + i, bottom + j, top + j], axis=1),
            np.stack([bottom + i, top + j, top + i], axis=1),
        ]
    )
    return vertices, faces.astype(np.uint32)


def box(edges: Array) -> Shape:
    """A box about its centre, edges (3,) along the axes, m."""
    x, y, z = 0.5 * np.asarray(edges)
    return prism(np.array([[-x, -y], [x, -y], [x, y], [-x, y]]), -z, z)


def revolved(profile: Array, segments: int = 32) -> Shape:
    """A profile (n, 2) of (radius, z), turned about z."""
    angle = 2.0 * np.pi * np.arange(segments) / segments
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    radius, z = profile.T
    vertices = np.stack([c * radius, s * radius, np.broadcast_to(z, (segments, len(z)))], axis=-1)
    n = len(profile)
    i, k = np.meshgrid(np.arange(segments), np.arange(n - 1), indexing="ij")
    here, ahead = (i * n + k).ravel(), (((i + 1) % segments) * n + k).ravel()
    faces = np.concatenate(
        [np.stack([here, ahead, ahead + 1], axis=1), np.stack([here, ahead + 1, here + 1], axis=1)]
    )
    a, b, c = (vertices.reshape(-1, 3)[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return vertices.reshape(-1, 3), faces[area > 1e-12].astype(np.uint32)  # at the axis there are none


def cylinder(segments: int = 12) -> Shape:
    """Of radius 1 about z from 0 to 1, closed."""
    return revolved(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), segments)


def rod(segments: int = 3) -> Shape:
    """Of radius 1 about z from 0 to 1, open at its ends."""
    return revolved(np.array([[1.0, 0.0], [1.0, 1.0]]), segments)


def cone(segments: int = 24) -> Shape:
    """Tip at the origin, opening along z: radius 1 at z = 1, open."""
    return revolved(np.array([[0.0, 0.0], [1.0, 1.0]]), segments)


def arrow_head(segments: int = 12) -> Shape:
    """A closed cone of radius 1 at z = 0 with its tip at z = 1."""
    return revolved(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), segments)


def ball(segments: int = 14) -> Shape:
    """Of radius 1."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, segments // 2 + 1)
    return revolved(np.column_stack([np.cos(angle), np.sin(angle)]), segments)


def ring(inner: float = 0.7, segments: int = 18) -> Shape:
    """A flat ring of outer radius 1 in the plane z = 0, seen from above."""
    return revolved(np.array([[1.0, 0.0], [inner, 0.0]]), segments)


def tyre(radius: float) -> Shape:
    """The tyre of a wheel about its axle, the y axis."""
    half = 0.5 * WHEEL_WIDTH * radius
    inner, tread = 0.72 * radius, 0.7 * half
    profile = [[inner, -half], [radius, -tread], [radius, tread], [inner, half], [inner, -half]]
    vertices, faces = revolved(np.array(profile), 28)
    return _axle_along_y(vertices), faces


def rim(radius: float) -> Shape:
    """Hub and spokes of a wheel about its axle, the y axis."""
    half = 0.4 * WHEEL_WIDTH * radius
    vertices, faces = cylinder(14)
    hub: Shape = (vertices * [0.26 * radius, 0.26 * radius, 2.2 * half] - [0.0, 0.0, 1.1 * half], faces)
    bar = np.array([[0.0, -0.07], [0.74, -0.05], [0.74, 0.05], [0.0, 0.07]]) * radius
    spoke, spoke_faces = prism(bar, -half, half)
    shapes: list[Shape] = [hub]
    for angle in 2.0 * np.pi * np.arange(SPOKES) / SPOKES:
        c, s = np.cos(angle), np.sin(angle)
        shapes.append((spoke @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]), spoke_faces))
    vertices, faces = joined(*shapes)
    return _axle_along_y(vertices), faces


def _axle_along_y(vertices: Array) -> Array:
    """z becomes y: a turn about x, so that the faces keep their outside."""
    return np.asarray(vertices[:, [0, 2, 1]] * [1.0, 1.0, -1.0])


def flat_arrow(length: float, width: float) -> Shape:
    """An arrow in the plane z = 0 from the origin along x, seen from above."""
    neck = 0.6 * length
    vertices = np.array(
        [
            [0.0, -0.22 * width],
            [neck, -0.22 * width],
            [neck, 0.22 * width],
            [0.0, 0.22 * width],
            [neck, -0.5 * width],
            [length, 0.0],
            [neck, 0.5 * width],
        ]
    )
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6]], dtype=np.uint32)
    return np.column_stack([vertices, np.zeros(len(vertices))]), faces


def hips(robot: Robot) -> Array:
    """Corners of the body from the CoM, base frame, (4, 2), m, legs in their order."""
    limbs = [leg.limb for leg in robot.leg_list]
    return np.array(
        [
            limb.hip[:2] if limb is not None else BODY_SCALE * place[:2]
            for limb, place in zip(limbs, robot.stance, strict=True)
        ]
    )


def outline(robot: Robot) -> Array:
    """The body from above, base frame, counter-clockwise from the front right, (5, 2), m."""
    fl, fr, hl, hr = hips(robot)
    nose = 0.5 * (fl + fr) + [NOSE, 0.0]
    return np.array([fr, nose, fl, hl, hr])


def body(robot: Robot) -> Shape:
    """The body about the CoM, base frame."""
    half = 0.09 * robot.height
    return prism(outline(robot), -half, half)
