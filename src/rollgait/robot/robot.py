"""The robot as the planner sees it: one rigid body and four feet. Frozen data, SI units, no behaviour.

The base frame has its origin at the centre of mass (CoM) and the axes of the base link (x forward, y left,
z up). The legs come always in the order FL, FR, HL, HR (front/hind, left/right).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Annotated, Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, ValidationInfo, field_validator, model_validator

from rollgait.config import (
    Config,
    Line,
    Number,
    Positive,
    PositiveVector3,
    Range,
    Vector3,
    set_key,
    validate,
)
from rollgait.errors import InputError
from rollgait.presented import Shown
from rollgait.robot.loads import Load, Loads, com_offset, steiner

LegName = Literal["FL", "FR", "HL", "HR"]
LEG_NAMES: Final[tuple[LegName, ...]] = ("FL", "FR", "HL", "HR")
"""Order of the legs everywhere: front left, front right, hind left, hind right."""

FootKind = Literal["steerable", "fixed", "point"]
"""`steerable`: a wheel that rolls along a heading it can turn. `fixed`: a wheel whose heading is that of the
base. `point`: stands still on the ground. All move freely in swing, the steerable one along its heading."""

GRAVITY = 9.81
"""Standard of this package, m/s² (the paper's value); acts along −z of the world."""


BALL_LARGEST: Final = 0.05
"""Largest radius of the ball of a point foot, m; one with a larger radius is a locked wheel."""


class Inertia(Config):
    """Inertia tensor about the CoM in base axes, kg·m²: constant in the base frame, not in the world."""

    xx: Positive
    """About x, kg·m²."""
    yy: Positive
    """About y, kg·m²."""
    zz: Positive
    """About z, kg·m²."""
    xy: Number = 0.0
    """Element of the matrix, −∫ x y dm, kg·m²."""
    xz: Number = 0.0
    """Element of the matrix, −∫ x z dm, kg·m²."""
    yz: Number = 0.0
    """Element of the matrix, −∫ y z dm, kg·m²."""

    def matrix(self) -> NDArray[np.float64]:
        """I_B, shape (3, 3), kg·m²."""
        return np.array(
            [[self.xx, self.xy, self.xz], [self.xy, self.yy, self.yz], [self.xz, self.yz, self.zz]]
        )

    @model_validator(mode="after")
    def _is_that_of_a_body(self) -> Inertia:
        a, b, c = np.linalg.eigvalsh(self.matrix())
        if a <= 0.0 or a + b < c * (1.0 - 1e-9):
            raise ValueError(
                f"must be the inertia of a body: its principal moments {a:.3g}, {b:.3g}, {c:.3g} kg·m² must "
                "be positive and none may exceed the sum of the two others"
            )
        return self


class Limb(Config):
    """What the `executable` profile knows of the joints behind a steerable foot.

    The leg hangs on a vertical hip_yaw axis and moves in a vertical plane that stands beside that axis. With
    ρ the horizontal distance from the axis to the contact point, d the offset of the plane and v the vertical
    distance from the hip pitch axis to the ankle pitch axis, the leg's extension e obeys e² = ρ² − d² + v².
    """

    hip: Vector3
    """Where the hip_yaw axis crosses the height of the hip pitch axis, from the CoM, base frame, m."""
    plane_offset: Number
    """d: signed offset of the leg's plane from the hip_yaw axis, positive to the left, m."""
    direction: Literal[-1, 1]
    """+1 if the leg extends forward of the hip axis in its plane, −1 if backward."""
    ankle_height: Positive
    """Height of the ankle pitch axis above the contact point when the wheel is upright, m."""
    extension: Range
    """Smallest and largest distance e from the hip pitch axis to the ankle pitch axis, m."""
    radius_min: Positive
    """Smallest horizontal distance ρ from the hip_yaw axis to the contact point, m."""
    hip_yaw: Range
    """Position limits of the hip_yaw joint, rad."""
    steering_joint: Range
    """Position limits of the joint that steers the wheel (ankle_yaw), rad."""


def _about_zero(value: tuple[float, float]) -> tuple[float, float]:
    if not value[0] <= 0.0 <= value[1]:
        raise ValueError("must be [smallest, largest] with 0, the nominal place, between them")
    return value


Side = Annotated[Range, AfterValidator(_about_zero)]
"""How far a foot may be from its nominal place along one axis, m."""


class Leg(Config):
    """A leg: its foot and the limits of it."""

    foot: FootKind
    """Kind of the foot."""
    stance: Vector3
    """p̄: nominal contact point from the CoM, base-yaw frame, m."""
    box: tuple[Side, Side, Side] | None = None
    """Box of this foot about p̄, [smallest, largest] of x, y and z, m. Default: ± the robot's `box`."""
    wheel_radius: Positive | None = None
    """R, m; of a point foot that of its ball, 0 if none is given."""
    heading: Number = 0.0
    """Of a fixed wheel: its constant heading in the base-yaw frame, rad."""
    steering: Range = (-np.pi / 2, np.pi / 2)
    """Range of σ − θz that holds over the whole box, rad."""
    steering_rate_max: Positive = 2.0
    """Limit of |σ̇|, rad/s."""
    speed_max: Positive = 1.0
    """Limit of the rolling speed |v|, m/s."""
    slip_max: Positive | None = None
    """Of a fixed wheel: how fast it may slip sideways on flat ground, m/s. Default: not at all."""
    force_max: Positive
    """Limit of the normal contact force, N."""
    limb: Limb | None = None
    """Figures of the joints, for the executable profile."""

    @property
    def foot_radius(self) -> float:
        """R of the wheel, or of the ball of a point foot, m."""
        return self.wheel_radius or 0.0

    @property
    def has_wheel(self) -> bool:
        """Whether it stands on a wheel, be it locked, not on a ball or a tip."""
        return self.foot_radius > (BALL_LARGEST if self.foot == "point" else 0.0)

    @field_validator("slip_max")
    @classmethod
    def _is_of_a_fixed_wheel(cls, slip_max: float | None, info: ValidationInfo) -> float | None:
        foot = info.data.get("foot", "fixed")  # what is wrong with the foot is said of the foot
        if slip_max is not None and foot != "fixed":
            raise ValueError(f"must not be given, as the foot is {foot}; valid for: fixed")
        return slip_max

    @model_validator(mode="after")
    def _is_complete(self) -> Leg:
        if self.foot != "point" and self.wheel_radius is None:
            raise ValueError(f"must have a wheel_radius, as its foot is {self.foot}")
        if self.stance[2] >= 0.0:
            raise ValueError("must have its stance below the CoM: stance z < 0")
        return self


class Legs(Config):
    """The four legs by name."""

    FL: Leg
    """Front left."""
    FR: Leg
    """Front right."""
    HL: Leg
    """Hind left."""
    HR: Leg
    """Hind right."""


class Box(Config):
    """A box about a piece of the trunk, as low as that is."""

    x: Range
    """From where to where, base frame, m."""
    y: Range
    """From where to where, base frame, m."""
    z: Number
    """Its lowest height, base frame, m."""


class Sphere(Config):
    """A sphere about a piece of a leg. The leg bends: it goes partly with the base, partly with the foot."""

    leg: LegName
    """The leg that it belongs to."""
    centre: Vector3
    """Its centre in the nominal stance, base frame, m."""
    radius: Positive
    """Its radius, m."""
    with_base: Annotated[Number, Field(ge=0.0, le=1.0)]
    """How much of its way it goes with the base; the rest it goes with its foot."""


class Shapes(Config):
    """What of a robot must not touch the ground besides its feet."""

    belly: tuple[Box, ...] = ()
    """Boxes about the trunk."""
    limbs: tuple[Sphere, ...] = ()
    """Spheres about the legs."""

    @property
    def known(self) -> bool:
        """Whether anything is known of them."""
        return bool(self.belly or self.limbs)

    def seen_from(self, shift: NDArray[np.float64]) -> Shapes:
        """The same shapes from a place that is so far from the one they are seen from, (3,), m."""
        x, y, z = (float(along) for along in shift)
        belly = [
            Box(x=(box.x[0] - x, box.x[1] - x), y=(box.y[0] - y, box.y[1] - y), z=box.z - z)
            for box in self.belly
        ]
        limbs = [
            sphere.model_copy(update={"centre": tuple((np.array(sphere.centre) - shift).tolist())})
            for sphere in self.limbs
        ]
        return Shapes(belly=tuple(belly), limbs=tuple(limbs))


class Robot(Shown, Config):
    """A quadruped as a single rigid body with four feet."""

    name: Line
    """Name under which a scenario asks for it."""
    description: str = ""
    """One line for people."""
    mass: Positive
    """m, kg."""
    inertia: Inertia
    """I_B about the CoM, base axes, kg·m²."""
    box: PositiveVector3
    """b: half-sizes of the box about p̄ in which a foot may be whose leg names none, base-yaw frame, m."""
    legs: Legs
    """The four legs."""
    underside: Shapes = Shapes()
    """What must not touch the ground besides the feet; if nothing is given, nobody looks after it."""
    whole_body: str | None = None
    """File that describes all its joints, for tracking; if none, the one of this name in the library."""
    loads: tuple[Load, ...] | None = None
    """What it carries, which mass, inertia, stance and hips above contain; `with_payload` writes it all."""
    posture: dict[str, Number] | None = None
    """Angles of joints of no leg that are not those of the whole body, rad; `with_posture` writes it."""

    @model_validator(mode="after")
    def _can_stand(self) -> Robot:
        heights = self.stance[:, 2]
        if np.ptp(heights) > 1e-6:
            raise ValueError("must have the nominal contact points of all legs at one height")
        if np.any(self.static_forces() <= 0.0):
            raise ValueError("must stand: the CoM must lie inside the nominal support polygon")
        return self

    @property
    def leg_list(self) -> tuple[Leg, Leg, Leg, Leg]:
        """The legs in the order FL, FR, HL, HR."""
        return (self.legs.FL, self.legs.FR, self.legs.HL, self.legs.HR)

    @property
    def stance(self) -> NDArray[np.float64]:
        """p̄ of all legs, shape (4, 3), m."""
        return np.array([leg.stance for leg in self.leg_list])

    def foot_boxes(self, half_sizes: Sequence[float] | None = None) -> NDArray[np.float64]:
        """Smallest and largest offset of each foot from p̄, base-yaw frame, shape (4, 2, 3), m.

        Args:
            half_sizes: of a box for all feet that goes before those of the robot, m.
        """
        half = np.array(self.box if half_sizes is None else half_sizes)
        own = [leg.box if half_sizes is None else None for leg in self.leg_list]
        return np.array([[-half, half] if sides is None else np.transpose(sides) for sides in own])

    @property
    def height(self) -> float:
        """Height of the CoM above the ground in the nominal stance, m."""
        return float(-self.stance[:, 2].mean())

    @property
    def inertia_matrix(self) -> NDArray[np.float64]:
        """I_B, shape (3, 3), kg·m²."""
        return self.inertia.matrix()

    @property
    def weight(self) -> float:
        """m g, N."""
        return self.mass * GRAVITY

    @property
    def com_offset(self) -> NDArray[np.float64]:
        """From the CoM without its loads, the origin of all `at`, to the CoM, base axes, (3,), m."""
        return com_offset(self.mass, self.loads or ())

    @property
    def mean_inertia(self) -> float:
        """Mean of the three moments of inertia, kg·m²."""
        return float(np.trace(self.inertia_matrix)) / 3.0

    def static_forces(self, p_foot_base: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
        """Normal forces that balance the standing robot, shape (…, 4), N: those of smallest norm.

        Args:
            p_foot_base: contact points from the CoM, shape (…, 4, 2 or 3), m; the nominal stance if not
                given. With fewer than four feet on the ground pass only those, shape (…, n, 2 or 3).
        """
        p = self.stance if p_foot_base is None else np.asarray(p_foot_base, dtype=float)
        balance = np.stack([np.ones(p.shape[:-1]), p[..., 0], p[..., 1]], axis=-2)
        return np.asarray(self.weight * np.linalg.pinv(balance)[..., 0])

    def with_values(self, values: Mapping[str, Any]) -> Robot:
        """A copy with dotted keys set: `{"mass": 90.0, "legs.FL.speed_max": 2.0}`. Raises `InputError`."""
        data = self.model_dump(mode="json")
        for key, value in values.items():
            set_key(data, key, value)
        return validate(Robot, data)

    def with_feet(self, foot: FootKind) -> Robot:
        """The same robot with all feet of another kind (e.g. `point` where the wheels are locked)."""
        data = self.model_dump()
        for leg in data["legs"].values():
            leg["foot"] = foot
            if foot != "fixed":
                leg["slip_max"] = None
        return Robot.model_validate(data)

    def with_payload(
        self, mass: float, at: Sequence[float] = (0.0, 0.0, 0.0), size: Sequence[float] | None = None
    ) -> Robot:
        """The same robot with a load fixed to its base; loads add up, in any order.

        The base link stands over its feet as before, so stance and hips, which are seen from the CoM, shift.

        Args:
            mass: kg.
            at: its centre in the base frame of the robot without loads (origin at its CoM), (3,), m.
            size: edges of a box of even density, (3,), m; a point if not given.

        Raises:
            InputError: a number breaks a rule, or the robot could not stand so.
        """
        return self.with_load(validate(Load, {"mass": mass, "at": at, "size": size}, "payload"))

    def with_load(self, load: Load) -> Robot:
        """`with_payload` of a load. Raises `InputError` if the robot could not stand so."""
        mass, at = self.mass + load.mass, np.array(load.at)
        loads = (*(self.loads or ()), load)
        shift = com_offset(mass, loads) - self.com_offset
        inertia = self.inertia_matrix + self.mass * steiner(shift)
        inertia += load.inertia() + load.mass * steiner(at - com_offset(mass, loads))
        try:
            return self._with_com(mass, inertia, shift, loads)
        except InputError:
            rule = (
                "must leave the CoM over the feet of the nominal stance, below which the robot cannot stand"
            )
            raise InputError("loads.payload", f"{load.mass:g} kg at {list(load.at)} m", rule) from None

    def with_loads(self, loads: Loads) -> Robot:
        """The same robot with its arms as loads say, and with what it carries then.

        Raises:
            InputError: as `with_posture` and `with_payload`.
            MissingExtraError: a posture needs the extra `whole-body`.
        """
        robot = self.with_posture(loads.posture) if loads.posture else self
        for load in loads.payload:
            robot = robot.with_load(load)
        return robot

    @property
    def bare(self) -> Robot:
        """The same robot without its loads."""
        if not self.loads:
            return self
        mass = self.mass - sum(load.mass for load in self.loads)
        offset, inertia = self.com_offset, self.inertia_matrix
        inertia = inertia - mass * steiner(offset)
        for load in self.loads:
            inertia -= load.inertia() + load.mass * steiner(np.array(load.at) - offset)
        return self._with_com(mass, inertia, -offset, None)

    def _with_com(
        self,
        mass: float,
        inertia: NDArray[np.float64],
        shift: NDArray[np.float64],
        loads: tuple[Load, ...] | None,
    ) -> Robot:
        """A copy with other figures, its CoM shifted within the base, where feet, hips and shapes stay."""
        data = self.model_dump(mode="json")
        data["mass"], data["loads"] = float(mass), loads and [load.model_dump() for load in loads]
        rows = {axis: k for k, axis in enumerate("xyz")}
        data["inertia"] = {key: float(inertia[rows[key[0]], rows[key[1]]]) for key in data["inertia"]}
        for leg in data["legs"].values():
            leg["stance"] = (np.array(leg["stance"]) - shift).tolist()
            if leg["limb"] is not None:
                leg["limb"]["hip"] = (np.array(leg["limb"]["hip"]) - shift).tolist()
        data["underside"] = self.underside.seen_from(shift).model_dump(mode="json")
        return validate(Robot, data, "robot")

    def with_posture(self, joints: Mapping[str, float]) -> Robot:
        """The same robot with other angles of joints of no leg, as arms have: another CoM and inertia.

        Needs its whole body; tracking holds those angles, and loads stay where they are on the base link.

        Args:
            joints: angles by the names in the URDF, rad; the others stay as they are.

        Raises:
            InputError: the robot has no whole body, a joint is unknown, a leg's, or beyond its limits, or the
                robot could not stand so.
            MissingExtraError: the extra `whole-body` is not installed.
        """
        # by name: whole bodies are built of robots
        shift, change = import_module("rollgait.robot.standing_com").change_of_posture(self, joints)
        bare = self.bare
        other = bare._with_com(bare.mass, bare.inertia_matrix + change, shift, None)
        other = other.model_copy(update={"posture": {**(self.posture or {}), **joints}})
        for load in self.loads or ():
            other = other.with_load(
                load.model_copy(update={"at": tuple((np.array(load.at) - shift).tolist())})
            )
        return other


def turn_lever(stance: NDArray[np.float64]) -> float:
    """What a turn of 1 rad counts as, m: the way of the outermost foot; `stance` is (4, 2) or (4, 3), m."""
    return float(np.linalg.norm(stance[:, :2], axis=1).max())


__all__ = [
    "GRAVITY",
    "LEG_NAMES",
    "FootKind",
    "Inertia",
    "Leg",
    "LegName",
    "Legs",
    "Limb",
    "Robot",
    "turn_lever",
]
