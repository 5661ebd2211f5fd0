"""The whole body of a bare URDF: what a person would write into the file of the legs, found."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Final

import numpy as np

from rollgait.config import dump_yaml, validate
from rollgait.robot.urdf_feet import measure_foot
from rollgait.robot.urdf_files import read_urdf
from rollgait.robot.urdf_legs import find_legs
from rollgait.robot.urdf_model import BASE_V, WholeBodyModel
from rollgait.robot.whole_body import LegJoints, WholeBody

DIGITS: Final = 4
"""Of lengths (m) and angles (rad) in the file of the legs."""

NAME_MAX: Final = 60
"""Characters of a robot's name."""

_HEAD: Final = "# Found by chains, symmetry and axes. Correct what is wrong, and import again.\n"
_SKIDS: Final = """\
# Legs give no way sideways: the robot turns by wheels that slip sideways, no faster than this (m/s). Without
# it the robot goes straight ahead only.
"""


def discover(file: Path) -> WholeBody:
    """Legs, posture, radii and centres of a robot of which there is only a URDF.

    Raises:
        InputError: the URDF is wrong, or it does not tell which are its legs.
    """
    urdf = read_urdf(file)
    legs: dict[str, dict[str, Any]] = {}
    for name, leg in find_legs(urdf).items():
        described: dict[str, Any] = dict(leg.described())
        shape = measure_foot(urdf, f"legs.{name}", validate(LegJoints, described, f"legs.{name}"))
        if shape.known:
            described["radius"] = round(shape.radius, DIGITS)
        if shape.centre.any():
            described["centre"] = [round(float(value), DIGITS) for value in shape.centre]
        legs[name] = described
    data: dict[str, Any] = {"name": robot_name(file), "urdf": str(file.absolute()), "legs": legs}
    model = WholeBodyModel(validate(WholeBody, data))
    if model.posture_is_found:
        angles = np.round(model.posture[BASE_V + 1 :], DIGITS)
        data["joints"] = {n: float(a) for n, a in zip(model.joint_names, angles, strict=True) if a != 0.0}
    return validate(WholeBody, data)


def outline(file: Path) -> str:
    """The file of the legs as far as their names go: where a figure is missing that no one but people knows.

    Raises:
        InputError: the URDF is wrong, or it does not tell which are its legs.
    """
    legs = {name: leg.described() for name, leg in find_legs(read_urdf(file)).items()}
    return _HEAD + dump_yaml({"name": robot_name(file), "urdf": str(file.absolute()), "legs": legs})


def described(body: WholeBody) -> str:
    """The file of the legs, as text for people to correct."""
    data = body.model_dump(mode="json", exclude_none=True, exclude_defaults=True)
    order = ("name", "urdf", "srdf", "posture", "height", "legs", "joints")
    text = _HEAD + dump_yaml({key: data[key] for key in order if key in data})
    slip_max = body.planner.slip_max
    return text if slip_max is None else text + _SKIDS + dump_yaml({"planner": {"slip_max": slip_max}})


def robot_name(file: Path) -> str:
    """The name of the robot in a URDF, so that it can begin those of files. Raises `FileError`."""
    given = read_urdf(file).root.get("name", "")[:NAME_MAX]
    return re.sub(r"[^\w.-]+", "-", given).strip("-.") or file.stem
