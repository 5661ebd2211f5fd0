"""URDF and SRDF as files: reading, repairing and judging them before any library builds a model of them."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final

from rollgait.errors import FileError, InputError, UnknownNameError, shown
from rollgait.robot.mjcf import urdf_of_mjcf
from rollgait.robot.urdf_check import check_urdf, decimal
from rollgait.robot.xacro_files import is_xacro, refusal
from rollgait.robot.xml_files import read_xml

UNLIMITED: Final = 1e9
"""Stands for "no limit" in the URDF that is handed on (rad, rad/s, N m)."""

_MOVING: Final = ("revolute", "continuous")
_PACKAGE: Final = "package://"


@dataclass(frozen=True)
class Joint:
    """A joint of a URDF."""

    name: str
    kind: str
    parent: str
    child: str
    mimics: str | None


@dataclass(frozen=True)
class Urdf:
    """A URDF whose root moves freely: no joint holds it, and every turning joint has limits.

    Attributes:
        path: where it was read.
        root: its XML. Continuous joints have become revolute ones with limits of ±`UNLIMITED`, so that an
            angle is one number that counts turns; a floating joint at the root is gone, as whoever reads this
            adds one.
    """

    path: Path
    root: ET.Element

    @property
    def text(self) -> str:
        """The XML."""
        return ET.tostring(self.root, encoding="unicode")

    @cached_property
    def links(self) -> dict[str, ET.Element]:
        """The links by name."""
        return {link.get("name", ""): link for link in self.root.findall("link")}

    @cached_property
    def joints(self) -> dict[str, Joint]:
        """The joints by name."""
        return {joint.name: joint for joint in _joints(self.root)}

    @cached_property
    def joint_elements(self) -> dict[str, ET.Element]:
        """The XML of the joints by name."""
        return {joint.get("name", ""): joint for joint in self.root.findall("joint")}

    @cached_property
    def _below(self) -> dict[str, list[Joint]]:
        below: dict[str, list[Joint]] = {}
        for joint in self.joints.values():
            below.setdefault(joint.parent, []).append(joint)
        return below

    def children_of(self, link: str) -> list[Joint]:
        """The joints that hang on a link."""
        return self._below.get(link, [])

    @property
    def root_link(self) -> str:
        """The link on which all others hang."""
        children = {joint.child for joint in self.joints.values()}
        return next(link for link in self.links if link not in children)

    def chain(self, link: str) -> list[Joint]:
        """The joints from the root to a link, in this order."""
        above = {joint.child: joint for joint in self.joints.values()}
        result: list[Joint] = []
        while link in above:
            result.insert(0, above[link])
            link = above[link].parent
        return result

    def leg_chain(self, field: str, link: str) -> list[Joint]:
        """The turning joints from the root to a link.

        Raises:
            InputError: there is no such link, or one of the joints is of a kind that a leg must not have.
        """
        if link not in self.links:
            raise UnknownNameError(field, link, self.links, f"is not a link of {self.path.name}")
        chain = [joint for joint in self.chain(link) if joint.kind != "fixed"]
        for joint in chain:
            if joint.kind not in _MOVING:
                rule = f"has a {joint.kind} joint, {joint.name}, in its leg: a leg's joints must all turn"
                raise InputError(field, link, rule)
            if joint.mimics is not None:
                rule = f"has a joint in its leg, {joint.name}, that mimics {joint.mimics}, which none may"
                raise InputError(field, link, rule)
        return chain

    def missing_meshes(self) -> list[str]:
        """The names of meshes of which there is no file: none is needed to plan, to track or to simulate."""
        return [name for name in dict.fromkeys(self._mesh_names()) if self.find_mesh(name) is None]

    def find_mesh(self, name: str) -> Path | None:
        """The file that a mesh's name means; None if there is none."""
        for place in _places(name, self.path):
            try:
                if place.is_file():
                    return place
            except OSError:  # a name that is too long for a file
                continue
        return None

    def _mesh_names(self) -> Iterator[str]:
        return (name for mesh in self.root.iter("mesh") if (name := mesh.get("filename")))


def read_urdf(path: str | Path) -> Urdf:
    """Reads, judges and repairs a URDF, or what MJCF becomes as one.

    Raises:
        FileError: it cannot be read, is no URDF, or describes what no body can be.
        MissingExtraError: it is MJCF, and MuJoCo is not installed.
    """
    file = Path(path)
    root = read_xml("urdf", file)
    if root.tag == "mujoco":
        root = urdf_of_mjcf(file)
    elif is_xacro(root):
        raise refusal(file)
    if root.tag != "robot" or root.find("link") is None:
        raise FileError("urdf", str(file), "is not a URDF: it has no robot with links")
    check_urdf(file, root)
    _free_the_root(root)
    _limit_continuous_joints(root)
    return Urdf(file, root)


def read_posture(path: str | Path, name: str) -> dict[str, float]:
    """Joint angles of a group state of an SRDF, rad.

    Raises:
        FileError: it cannot be read, or an angle is no finite number.
        UnknownNameError: it has no group state of this name.
    """
    file = Path(path)
    states = _group_states(file)
    if name not in states:
        raise UnknownNameError("posture", name, states, f"is not a group state of {file.name}")
    angles = {}
    for joint in states[name].iter("joint"):
        values = joint.get("value", "").split()
        if len(values) != 1:  # the free joint at the root has several
            continue
        if (angle := decimal(values[0])) is None:
            which = f"joint {shown(joint.get('name', ''))} in the group state {shown(name)}"
            rule = f"has the {which}, whose value {shown(values[0])} must be a finite number"
            raise FileError("srdf", str(file), rule)
        angles[joint.get("name", "")] = angle
    return angles


def posture_names(path: str | Path) -> list[str]:
    """Names of the group states of an SRDF. Raises `FileError`."""
    return list(_group_states(Path(path)))


def _group_states(file: Path) -> dict[str, ET.Element]:
    return {state.get("name", ""): state for state in read_xml("srdf", file).iter("group_state")}


def _joints(root: ET.Element) -> Iterator[Joint]:
    for joint in root.findall("joint"):
        parent, child, mimic = joint.find("parent"), joint.find("child"), joint.find("mimic")
        if parent is None or child is None:
            continue
        yield Joint(
            name=joint.get("name", ""),
            kind=joint.get("type", ""),
            parent=parent.get("link", ""),
            child=child.get("link", ""),
            mimics=None if mimic is None else mimic.get("joint", ""),
        )


def _free_the_root(root: ET.Element) -> None:
    """Removes a floating joint at the root, and the link above it."""
    joints = list(_joints(root))
    children = {joint.child for joint in joints}
    for joint in joints:
        if joint.kind == "floating" and joint.parent not in children:
            for part in [*root.findall("link"), *root.findall("joint")]:
                if part.get("name") in (joint.parent, joint.name):
                    root.remove(part)


def _limit_continuous_joints(root: ET.Element) -> None:
    for joint in root.findall("joint"):
        if joint.get("type") != "continuous":
            continue
        joint.set("type", "revolute")
        limit = joint.find("limit")
        if limit is None:
            limit = ET.SubElement(joint, "limit")
        for key in ("effort", "velocity"):
            limit.set(key, limit.get(key) or str(UNLIMITED))
        limit.set("lower", str(-UNLIMITED))
        limit.set("upper", str(UNLIMITED))


def _places(name: str, urdf: Path) -> Iterator[Path]:
    """Where a mesh may be: package:// names a folder above the URDF or beside one, or on ROS_PACKAGE_PATH."""
    if not name.startswith(_PACKAGE):
        yield urdf.parent / name.removeprefix("file://")
        return
    package, _, rest = name.removeprefix(_PACKAGE).partition("/")
    for folder in urdf.absolute().parents:
        if folder.name == package:
            yield folder / rest
        yield folder / package / rest
    for entry in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep):
        if entry:
            yield Path(entry) / package / rest
