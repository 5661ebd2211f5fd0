"""What an import says of a robot, looked at by pinocchio alone, from the URDF as its owner wrote it.

Shares no code with the import: mass and CoM by pinocchio, radii and centres by its shapes, the reach by a
bounded least-squares search over the joints of each leg.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import yaml
from numpy.typing import NDArray
from scipy.optimize import least_squares

Array = NDArray[np.float64]

NAMES = ("FL", "FR", "HL", "HR")


@dataclass(frozen=True)
class Differences:
    """Of what was imported from what pinocchio finds, the largest of the four legs where there are four.

    Attributes:
        mass: share of the mass.
        radius: m; None where the shape of no foot says it, which is then a mesh.
        track: between left and right wheels or balls, m.
        reach: distance of a foot from where it should be, at its nominal place and at the corners of its box,
            m.
    """

    mass: float
    radius: float | None
    track: float
    reach: float


@dataclass(frozen=True)
class Shape:
    """A wheel or a ball: radius (m; None if unknown), centre and axle in the frame of its joint."""

    radius: float | None
    centre: Array
    axle: Array | None


def compare(urdf: Path, robot: Path, legs: Path) -> Differences:
    """The files of an import with the URDF that they are from.

    Args:
        urdf: as its owner wrote it.
        robot: the robot's file.
        legs: the file that describes its legs.
    """
    said, described = (yaml.safe_load(file.read_text(encoding="utf-8")) for file in (robot, legs))
    model = pin.buildModelFromUrdf(str(urdf), pin.JointModelFreeFlyer())
    data = model.createData()
    q = pin.neutral(model)
    for name, angle in described["joints"].items():
        _turn(model, q, model.getJointId(name), angle)
    pin.framesForwardKinematics(model, data, q)
    com = pin.centerOfMass(model, data, q).copy()
    shapes = [_shape(model, urdf, described["legs"][name]) for name in NAMES]
    stance = np.array([said["legs"][name]["stance"] for name in NAMES])
    radii = [said["legs"][name].get("wheel_radius", 0.0) for name in NAMES]
    known = [abs(s.radius - r) for s, r in zip(shapes, radii, strict=True) if s.radius is not None]
    worst, places = 0.0, np.zeros((4, 3))
    for k, (name, shape) in enumerate(zip(NAMES, shapes, strict=True)):
        box = said["legs"][name].get("box") or [[-b, b] for b in said["box"]]
        for corner in ((0.0, 0.0, 0.0), *product(*box)):
            target = com + stance[k] + corner
            place, missing = _reached(model, data, q, described["legs"][name], shape, radii[k], target)
            worst = max(worst, missing)
            places[k] = place if not any(corner) else places[k]
    tracks = np.abs([places[0, 1] - places[1, 1], places[2, 1] - places[3, 1]])
    widths = np.array([stance[0, 1] - stance[1, 1], stance[2, 1] - stance[3, 1]])
    return Differences(
        abs(said["mass"] / pin.computeTotalMass(model) - 1.0),
        max(known) if known else None,
        float(np.max(np.abs(tracks - widths))),
        worst,
    )


def _frame(model: Any, leg: dict[str, Any]) -> Any:
    return model.frames[model.getFrameId(leg.get("wheel") or leg["foot"])]


def _shape(model: Any, urdf: Path, leg: dict[str, Any]) -> Shape:
    """By the shapes of the foot's link or of the shank it is glued to; else as the file of legs says."""
    frame = _frame(model, leg)
    centre = frame.placement.act(np.array(leg.get("centre", [0.0, 0.0, 0.0])))
    axle = None
    if "wheel" in leg:
        axis = ElementTree.parse(urdf).find(f"joint[@name='{leg['wheel_joint']}']/axis")
        axle = np.array([1.0, 0.0, 0.0]) if axis is None else np.fromstring(axis.get("xyz", ""), sep=" ")
        axle /= np.linalg.norm(axle)
    geometry = pin.buildGeomFromUrdfString(model, _without_meshes(urdf), pin.GeometryType.COLLISION)
    import coal

    found = [
        (float(shape.geometry.radius), shape.placement.translation)
        for shape in geometry.geometryObjects
        if shape.parentJoint == frame.parentJoint
        and isinstance(shape.geometry, coal.Cylinder if axle is not None else coal.Sphere)
    ]
    if not found:
        return Shape(None, centre, axle)
    radius, place = min(found, key=lambda each: float(np.linalg.norm(each[1] - centre)))
    return Shape(radius, np.asarray(place), axle)


def _without_meshes(urdf: Path) -> str:
    """A URDF as text without shapes that are meshes, of which there may be no files."""
    tree = ElementTree.parse(urdf)
    for link in tree.iter("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            if shape.find("geometry/mesh") is not None:
                link.remove(shape)
    return ElementTree.tostring(tree.getroot(), encoding="unicode")


def _turn(model: Any, q: Array, joint: int, angle: float) -> None:
    """Sets the angle of a joint, rad; of one that turns all around its cosine and sine."""
    place = model.joints[joint].idx_q
    if model.joints[joint].nq == 1:
        q[place] = angle
    else:
        q[place : place + 2] = np.cos(angle), np.sin(angle)


def _angle(model: Any, q: Array, joint: int) -> float:
    place = model.joints[joint].idx_q
    return float(q[place] if model.joints[joint].nq == 1 else np.arctan2(q[place + 1], q[place]))


def _limits(model: Any, joint: int) -> tuple[float, float]:
    place = model.joints[joint].idx_q
    if model.joints[joint].nq > 1:
        return -2.0 * np.pi, 2.0 * np.pi
    return float(model.lowerPositionLimit[place]), float(model.upperPositionLimit[place])


def _reached(
    model: Any, data: Any, q: Array, leg: dict[str, Any], shape: Shape, radius: float, target: Array
) -> tuple[Array, float]:
    """Where the contact point gets nearest to a target, (3,), m, and how near, m."""
    frame = _frame(model, leg)
    supports = [j for j in model.supports[frame.parentJoint] if j > 1]
    if "wheel" in leg:  # turning it moves no contact point
        supports = [j for j in supports if model.names[j] != leg["wheel_joint"]]

    def contact(angles: Array) -> Array:
        now = q.copy()
        for joint, angle in zip(supports, angles, strict=True):
            _turn(model, now, joint, angle)
        pin.forwardKinematics(model, data, now)
        placement = data.oMi[frame.parentJoint]
        down = np.array([0.0, 0.0, -1.0])
        if shape.axle is not None:  # the lowest point of the rim
            axle = placement.rotation @ shape.axle
            down -= (down @ axle) * axle
            down /= np.linalg.norm(down)
        return np.asarray(placement.act(shape.centre) + (shape.radius or radius) * down)

    low, high = np.array([_limits(model, joint) for joint in supports]).T
    begin = np.clip([_angle(model, q, joint) for joint in supports], low + 1e-6, high - 1e-6)
    found = least_squares(
        lambda angles: contact(angles) - target, begin, bounds=(low, high), xtol=1e-12, ftol=1e-14, gtol=1e-14
    )
    place = contact(found.x)
    return place, float(np.linalg.norm(place - target))
