"""What the planner does not know of a robot: the small YAML file that stands beside a URDF.

It names, per leg, the wheel or the foot and the joints that matter, and holds what no URDF tells. Plain data;
the model itself is built in `urdf_model.py`.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Final

from pydantic import AfterValidator, Field, model_validator

from rollgait.config import (
    Config,
    NonNegative,
    Number,
    Positive,
    PositiveVector3,
    Range,
    Vector3,
    load_yaml,
    validate,
)
from rollgait.errors import MISSING, FileError, InputError, MissingExtraError, UnknownNameError
from rollgait.robot.loads import Load
from rollgait.robot.robot import LEG_NAMES, LegName, Robot
from rollgait.robot.urdf_check import LENGTH_MAX

EXTRA: Final = "whole-body"
"""The optional extra that brings pinocchio and CENTAURO's model."""

PUBLIC: Final = "robot_descriptions"
"""A package of public robots, each a module that fetches its files when it is imported first."""

DATA_PREFIX: Final = "example-robot-data:"
"""Begins the path of a file in the installed package example-robot-data."""


def _of_a_body(value: float) -> float:
    if value > LENGTH_MAX:
        raise ValueError(f"must be at most {LENGTH_MAX:g} m")
    return value


Length = Annotated[NonNegative, AfterValidator(_of_a_body)]
"""Of a part of a robot, m."""


class LegJoints(Config):
    """A leg of the whole body, by the names in the URDF."""

    wheel: str | None = None
    """Frame (link) of the wheel; none for a point foot."""
    wheel_joint: str | None = None
    """Joint about which the wheel turns."""
    steering_joint: str | None = None
    """Joint that steers the wheel; none for a fixed wheel."""
    foot: str | None = None
    """Frame (link) of a point foot; none for a wheel."""
    radius: Length | None = None
    """Radius of the wheel or of the ball, m; measured in the URDF's geometry if not given."""
    centre: Vector3 | None = None
    """Centre of the wheel or of the ball in its frame, m; measured in the URDF's geometry if not given."""

    @model_validator(mode="after")
    def _is_a_wheel_or_a_foot(self) -> LegJoints:
        if (self.wheel is None) == (self.foot is None):
            raise ValueError("must name either a wheel or a foot")
        if (self.wheel is None) != (self.wheel_joint is None):
            raise ValueError("must name the wheel and the wheel_joint together")
        if self.steering_joint is not None and self.wheel is None:
            raise ValueError("must not name a steering_joint without a wheel")
        if self.wheel is not None and self.radius == 0.0:
            raise ValueError("must have a radius greater than 0, as it names a wheel")
        return self

    @property
    def frame(self) -> str:
        """The frame of the wheel or of the foot."""
        return self.wheel or self.foot or ""


class LegsJoints(Config):
    """The four legs by name."""

    FL: LegJoints
    """Front left."""
    FR: LegJoints
    """Front right."""
    HL: LegJoints
    """Hind left."""
    HR: LegJoints
    """Hind right."""


class Choices(Config):
    """Figures for the planner that are a choice, not a fact of the URDF."""

    description: str = ""
    """One line for people."""
    box: PositiveVector3 | None = None
    """Half-sizes of the box for the feet, m; the largest one found reachable if not given."""
    steering_box: PositiveVector3 | None = None
    """Half-sizes of the box over which the steering range shall hold, m; the reachable one if not given."""
    steering_rate_max: Positive | None = None
    """Limit of |σ̇|, rad/s; that of the steering joint if not given."""
    speed_max: Positive | None = None
    """Limit of the rolling speed, m/s; the rim speed at the wheel joint's limit if not given."""
    slip_max: Positive | None = None
    """How fast fixed wheels may slip sideways, m/s; not at all if not given."""
    force_max: Positive | None = None
    """Limit of the normal contact force, N; the robot's weight if not given."""
    extension: Range | None = None
    """Range of the distance from hip pitch to ankle pitch axis, m; from the joints if not given."""
    radius_min: Positive | None = None
    """Smallest horizontal distance from the hip_yaw axis to the contact point, m."""


class WholeBody(Config):
    """Where the whole-body model of a robot is, and how to read it."""

    name: str
    """Name of the robot."""
    urdf: str
    """Path of the URDF, from the folder of this file; `example-robot-data:` begins one in that package."""
    srdf: str | None = None
    """Path of the SRDF, likewise."""
    posture: str | None = None
    """Group state of the SRDF that the nominal stance is derived from; found if no joint's angle is given."""
    joints: dict[str, Number] = Field(default_factory=dict)
    """Joint angles of that posture, over those of the SRDF, rad."""
    height: Annotated[Positive, AfterValidator(_of_a_body)] | None = None
    """Height of the base link above the ground in the nominal stance, m; the posture's if not given."""
    legs: LegsJoints
    """The four legs."""
    planner: Choices = Choices()
    """Figures that are a choice."""

    def leg_list(self) -> Iterator[tuple[LegName, LegJoints]]:
        """The legs with their names, in the order FL, FR, HL, HR."""
        for name in LEG_NAMES:
            yield name, getattr(self.legs, name)


class EquippedBody(WholeBody):
    """A whole body as one robot uses it: what it carries, and how it holds its arms."""

    loads: tuple[Load, ...] = ()
    """Fixed to the base link; places are from the CoM without them in the nominal stance, arms held so."""
    arms: dict[str, Number] = Field(default_factory=dict)
    """Angles of joints of no leg, over those of the posture, rad."""

    @property
    def unladen(self) -> WholeBody:
        """The same without either."""
        return WholeBody.model_validate(self.model_dump(exclude={"loads", "arms"}))


def equipped(body: WholeBody, robot: Robot) -> WholeBody:
    """The whole body with what a robot carries and how it holds its arms."""
    if not robot.loads and not robot.posture:
        return body
    data = body.model_dump() | {"loads": robot.loads or (), "arms": robot.posture or {}}
    return EquippedBody.model_validate(data)


def load_whole_body(path: str | Path) -> WholeBody:
    """The whole body in this YAML file; its paths become absolute.

    Raises:
        InputError: the file breaks a rule, or does not exist.
    """
    file = Path(path)
    data = load_yaml(file)
    try:
        body = validate(WholeBody, data, "")
    except InputError as error:  # the user may not have named the file: it may stand beside a model
        raise InputError(error.field, error.value, f"{error.rule}, in {file}", error.choices) from None
    return _placed(body, file.absolute().parent)


def find_whole_body(robot: Robot) -> WholeBody:
    """The whole body of a robot: the file it names, or the one of its name in the library, with its loads.

    Raises:
        InputError: there is none: the robot is for planning only.
    """
    if robot.whole_body is not None:
        return equipped(load_whole_body(robot.whole_body), robot)
    if robot.name not in whole_body_names():
        rule = f"must be given: of {robot.name!r} there are only figures for planning, no whole-body model"
        raise InputError("robot.whole_body", MISSING, rule)
    return equipped(library_whole_body(robot.name), robot)


def whole_body_names() -> list[str]:
    """Names of the whole bodies in the library, sorted."""
    return sorted(f.name.removesuffix(".yaml") for f in _LIBRARY.iterdir() if f.name.endswith(".yaml"))


def library_whole_body(name: str) -> WholeBody:
    """The whole body of this name in the library. Raises `UnknownNameError`."""
    if name not in whole_body_names():
        rule = f"is neither a file nor a robot with a whole body in the library or in {PUBLIC}"
        if find_spec(PUBLIC) is None:
            rule += f" (which is not installed: pip install {PUBLIC})"
        raise UnknownNameError("model", name, whole_body_names(), rule)
    with resources.as_file(_LIBRARY / f"{name}.yaml") as file:
        return load_whole_body(file)


_LIBRARY = resources.files("rollgait.robot.library") / "whole_body"


def _placed(body: WholeBody, folder: Path) -> WholeBody:
    """The same with absolute paths."""
    places = {
        key: str(_place(key, getattr(body, key), folder)) for key in ("urdf", "srdf") if getattr(body, key)
    }
    return body.model_copy(update=places)


def data_file(field: str, path: str) -> Path:
    """The file of a path that begins with `DATA_PREFIX`, in the installed package.

    Raises:
        FileError: there is no such file in it.
        MissingExtraError: the package is not installed.
    """
    folder = _example_robot_data()
    place = folder / path.removeprefix(DATA_PREFIX)
    if not place.resolve().is_relative_to(folder.resolve()) or not place.is_file():
        raise FileError(field, path, "cannot be read: there is no such file in the package")
    return place


def _place(field: str, path: str, folder: Path) -> Path:
    if path.startswith(DATA_PREFIX):
        return data_file(field, path)
    place = folder / path
    if not place.is_file():
        raise FileError(field, path, f"cannot be read: there is no such file in {folder}")
    return place


def _example_robot_data() -> Path:
    """The folder `robots` of the installed package example-robot-data."""
    for entry in sys.path:
        place = Path(entry) / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
        if place.is_dir():
            return place
    raise MissingExtraError("the whole-body model of CENTAURO", EXTRA)
