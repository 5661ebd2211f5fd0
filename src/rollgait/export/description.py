"""The robot of a motion as others build it: the URDF for `/robot_description`, its joints, its meshes.

A URDF may name its meshes by places on this machine, which mean nothing elsewhere and are nobody's business.
So none leaves it: a mesh is named `package://…`, as RViz and Foxglove look for it in the packages they know.
A URDF that has no packages gets one of the robot's name. What its plug-ins for Gazebo say is left out: it is
no part of a URDF, and may hold paths as well.
"""

from __future__ import annotations

import copy
import re
import xml.etree.ElementTree as ET
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Final, Literal, get_args

from rollgait.errors import InputError
from rollgait.export.motion import Sampled
from rollgait.export.rigid_urdf import rigid_joints, rigid_urdf
from rollgait.plan.samples import Array
from rollgait.robot.urdf_files import UNLIMITED, Urdf, read_urdf
from rollgait.robot.whole_body import WholeBody, find_whole_body

Meshes = Literal["beside", "package", "file"]
MESHES: Final[tuple[Meshes, ...]] = get_args(Meshes)
"""`beside`: `package://…`, and the files of that package in a folder beside the bag. `package`: only the
names. `file`: `file:///…`, for this machine only."""

PACKAGE: Final = "package://"
SHAPES: Final = (".stl", ".dae", ".obj", ".glb", ".gltf", ".ply", ".mesh", ".3ds")
"""Endings of files of meshes: no other file goes with a bag, whatever a URDF names."""
PARTS: Final = ("link", "joint", "material", "transmission")
"""What a URDF has."""


@dataclass(frozen=True)
class Description:
    """A robot and what its joints do.

    Attributes:
        urdf: the robot; its root is the base of the motion.
        joint_names: of its n_j joints that move.
        position, velocity: of them, (n, n_j), rad and rad/s (m and m/s).
        effort: (n, n_j), N m, or (n, 0) where it is not known.
        wheels: names of the joints that roll.
        controlled: names of the joints that a robot has.
        meshes: the file of each mesh, by its place below the folder of packages.
    """

    urdf: Urdf
    joint_names: tuple[str, ...]
    position: Array
    velocity: Array
    effort: Array
    wheels: tuple[str, ...]
    controlled: tuple[str, ...]
    meshes: dict[PurePosixPath, Path]

    @property
    def text(self) -> str:
        """The XML."""
        return self.urdf.text


def describe(s: Sampled, meshes: Meshes = "beside") -> Description:
    """The robot of a motion: its whole body where its joints are known, else its rigid body and its feet.

    Raises:
        InputError: there is no such way with meshes; or the motion has joints that the robot has not.
        FileError: its URDF cannot be read.
    """
    if meshes not in MESHES:
        raise InputError("meshes", meshes, f"must be one of {', '.join(MESHES)}")
    if not s.whole:
        names, position, velocity = rigid_joints(s)
        wheels = tuple(name for name in s.joint_names if name.endswith("_wheel_joint"))
        return Description(
            rigid_urdf(s.robot), names, position, velocity, s.joint_effort, wheels, s.joint_names, {}
        )
    body = find_whole_body(s.robot)
    found = read_urdf(body.urdf)
    if unknown := [name for name in s.joint_names if name not in found.joints]:
        raise InputError("joint_names", unknown[0], f"is not a joint of {found.path.name}")
    root, files = _to_be_sent(found, s.robot.name, meshes)
    _add_loads(root, found.root_link, body)
    return Description(
        urdf=Urdf(found.path, root),
        joint_names=s.joint_names,
        position=s.joint_position,
        velocity=s.joint_velocity,
        effort=s.joint_effort,
        wheels=tuple(leg.wheel_joint for _, leg in body.leg_list() if leg.wheel_joint),
        controlled=tuple(name for name in s.joint_names if found.joints[name].mimics is None),
        meshes=files,
    )


def free_name(name: str, taken: Collection[str]) -> str:
    """The name, or the first that is free with a number behind it."""
    number, found = 1, name
    while found in taken:
        number += 1
        found = f"{name}_{number}"
    return found


def _to_be_sent(urdf: Urdf, name: str, meshes: Meshes) -> tuple[ET.Element, dict[PurePosixPath, Path]]:
    """The XML of a URDF without what is of this machine, and the files that it names."""
    root = ET.Element("robot", name=name)
    root.extend(copy.deepcopy(part) for part in urdf.root if part.tag in PARTS)
    for joint in root.findall("joint"):
        _as_it_was(joint)
    names = _Names(re.sub(r"\W", "_", name).lower() or "robot")
    files: dict[PurePosixPath, Path] = {}
    for element in [*root.iter("mesh"), *root.iter("texture")]:
        asked = element.get("filename")
        if not asked:
            continue
        place, file = names.place_of(asked), urdf.find_mesh(asked)
        if meshes == "file" and file is not None:
            element.set("filename", file.absolute().as_uri())
            continue
        element.set("filename", f"{PACKAGE}{place}")
        if meshes == "beside" and file is not None and _may_go(file, element.tag):
            files[place] = file
    return root, files


def _may_go(file: Path, tag: str) -> bool:
    endings = SHAPES if tag == "mesh" else (".png", ".jpg", ".jpeg")
    return file.suffix.lower() in endings


class _Names:
    """Places of meshes below the folder of packages, one for each name."""

    def __init__(self, package: str) -> None:
        self._package = f"{package}_description"
        self._places: dict[str, PurePosixPath] = {}

    def place_of(self, asked: str) -> PurePosixPath:
        """The place of a mesh by its name in the URDF."""
        if asked not in self._places:
            self._places[asked] = self._in_its_package(asked) or self._in_ours(asked)
        return self._places[asked]

    def _in_its_package(self, asked: str) -> PurePosixPath | None:
        if not asked.startswith(PACKAGE):
            return None
        place = PurePosixPath(asked.removeprefix(PACKAGE))
        is_inside = not place.is_absolute() and ".." not in place.parts and len(place.parts) > 1
        return place if is_inside else None

    def _in_ours(self, asked: str) -> PurePosixPath:
        name = PurePosixPath(asked.replace("\\", "/"))
        taken, number = set(self._places.values()), 1
        place = PurePosixPath(self._package, "meshes", name.name)
        while place in taken:
            number += 1
            place = place.with_name(f"{name.stem}_{number}{name.suffix}")
        return place


def _as_it_was(joint: ET.Element) -> None:
    """A joint that turns without end, which is read as one with far limits, says so again."""
    limit = joint.find("limit")
    if limit is None or limit.get("upper") != str(UNLIMITED):
        return
    joint.set("type", "continuous")
    for key in ("lower", "upper"):
        limit.attrib.pop(key, None)
    if limit.get("velocity") == limit.get("effort") == str(UNLIMITED):
        joint.remove(limit)


def _add_loads(root: ET.Element, base: str, body: WholeBody) -> None:
    """What the robot carries, as links welded to its base."""
    from rollgait.robot.standing_com import link_loads

    for load in link_loads(body):
        name = free_name("load", {link.get("name", "") for link in root.findall("link")})
        link = ET.SubElement(root, "link", name=name)
        inertial = ET.SubElement(link, "inertial")
        ET.SubElement(inertial, "mass", value=repr(load.mass))
        ET.SubElement(inertial, "inertia", dict(_moments(load.inertia)))
        joint = ET.SubElement(root, "joint", name=f"{name}_joint", type="fixed")
        ET.SubElement(joint, "origin", xyz=" ".join(repr(float(x)) for x in load.place), rpy="0 0 0")
        ET.SubElement(joint, "parent", link=base)
        ET.SubElement(joint, "child", link=name)


def _moments(inertia: Array) -> Iterator[tuple[str, str]]:
    for i, row in enumerate("xyz"):
        for j, column in list(enumerate("xyz"))[i:]:
            yield f"i{row}{column}", repr(float(inertia[i, j]))
