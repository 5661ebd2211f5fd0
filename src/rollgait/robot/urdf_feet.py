"""The wheels and feet of a URDF, measured: radius and centre from shapes and meshes, where no one gave them.

A wheel's frame often lies at its joint, beside the tyre; a foot's at the knee. What touches the ground is
where the geometry is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import InputError
from rollgait.robot.urdf_files import Urdf
from rollgait.robot.urdf_shapes import Shape, below, moving_origin, numbers, origin_of, shapes_of, welded
from rollgait.robot.whole_body import LegJoints

Array = NDArray[np.float64]

ALONG_AXLE: Final = 0.98
"""Cosine above which a cylinder lies along the axle, and is the wheel."""

TREAD: Final = 0.95
"""What is farther from the axle than this share of the radius is tread: the wheel's middle is its middle."""

ROUND: Final = 0.15
"""Share by which the two larger half-sizes of a ball's mesh may differ."""

TIP: Final = 0.02
"""What is within this share of the farthest point of a link is its tip."""

GIVEN: Final = "given"


@dataclass(frozen=True)
class FootShape:
    """What of a leg touches the ground.

    Attributes:
        centre: of the wheel or ball, in the frame the leg names, (3,), m.
        axle: unit vector along the wheel's axle in that frame, (3,); zero for a point foot.
        radius: m; 0 for a tip without ball.
        source: where radius and centre are from.
        known: whether the URDF tells the radius; else it is taken for 0.
    """

    centre: Array
    axle: Array
    radius: float
    source: str
    known: bool = True


def measure_foot(urdf: Urdf, field: str, leg: LegJoints) -> FootShape:
    """The wheel or foot of a leg; what the leg gives itself is taken before what is measured.

    Args:
        urdf: the robot.
        field: what an error calls the leg.
        leg: names the frame; its `radius` and `centre` go before.

    Raises:
        InputError: a wheel has neither a radius of its own nor a shape that tells one.
    """
    found = _wheel(urdf, leg) if leg.wheel is not None else _foot(urdf, leg)
    if found is None and leg.radius is None:
        rule = "must be given: the URDF gives the wheel neither a cylinder nor a sphere nor a round mesh"
        raise InputError(f"{field}.radius", leg.frame, rule)
    axle = _axle(urdf, leg) if leg.wheel is not None else np.zeros(3)
    centre = np.zeros(3) if found is None else found.centre
    radius = leg.radius if leg.radius is not None else 0.0 if found is None else found.radius
    measured = "frame" if found is None else found.source
    return FootShape(
        centre=centre if leg.centre is None else np.array(leg.centre),
        axle=axle,
        radius=radius,
        source=measured if leg.radius is None else GIVEN,
        known=leg.radius is not None or (found is not None and found.known),
    )


# -- wheels --


def _wheel(urdf: Urdf, leg: LegJoints) -> FootShape | None:
    """The largest cylinder along the axle; else the largest sphere; else what is widest about the axle."""
    frame, axle = leg.frame, _axle(urdf, leg)
    poses = welded(urdf, frame)
    for part in ("collision", "visual"):
        shapes = list(shapes_of(urdf, poses, part))
        cylinders = [s for s in shapes if s.kind == "cylinder" and abs(s.R[:, 2] @ axle) > ALONG_AXLE]
        for name, alike in (("cylinder", cylinders), ("sphere", [s for s in shapes if s.kind == "sphere"])):
            if alike:
                widest = max(alike, key=lambda s: s.length("radius"))
                return _on_axle(urdf, leg, float(widest.p @ axle), widest.length("radius"), f"{part} {name}")
    for part in ("collision", "visual"):
        vertices = [s.points() for s in shapes_of(urdf, poses, part) if s.mesh is not None]
        if vertices:
            points = np.concatenate(vertices)
            along = points @ axle
            away = np.linalg.norm(points - along[:, None] * axle, axis=1)
            radius = float(away.max())
            tread = along[away > TREAD * radius]
            middle = 0.5 * float(tread.min() + tread.max())
            return _on_axle(urdf, leg, middle, round(radius, 4), f"{part} mesh")
    return None


def _on_axle(urdf: Urdf, leg: LegJoints, along: float, radius: float, source: str) -> FootShape:
    """A wheel with its middle so far along its axle; a frame below that of the joint is in the middle."""
    axle = _axle(urdf, leg)
    at_joint = urdf.chain(leg.frame)[-1].name == leg.wheel_joint
    return FootShape(along * axle if at_joint else np.zeros(3), axle, radius, f"URDF, {source}")


def _axle(urdf: Urdf, leg: LegJoints) -> Array:
    """Unit vector along the wheel's axle in the frame of the leg."""
    R = np.eye(3)
    for joint in reversed(urdf.chain(leg.frame)):
        element = urdf.joint_elements[joint.name]
        if joint.name == leg.wheel_joint:
            axis = element.find("axis")
            direction = numbers("1 0 0" if axis is None else axis.get("xyz", "1 0 0"))
            return np.asarray(R.T @ direction / np.linalg.norm(direction))
        R = origin_of(element)[0] @ R
    raise InputError("legs.wheel_joint", leg.wheel_joint, f"is not a joint above {leg.frame}")


# -- point feet --


def _foot(urdf: Urdf, leg: LegJoints) -> FootShape:
    """The ball at the end of a leg; else its tip."""
    own = below(urdf, leg.frame)
    above = {name: pose for name, pose in welded(urdf, leg.frame).items() if name not in own}
    knee = moving_origin(urdf, leg.frame)
    for part in ("collision", "visual"):
        balls = [(s.p, s.length("radius")) for s in shapes_of(urdf, own, part) if s.kind == "sphere"]
        balls += [b for s in shapes_of(urdf, own, part) if s.kind == "capsule" for b in _ends(s)]
        if balls:
            centre, radius = max(balls, key=lambda ball: float(np.linalg.norm(ball[0] - knee) + ball[1]))
            return FootShape(centre, np.zeros(3), radius, f"URDF, {part} sphere")
    for part in ("collision", "visual"):
        for s in shapes_of(urdf, above, part):
            if s.kind == "sphere" and np.linalg.norm(s.p) <= s.length("radius"):
                return FootShape(s.p, np.zeros(3), s.length("radius"), f"URDF, {part} sphere of the shank")
    if np.linalg.norm(knee) > 1e-6:  # the frame is no joint's: a foot of its own
        return _ball_of_mesh(urdf, own) or _unknown(np.zeros(3))
    points = [
        s.points()
        for part in ("collision", "visual")
        for s in shapes_of(urdf, own, part)
        if s.kind != "sphere"
    ]
    if not points:
        return _unknown(np.zeros(3))
    away = np.linalg.norm(np.concatenate(points) - knee, axis=1)
    return _unknown(np.concatenate(points)[away > (1.0 - TIP) * away.max()].mean(axis=0))


def _unknown(tip: Array) -> FootShape:
    where = "its frame" if not tip.any() else "the tip of its link"
    return FootShape(
        tip, np.zeros(3), 0.0, f"no ball in the URDF: {where} is taken for the contact", known=False
    )


def _ball_of_mesh(urdf: Urdf, poses: dict[str, tuple[Array, Array]]) -> FootShape | None:
    for part in ("collision", "visual"):
        for s in shapes_of(urdf, poses, part):
            if s.mesh is None:
                continue
            points = s.points()
            half = 0.5 * np.ptp(points, axis=0)
            _, second, largest = np.sort(half)
            if second >= (1.0 - ROUND) * largest:
                centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
                return FootShape(centre, np.zeros(3), round(float(largest), 4), f"URDF, {part} mesh")
    return None


def _ends(capsule: Shape) -> Iterator[tuple[Array, float]]:
    for end in capsule.points():
        yield end, capsule.length("radius")
