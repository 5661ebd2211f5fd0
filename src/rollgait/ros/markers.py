"""Markers: what there is to see of a motion besides the robot, for RViz and Foxglove."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rollgait.robot.robot import Robot
from rollgait.ros.messages import Array, Fields, header, pose, vector

Colour = tuple[float, float, float]

ARROW: Final = 0
CUBE: Final = 1
SPHERE: Final = 2
CYLINDER: Final = 3
TRIANGLES: Final = 11
"""Kinds of markers, `visualization_msgs/Marker`."""

COLOURS: Final[tuple[Colour, ...]] = (
    (0.0, 0.447, 0.698),
    (0.835, 0.369, 0.0),
    (0.0, 0.620, 0.451),
    (0.8, 0.475, 0.655),
)
"""Of the legs, FL, FR, HL, HR: those of the figures."""
BODY_COLOUR: Final[Colour] = (0.25, 0.27, 0.3)
BODY_HEIGHT: Final = 0.14
"""Of the box that stands for the body, m."""
BODY_SHARE: Final = 0.7
"""Of the distance between the feet that the box has."""
FORCE_SCALE: Final = 1.0e-3
"""Length of the arrow of a force, m/N."""
ARROW_SIZE: Final = np.array([0.02, 0.045, 0.08])
"""Diameter of the shaft, diameter and length of the head, m."""
BALL_RADIUS: Final = 0.035
"""Of a point foot whose radius is not known, m."""
WHEEL_WIDTH: Final = 0.5
"""Of a wheel, in its radius."""
FOOTHOLD_SIZE: Final = np.array([0.06, 0.06, 0.004])
"""Of the disc that marks where a foot shall land, m."""
UPRIGHT: Final = np.array([0.0, 0.0, 0.0, 1.0])
"""Quaternion of no turn."""


def colour(values: Colour, alpha: float = 1.0) -> Fields:
    """`std_msgs/ColorRGBA`."""
    r, g, b = values
    return {"r": float(r), "g": float(g), "b": float(b), "a": alpha}


def marker(
    time: int,
    frame: str,
    namespace: str,
    number: int,
    kind: int,
    size: Array,
    tint: Colour,
    place: Fields | None = None,
) -> Fields:
    """`visualization_msgs/Marker` that stays until another of its number comes."""
    return {
        "header": header(time, frame),
        "ns": namespace,
        "id": number,
        "type": kind,
        "pose": place or pose(np.zeros(3)),
        "scale": vector(size),
        "color": colour(tint),
    }


def triangles(time: int, frame: str, namespace: str, corners: Array, colours: NDArray[Any]) -> Fields:
    """A marker of coloured triangles: corners (n, 3, 3), m, and colours (n, 3), 0 … 255."""
    result = marker(time, frame, namespace, 0, TRIANGLES, np.ones(3), (1.0, 1.0, 1.0))
    result["points"] = [vector(p) for p in corners.reshape(-1, 3)]
    result["colors"] = [colour(tuple(c)) for c in np.repeat(colours / 255.0, 3, axis=0).tolist()]
    return result


def robot_markers(
    time: int,
    frame: str,
    robot: Robot,
    com_position: Array,
    com_quaternion: Array,
    foot_position: Array,
    wheel_quaternion: Array,
    force: Array,
) -> Fields:
    """`visualization_msgs/MarkerArray`: body, feet and forces of a single rigid body.

    Args:
        time: ns.
        frame: of the world, in which all that follows is given.
        robot: the planner's robot.
        com_position, com_quaternion: of the base, (3,), m, and (4,).
        foot_position: lowest points of the rims, (4, 3), m.
        wheel_quaternion: of the wheels, axle along y, (4, 4).
        force: on the robot, (4, 3), N.
    """
    length, width = BODY_SHARE * np.ptp(robot.stance[:, :2], axis=0)
    body = np.array([length, width, BODY_HEIGHT])
    found = [marker(time, frame, "body", 0, CUBE, body, BODY_COLOUR, pose(com_position, com_quaternion))]
    on_side = Rotation.from_euler("X", np.pi / 2)
    for leg, tint in enumerate(COLOURS):
        data = robot.leg_list[leg]
        radius = data.wheel_radius or BALL_RADIUS
        turn = (Rotation.from_quat(wheel_quaternion[leg]) * on_side).as_quat()
        centre = pose(foot_position[leg] + np.array([0.0, 0.0, radius]), turn)
        kind, width = (CYLINDER, WHEEL_WIDTH * radius) if data.has_wheel else (SPHERE, 2.0 * radius)
        size = np.array([2.0 * radius, 2.0 * radius, width])
        found.append(marker(time, frame, "feet", leg, kind, size, tint, centre))
        found.append(force_marker(time, frame, leg, foot_position[leg], force[leg]))
    return {"markers": found}


def force_marker(time: int, frame: str, leg: int, place: Array, force: Array) -> Fields:
    """The arrow of a force (3,), N, at a place (3,), m; `FORCE_SCALE` says how long."""
    arrow = marker(time, frame, "forces", leg, ARROW, ARROW_SIZE, COLOURS[leg])
    arrow["points"] = [vector(place), vector(place + FORCE_SCALE * force)]
    return arrow


def foothold_markers(time: int, frame: str, places: Sequence[tuple[int, Array, Array]]) -> Fields:
    """`visualization_msgs/MarkerArray`: a disc for each foothold.

    Args:
        time: ns.
        frame: of the world.
        places: number of the leg, place (3,), m, and normal of the ground (3,) of each foothold.
    """
    found = []
    for number, (leg, place, normal) in enumerate(places):
        turn = Rotation.align_vectors([normal], [[0.0, 0.0, 1.0]])[0].as_quat()
        found.append(
            marker(time, frame, "footholds", number, CYLINDER, FOOTHOLD_SIZE, COLOURS[leg], pose(place, turn))
        )
    return {"markers": found}
