"""Whether a URDF describes bodies that can exist: every number of every link and joint, and their tree.

Parsers of URDF drop what they cannot read, and mass with it. So all is judged here first, and named.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NoReturn

from rollgait.errors import FileError, shown

MASS_MAX: Final = 1e5
"""Largest mass of a link, kg: no robot on legs weighs 100 t."""

LENGTH_MAX: Final = 100.0
"""Largest length, offset or radius of gyration of a link, m."""

LINKS_MAX: Final = 1000
"""Most links of a robot: the largest humanoids with hands and skin have a few hundred."""

KINDS: Final = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
"""Kinds of joints that a URDF knows."""

_DECIMAL: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_MOMENTS: Final = ("ixx", "iyy", "izz")
_PRODUCTS: Final = ("ixy", "ixz", "iyz")
_LENGTHS: Final = {
    "box": {"size": 3},
    "sphere": {"radius": 1},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
}


def decimal(text: str | None) -> float | None:
    """The finite number that a text is, as XML writes numbers; None if it is none."""
    if text is None or not _DECIMAL.fullmatch(text.strip()):
        return None
    value = float(text)
    return value if math.isfinite(value) else None


def check_urdf(file: Path, root: ET.Element) -> None:
    """Judges a URDF before any parser sees it.

    Raises:
        FileError: a number is none, or one that no body can have; a link is missing, hangs on two joints or
            on itself. The sentence names the link or joint.
    """
    links, joints = _named(file, root, "link"), _named(file, root, "joint")
    if len(links) > LINKS_MAX:
        raise FileError("urdf", str(file), f"has {len(links)} links, must have at most {LINKS_MAX}")
    for part in links.values():
        _check_link(part)
    for part in joints.values():
        _check_joint(part, links)
    _check_tree(links, joints)


@dataclass(frozen=True)
class _Part:
    """A link or a joint, and how a sentence about it begins."""

    file: Path
    element: ET.Element

    @property
    def name(self) -> str:
        return self.element.get("name", "")

    def wrong(self, rule: str) -> NoReturn:
        raise FileError("urdf", str(self.file), f"has the {self.element.tag} {shown(self.name)}, {rule}")

    def child(self, tag: str, within: ET.Element | None = None) -> ET.Element:
        """The element of this tag, which must be there."""
        found = (self.element if within is None else within).find(tag)
        if found is None:
            self.wrong(f"whose {tag} must be given")
        return found

    def numbers(self, element: ET.Element, key: str, count: int, largest: float = math.inf) -> list[float]:
        """The numbers of an attribute, which must be there."""
        text = element.get(key)
        if text is None:
            self.wrong(f"whose {element.tag} must have {key}")
        values = [decimal(word) for word in text.split()]
        if len(values) != count or None in values:
            wanted = "a finite number" if count == 1 else f"{count} finite numbers"
            self.wrong(f"whose {element.tag} {key} {shown(text)} must be {wanted}")
        found = [value for value in values if value is not None]
        if any(abs(value) > largest for value in found):
            self.wrong(f"whose {element.tag} {key} {shown(text)} must not exceed {largest:g}")
        return found

    def number(self, element: ET.Element, key: str, largest: float = math.inf) -> float:
        """The number of an attribute, which must be there."""
        return self.numbers(element, key, 1, largest)[0]


def _named(file: Path, root: ET.Element, tag: str) -> dict[str, _Part]:
    """Links or joints by their names, which must be there and differ."""
    parts: dict[str, _Part] = {}
    for element in root.findall(tag):
        part = _Part(file, element)
        if not part.name:
            raise FileError("urdf", str(file), f"has a {tag} without name")
        if part.name in parts:
            part.wrong("more than once: names must differ")
        parts[part.name] = part
    return parts


# -- links --


def _check_link(part: _Part) -> None:
    for inertial in part.element.findall("inertial"):
        _check_origin(part, inertial)
        mass = part.number(part.child("mass", inertial), "value", MASS_MAX)
        if mass < 0.0:
            part.wrong(f"whose mass {mass:g} kg must not be negative")
        inertia = part.child("inertia", inertial)
        if mass == 0.0 and any(part.number(inertia, key) != 0.0 for key in (*_MOMENTS, *_PRODUCTS)):
            part.wrong("whose mass 0 kg must be greater than 0, as it has an inertia")
        largest = mass * LENGTH_MAX**2
        moments = [part.number(inertia, key, largest) for key in _MOMENTS]
        for key in _PRODUCTS:
            part.number(inertia, key, largest)
        if min(moments) < 0.0:
            part.wrong(f"whose moment of inertia {min(moments):g} kg m² must not be negative")
    for kind in ("visual", "collision"):
        for shape in part.element.findall(kind):
            _check_origin(part, shape)
            for geometry in part.child("geometry", shape):
                _check_geometry(part, geometry)


def _check_geometry(part: _Part, shape: ET.Element) -> None:
    if shape.tag == "mesh" and shape.get("scale") is not None and 0.0 in part.numbers(shape, "scale", 3):
        part.wrong("whose mesh scale must not be 0")
    for key, count in _LENGTHS.get(shape.tag, {}).items():
        if min(part.numbers(shape, key, count, LENGTH_MAX)) <= 0.0:
            part.wrong(f"whose {shape.tag} {key} {shown(shape.get(key))} must be greater than 0")


def _check_origin(part: _Part, element: ET.Element) -> None:
    for origin in element.findall("origin"):
        if "xyz" in origin.attrib:
            part.numbers(origin, "xyz", 3, LENGTH_MAX)
        if "rpy" in origin.attrib:
            part.numbers(origin, "rpy", 3)


# -- joints --


def _check_joint(part: _Part, links: dict[str, _Part]) -> None:
    kind = part.element.get("type", "")
    if kind not in KINDS:
        part.wrong(f"whose type {shown(kind)} is not known; valid: {', '.join(KINDS)}")
    for end in ("parent", "child"):
        link = part.child(end).get("link", "")
        if link not in links:
            part.wrong(f"whose {end} {shown(link)} is not a link")
    _check_origin(part, part.element)
    axis = part.element.find("axis")
    if axis is not None and not any(part.numbers(axis, "xyz", 3)) and kind not in ("fixed", "floating"):
        part.wrong("whose axis must not be 0")
    _check_limit(part, kind)
    for tag, keys in {"dynamics": ("damping", "friction"), "mimic": ("multiplier", "offset")}.items():
        for element in part.element.findall(tag):
            for key in keys:
                if key in element.attrib:
                    part.number(element, key)


def _check_limit(part: _Part, kind: str) -> None:
    if kind in ("revolute", "prismatic"):
        part.child("limit")
    limit = part.element.find("limit")
    if limit is None:
        return
    given: dict[str, float] = {
        key: part.number(limit, key)
        for key in ("lower", "upper", "effort", "velocity")
        if key in limit.attrib
    }
    if kind in ("revolute", "prismatic"):
        for key in ("effort", "velocity"):
            part.number(limit, key)
        if given.get("lower", 0.0) > given.get("upper", 0.0):
            part.wrong("whose limit upper must not be smaller than lower")
    for key in ("effort", "velocity"):
        if given.get(key, 0.0) < 0.0:
            part.wrong(f"whose limit {key} {given[key]:g} must not be negative")


# -- the tree --


def _check_tree(links: dict[str, _Part], joints: dict[str, _Part]) -> None:
    """All links hang on one root, each on one joint: what hangs on itself would be followed for ever."""
    parent: dict[str, str] = {}
    above: dict[str, str] = {}
    for name, joint in joints.items():
        child = joint.child("child").get("link", "")
        if child in above:
            links[child].wrong(f"which hangs on two joints, {shown(above[child])} and {shown(name)}")
        above[child], parent[child] = name, joint.child("parent").get("link", "")
    roots: dict[str, str] = {}
    for link in links:
        way = _upwards(links, link, parent, roots)
        roots |= dict.fromkeys(way, roots.get(way[-1], way[-1]))
    first, *others = dict.fromkeys(roots.values())
    if others:
        links[others[0]].wrong(f"which no joint connects to {shown(first)}")


def _upwards(links: dict[str, _Part], link: str, parent: dict[str, str], roots: dict[str, str]) -> list[str]:
    """A link and those above it, up to the root or to one whose root is known."""
    way = {link: None}
    while link in parent and link not in roots:
        link = parent[link]
        if link in way:
            links[link].wrong("which hangs on itself: its joints form a cycle")
        way[link] = None
    return list(way)
