"""A single rigid body with its feet as a URDF: what a motion without legs shows of its robot.

Feet are where the planner has them: in a frame at the CoM that turns with the base's yaw only, `base_level`.
Joints that no robot has lead there, roll and pitch back from the base, then x, y and z of the centre of each
wheel or foot; what steers and rolls follows as it does on the robot. So each pose of a plan is exactly one of
this robot, and its first joints are the planner's own coordinates.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Final

import numpy as np

from rollgait.export.motion import Sampled
from rollgait.plan.samples import Array, rate_of
from rollgait.robot.robot import Robot
from rollgait.robot.urdf_files import Urdf
from rollgait.ros.markers import (
    BALL_RADIUS,
    BODY_COLOUR,
    BODY_HEIGHT,
    BODY_SHARE,
    COLOURS,
    WHEEL_WIDTH,
    Colour,
)
from rollgait.ros.topics import BASE_LINK, LEGS

LEVEL: Final = "base_level"
"""The frame of the feet: that of the base, without its roll and pitch."""
AXES: Final = ("x", "y", "z")
RANGE: Final = 10.0
"""Limit of joints that no robot has, in their units: as good as none, for feet have boxes instead."""


def rigid_urdf(robot: Robot) -> Urdf:
    """The URDF of a robot without its legs."""
    root = ET.Element("robot", name=robot.name)
    base = _link(root, BASE_LINK)
    inertial = ET.SubElement(base, "inertial")
    ET.SubElement(inertial, "mass", value=_text(robot.mass))
    parts = robot.inertia
    moments = {f"i{key}": _text(getattr(parts, key)) for key in ("xx", "xy", "xz", "yy", "yz", "zz")}
    ET.SubElement(inertial, "inertia", moments)
    length, width = BODY_SHARE * np.ptp(robot.stance[:, :2], axis=0)
    box = ET.Element("box", size=f"{_text(length)} {_text(width)} {_text(BODY_HEIGHT)}")
    _visual(base, box, BODY_COLOUR)
    _joint(root, "base_roll_joint", BASE_LINK, "base_roll", "revolute", "1 0 0")
    _joint(root, "base_pitch_joint", "base_roll", LEVEL, "revolute", "0 1 0")
    for leg, name in enumerate(LEGS):
        _add_leg(root, robot, leg, name)
    return Urdf(Path(f"{robot.name}.urdf"), root)


def rigid_joints(s: Sampled) -> tuple[tuple[str, ...], Array, Array]:
    """The joints of that URDF: names, positions (n, n_j), and velocities (n, n_j)."""
    yaw, pitch, roll = s.samples.euler.T
    names, columns = ["base_roll_joint", "base_pitch_joint"], [-roll, -pitch]
    c, sine = np.cos(yaw), np.sin(yaw)
    for leg, name in enumerate(LEGS):
        x, y, z = (s.samples.foot_position[:, leg] - s.samples.com_position).T
        names += [f"{name}_{axis}_joint" for axis in AXES]
        columns += [c * x + sine * y, c * y - sine * x, z + s.robot.leg_list[leg].foot_radius]
    position = np.stack(columns, axis=1)
    velocity = rate_of(position, s.time)
    return (
        (*names, *s.joint_names),
        np.concatenate([position, s.joint_position], axis=1),
        np.concatenate([velocity, s.joint_velocity], axis=1),
    )


def _add_leg(root: ET.Element, robot: Robot, leg: int, name: str) -> None:
    data, parent = robot.leg_list[leg], LEVEL
    end = f"{name}_wheel" if data.has_wheel else f"{name}_foot"
    is_rolling = data.foot != "point"
    for axis, along in zip(AXES, ("1 0 0", "0 1 0", "0 0 1"), strict=True):
        child = end if axis == "z" and not is_rolling else f"{name}_{axis}"
        _joint(root, f"{name}_{axis}_joint", parent, child, "prismatic", along)
        parent = child
    if is_rolling:
        held = f"{name}_fork"
        if data.foot == "steerable":
            _joint(root, f"{name}_steering_joint", parent, held, "continuous", "0 0 1")
        else:
            _joint(root, f"{name}_heading_joint", parent, held, "fixed", yaw=data.heading)
        _joint(root, f"{name}_wheel_joint", held, end, "continuous", "0 1 0")
    radius = data.wheel_radius or BALL_RADIUS
    shape = (
        ET.Element("cylinder", radius=_text(radius), length=_text(WHEEL_WIDTH * radius))
        if data.has_wheel
        else ET.Element("sphere", radius=_text(radius))
    )
    _visual(root.findall("link")[-1], shape, COLOURS[leg], "1.5707963267948966 0 0")


def _link(root: ET.Element, name: str) -> ET.Element:
    return ET.SubElement(root, "link", name=name)


def _joint(
    root: ET.Element, name: str, parent: str, child: str, kind: str, axis: str = "", yaw: float = 0.0
) -> None:
    """A joint with the link that hangs on it."""
    joint = ET.SubElement(root, "joint", name=name, type=kind)
    ET.SubElement(joint, "origin", xyz="0 0 0", rpy=f"0 0 {_text(yaw)}")
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    if axis:
        ET.SubElement(joint, "axis", xyz=axis)
    if kind in ("revolute", "prismatic"):
        most = _text(RANGE)
        ET.SubElement(joint, "limit", lower=f"-{most}", upper=most, effort="0", velocity=most)
    _link(root, child)


def _visual(link: ET.Element, shape: ET.Element, colour: Colour, rpy: str = "0 0 0") -> None:
    visual = ET.SubElement(link, "visual")
    ET.SubElement(visual, "origin", xyz="0 0 0", rpy=rpy)
    ET.SubElement(visual, "geometry").append(shape)
    material = ET.SubElement(visual, "material", name=f"{link.get('name')}_colour")
    ET.SubElement(material, "color", rgba=" ".join(_text(part) for part in (*colour, 1.0)))


def _text(value: float) -> str:
    """All digits of a number."""
    return repr(float(value))
