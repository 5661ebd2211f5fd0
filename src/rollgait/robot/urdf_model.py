"""The whole body as pinocchio sees it: a free base, joints, and four legs that end in a wheel or a point.

Everything a task or an import asks of a posture is in `BodyState`, evaluated once for all legs together.
Velocities v of shape (nv,) are those of pinocchio: the base's linear and angular velocity in base axes, then
the joints in the order of `joint_names`. A configuration q of shape (nv + 1,) begins with the base's position
and quaternion (x, y, z, w); the joints' angles follow, one number each.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rollgait.errors import FileError, InputError, UnknownNameError, shown
from rollgait.robot.robot import LEG_NAMES, LegName
from rollgait.robot.standing_com import link_loads, with_angles
from rollgait.robot.urdf_build import build_model
from rollgait.robot.urdf_feet import FootShape, measure_foot
from rollgait.robot.urdf_files import UNLIMITED, Joint, Urdf, read_posture, read_urdf
from rollgait.robot.urdf_posture import LegEnd, find_posture
from rollgait.robot.whole_body import EquippedBody, LegJoints, WholeBody

Array = NDArray[np.float64]

BASE_V: Final = 6
"""Number of velocities of the free base."""

KNEE_BEND_MIN: Final = 0.1
"""Smallest angle of a knee from straight, rad: costs a leg of CENTAURO 0.6 mm of its length."""

LIMIT_SLACK: Final = 1e-3
"""By how much a given posture may pass a joint's limit, rad: both are often rounded."""

_PARALLEL: Final = 0.999
"""Cosine above which two axes count as parallel."""

_UP: Final = np.array([0.0, 0.0, 1.0])

_CONTROLLED: Final = 0.05
"""Smallest singular value (m or rad per rad) above which a leg controls a row of its foot's pose."""


@dataclass(frozen=True)
class LegChain:
    """A leg of the model, by indices into pinocchio's model and into v.

    Attributes:
        name: FL, FR, HL or HR.
        joints: places in v of the joints from the base to the wheel or foot, without that of the wheel.
        wheel: place in v of the wheel's joint; None for a point foot.
        steering: place in v of the joint that steers; None if there is none.
        link: pinocchio's joint that carries the foot, or the wheel's axle.
        ankle: pinocchio's joint above the steering joint; `link` if there is none.
        centre: centre of the wheel or foot in the frame of `link`, m.
        axle: unit vector along the axle, to the left, in the frame of `link`; zero for a point foot.
        upright: unit vector in the frame of `ankle` that points up when the foot stands upright.
        normal: normal of the plane in which the foot can be tilted, in the frame of `ankle`, to the left.
        radius: from the centre to the contact point, m.
        shape: the foot as it was given or measured.
    """

    name: LegName
    joints: tuple[int, ...]
    wheel: int | None
    steering: int | None
    link: int
    ankle: int
    centre: Array
    axle: Array
    upright: Array
    normal: Array
    radius: float
    shape: FootShape


@dataclass(frozen=True)
class BodyState:
    """The whole body at a configuration; world frame, SI units. Legs in the order FL, FR, HL, HR.

    `J_x` is the Jacobian of x: ẋ = J_x v; each has nv columns.

    Attributes:
        q: (nv + 1,).
        p_com: (3,), J_com (3, nv).
        p_base: origin of the base link, (3,), J_base (3, nv).
        R_world_base: (3, 3), J_base_angular (3, nv): angular velocity of the base in world axes.
        p_foot: lowest points of the rims, on level ground the contact points, (4, 3), J_foot (4, 3, nv).
        J_contact: of the material point at `p_foot`, (4, 3, nv): turning the wheel moves it.
        J_angular: of the angular velocity of the wheel, or of the foot's link, in world axes, (4, 3, nv).
        heading: of the wheels, (4,), rad in (−π, π], J_heading (4, nv).
        tilt: of the foot in the plane it can be tilted in, (4,), rad, J_tilt (4, nv).
        camber: angle of the axle above the horizontal, (4,), rad, J_camber (4, nv).
        J_roll: rate of the wheel about its axle in the world, (4, nv): v/R when it rolls without slip.
    """

    q: Array
    p_com: Array
    J_com: Array
    p_base: Array
    J_base: Array
    R_world_base: Array
    J_base_angular: Array
    p_foot: Array
    J_foot: Array
    J_contact: Array
    J_angular: Array
    heading: Array
    J_heading: Array
    tilt: Array
    J_tilt: Array
    camber: Array
    J_camber: Array
    J_roll: Array


class WholeBodyModel:
    """A URDF with a free base, and its legs.

    Attributes:
        config: what it was built from.
        urdf: the URDF.
        pin: pinocchio's model.
        nv: number of velocities.
        joint_names: the joints in the order of q and v behind the base.
        mass: of all links and loads, kg.
        position_lower, position_upper: (nv − 6,), rad, ±inf where there is no limit (the wheels).
        velocity_max, effort_max: (nv − 6,), rad/s and N m, inf where there is no limit.
        legs: the four legs.
        posture: q of the posture the config names, base at the origin; if it names none, one that was found.
        posture_is_found: whether it was.

    Raises:
        InputError: the config names what the URDF does not have, or a leg that cannot be one.
    """

    def __init__(self, config: WholeBody) -> None:
        self.config = config
        self.urdf: Urdf = read_urdf(config.urdf)
        chains = {name: self.urdf.leg_chain(f"legs.{name}", leg.frame) for name, leg in config.leg_list()}
        _check_apart(chains)
        self.pin: Any = build_model(self.urdf)
        for load in link_loads(config):
            self.pin.inertias[1] += pin.Inertia(load.mass, load.place, load.inertia)
        self._data: Any = self.pin.createData()
        self.nv: int = self.pin.nv
        self.joint_names: tuple[str, ...] = tuple(self.pin.names[2:])
        if self.pin.nq != self.nv + 1:
            raise FileError("urdf", config.urdf, "has a joint that does not turn or slide by one number")
        self.mass = float(pin.computeTotalMass(self.pin))
        self._read_limits()
        self.posture = self._read_posture(chains)
        joints = {name: tuple(joint.name for joint in chain) for name, chain in chains.items()}
        self._pose(self.posture)
        self.legs = tuple(self._leg(name, leg, joints[name]) for name, leg in config.leg_list())
        if isinstance(config, EquippedBody):
            self.posture = with_angles(self, self.posture, config.arms)
        self._arrange()
        self._keep_knees_bent()
        self.orientation_rows = tuple(self._controlled(i) for i in range(len(self.legs)))
        """For each leg, which of heading, tilt and camber its joints control beside the place of the foot."""

    # -- what the URDF says --

    def place(self, field: str, joint: str) -> int:
        """Place in v of a joint. Raises `UnknownNameError`."""
        if joint not in self.joint_names:
            raise UnknownNameError(field, joint, self.joint_names, f"is not a joint of {self.urdf.path.name}")
        return BASE_V + self.joint_names.index(joint)

    def _read_limits(self) -> None:
        def limits(array: Any, first: int) -> Array:
            values = np.array(array, dtype=float)[first:]
            return np.where(np.abs(values) >= UNLIMITED, np.copysign(np.inf, values), values)

        self.position_lower = limits(self.pin.lowerPositionLimit, BASE_V + 1)
        self.position_upper = limits(self.pin.upperPositionLimit, BASE_V + 1)
        self.velocity_max = limits(self.pin.velocityLimit, BASE_V)
        self.effort_max = limits(self.pin.effortLimit, BASE_V)
        for limit in (self.velocity_max, self.effort_max):
            limit[limit <= 0.0] = np.inf  # a URDF writes 0 for "not known"
        wheels = [leg.wheel_joint for _, leg in self.config.leg_list() if leg.wheel_joint]
        for name in wheels:
            turning = self.place("legs.wheel_joint", name) - BASE_V
            self.position_lower[turning], self.position_upper[turning] = -np.inf, np.inf
        both_zero = (self.position_lower == 0.0) & (self.position_upper == 0.0)
        self.position_lower[both_zero], self.position_upper[both_zero] = -np.inf, np.inf

    def _read_posture(self, chains: dict[LegName, list[Joint]]) -> Array:
        config = self.config
        self.posture_is_found = False
        if config.posture is not None and config.srdf is None:
            raise InputError("posture", config.posture, "needs an SRDF that defines it")
        angles = read_posture(config.srdf, config.posture) if config.srdf and config.posture else {}
        unknown = [name for name in config.joints if name not in self.joint_names]
        if unknown:
            raise UnknownNameError("joints", unknown[0], self.joint_names, "is not a joint of the URDF")
        angles |= config.joints
        q = np.array(pin.neutral(self.pin), dtype=float)
        for place, name in enumerate(self.joint_names):
            q[BASE_V + 1 + place] = angles.get(name, 0.0)
        if angles:
            self._check_posture(angles, q)
            return q
        ends = [self._end(f"legs.{name}", leg, chains[name]) for name, leg in config.leg_list()]
        found = find_posture(self.pin, ends)
        self.posture_is_found = found is not None
        return q if found is None else found

    def _check_posture(self, angles: dict[str, float], q: Array) -> None:
        """Raises `InputError` for the first given angle that its joint does not reach."""
        for place, name in enumerate(self.joint_names):
            low, high, angle = self.position_lower[place], self.position_upper[place], q[BASE_V + 1 + place]
            if name in angles and not low - LIMIT_SLACK <= angle <= high + LIMIT_SLACK:
                rule = (
                    f"must lie in the joint's range [{low:.4g}, {high:.4g}] rad, in the posture of the robot"
                )
                raise InputError(f"joints.{name}", float(angle), rule)

    def _end(self, field: str, leg: LegJoints, chain: list[Joint]) -> LegEnd:
        shape = measure_foot(self.urdf, field, leg)
        joints = tuple(self.pin.getJointId(joint.name) for joint in chain if joint.name != leg.wheel_joint)
        return LegEnd(joints, self.pin.getBodyId(leg.frame), shape.centre, shape.radius)

    def _leg(self, name: LegName, leg: LegJoints, chain: tuple[str, ...]) -> LegChain:
        field = f"legs.{name}"
        wheel = None if leg.wheel_joint is None else self.place(f"{field}.wheel_joint", leg.wheel_joint)
        if leg.wheel_joint is not None and (not chain or chain[-1] != leg.wheel_joint):
            last = chain[-1] if chain else "none"
            rule = f"must be the last joint above the wheel {leg.wheel}, which is {last}"
            raise InputError(f"{field}.wheel_joint", leg.wheel_joint, rule)
        carrying = chain[:-1] if wheel is not None else chain
        if not carrying:
            raise InputError(field, leg.frame, "must hang on at least one joint")
        steering = None
        if leg.steering_joint is not None:
            steering = self.place(f"{field}.steering_joint", leg.steering_joint)
            if carrying[-1] != leg.steering_joint:
                rule = f"must be the last joint above the wheel's own, which is {carrying[-1]}"
                raise InputError(f"{field}.steering_joint", leg.steering_joint, rule)
        link = self.pin.getJointId(carrying[-1])
        ankle = self.pin.getJointId(carrying[-2]) if steering is not None and len(carrying) > 1 else link
        placements = self._data.oMi
        frame = self._data.oMf[self.pin.getBodyId(leg.frame)]
        shape = measure_foot(self.urdf, field, leg)
        axle_world = np.zeros(3)
        if leg.wheel_joint is not None:
            axle_world = self._axis(leg.wheel_joint)
            axle_world *= np.sign(axle_world[1]) or 1.0  # the base stands at the origin: y is to the left
        upright, normal = _UP, axle_world
        if steering is not None:
            upright = self._axis(carrying[-1])
            upright = upright * (np.sign(upright[2]) or 1.0)
            if len(carrying) > 1 and abs(self._axis(carrying[-2]) @ upright) < 0.1:
                normal = self._axis(carrying[-2])
                normal = normal * (np.sign(normal[1]) or 1.0)
        return LegChain(
            name=name,
            joints=tuple(self.place(field, joint) for joint in carrying),
            wheel=wheel,
            steering=steering,
            link=link,
            ankle=ankle,
            centre=placements[link].actInv(frame.act(shape.centre)),
            axle=placements[link].rotation.T @ axle_world,
            upright=placements[ankle].rotation.T @ upright,
            normal=placements[ankle].rotation.T @ normal,
            radius=shape.radius,
            shape=shape,
        )

    def _axis(self, joint: str) -> Array:
        """Unit vector of a joint's axis in the world, for the configuration evaluated last."""
        pin.computeJointJacobians(self.pin, self._data, self.posture)
        return np.array(self._data.J[3:, BASE_V + self.joint_names.index(joint)])

    # -- postures --

    def _pose(self, q: Array) -> None:
        pin.framesForwardKinematics(self.pin, self._data, q)

    def _arrange(self) -> None:
        """Index arrays for all legs at once; a leg with fewer joints is padded by the column nv of zeros."""
        longest = max(len(leg.joints) for leg in self.legs)
        columns = np.full((len(self.legs), BASE_V + longest + 1), self.nv)
        columns[:, :BASE_V] = np.arange(BASE_V)
        self._on_ankle = np.zeros(columns.shape)
        self._on_ankle[:, :BASE_V] = 1.0
        for i, leg in enumerate(self.legs):
            count = len(leg.joints)
            columns[i, BASE_V : BASE_V + count] = leg.joints
            if leg.wheel is not None:
                columns[i, -1] = leg.wheel
            moving = count - 1 if leg.ankle != leg.link else count
            self._on_ankle[i, BASE_V : BASE_V + moving] = 1.0
        self._columns = columns
        self._on_link = np.ones(columns.shape)
        self._on_link[:, -1] = 0.0
        self._links = [leg.link for leg in self.legs]
        self._ankles = [leg.ankle for leg in self.legs]
        self._radii = np.array([leg.radius for leg in self.legs])
        self._centres = np.array([leg.centre for leg in self.legs])
        self._axles = np.array([leg.axle for leg in self.legs])
        self._normals = np.array([leg.normal for leg in self.legs])
        self._uprights = np.array([leg.upright for leg in self.legs])
        self._wheels = np.array([leg.wheel is not None for leg in self.legs])

    def state(self, q: Array) -> BodyState:
        """Evaluates the whole body at a configuration, shape (nv + 1,)."""
        model, data = self.pin, self._data
        pin.jacobianCenterOfMass(model, data, q, False)
        pin.computeJointJacobians(model, data, q)
        J = np.zeros((6, self.nv + 1))
        J[:, :-1] = data.J
        leg_J = J[:, self._columns].transpose(1, 0, 2)  # (4, 6, m)
        linear, angular = leg_J[:, :3], leg_J[:, 3:]
        angular_link = angular * self._on_link[:, None]
        angular_ankle = angular * self._on_ankle[:, None]
        R_link = np.array([data.oMi[i].rotation for i in self._links])
        origin = np.array([data.oMi[i].translation for i in self._links])
        R_ankle = np.array([data.oMi[i].rotation for i in self._ankles])
        centre = origin + _apply(R_link, self._centres)
        axle = _apply(R_link, self._axles)
        down, down_by_axle = _down(axle)
        p_foot = centre + self._radii[:, None] * down
        # of the contact point about the centre of the wheel
        turn = self._radii[:, None, None] * (down_by_axle @ -_skew(axle))
        J_foot = linear * self._on_link[:, None] + (turn - _skew(centre)) @ angular_link
        J_contact = linear - _skew(p_foot) @ angular
        heading, by_heading = _heading(axle)
        camber, by_camber = _camber(axle)
        tilt, by_tilt = _tilt(_apply(R_ankle, self._uprights), _apply(R_ankle, self._normals), self._wheels)
        R_world_base = np.array(data.oMi[1].rotation)
        p_base = np.array(data.oMi[1].translation)
        J_base_angular = np.zeros((3, self.nv))
        J_base_angular[:, :BASE_V] = J[3:, :BASE_V]
        J_base = np.zeros((3, self.nv))
        J_base[:, :BASE_V] = J[:3, :BASE_V] - _skew(p_base[None])[0] @ J[3:, :BASE_V]
        return BodyState(
            q=q,
            p_com=np.array(data.com[0]),
            J_com=np.array(data.Jcom),
            p_base=p_base,
            J_base=J_base,
            R_world_base=R_world_base,
            J_base_angular=J_base_angular,
            p_foot=p_foot,
            J_foot=self._spread(J_foot),
            J_contact=self._spread(J_contact),
            J_angular=self._spread(angular),
            heading=heading,
            J_heading=self._spread(_row(by_heading, angular_link)),
            tilt=tilt,
            J_tilt=self._spread(_row(by_tilt, angular_ankle)),
            camber=camber,
            J_camber=self._spread(_row(by_camber, angular_link)),
            J_roll=self._spread(_row(axle, angular)),
        )

    def _spread(self, compact: Array) -> Array:
        """Jacobians over the columns of their own leg as Jacobians over all of v."""
        legs = np.arange(len(self.legs))
        if compact.ndim == 2:
            wide = np.zeros((len(legs), self.nv + 1))
            wide[legs[:, None], self._columns] = compact
            return wide[:, :-1]
        full = np.zeros((len(legs), 3, self.nv + 1))
        full[legs[:, None, None], np.arange(3)[None, :, None], self._columns[:, None]] = compact
        return full[..., :-1]

    def joint_axes(self, q: Array, chain: LegChain) -> tuple[Array, Array]:
        """Unit vectors of a leg's joint axes and points on them, world frame, two arrays (joints, 3)."""
        pin.computeJointJacobians(self.pin, self._data, q)
        axes = np.array(self._data.J[3:, list(chain.joints)]).T
        ids = [self.pin.getJointId(self.joint_names[v - BASE_V]) for v in chain.joints]
        return axes, np.array([self._data.oMi[i].translation for i in ids])

    def integrate(self, q: Array, step: Array) -> Array:
        """The configuration after the displacement `step`, shape (nv,), from q."""
        return np.asarray(pin.integrate(self.pin, q, step))

    def difference(self, q0: Array, q1: Array) -> Array:
        """The displacement, shape (nv,), that leads from q0 to q1."""
        return np.asarray(pin.difference(self.pin, q0, q1))

    def inertia(self, q: Array) -> Array:
        """Inertia about the CoM in base axes, (3, 3), kg m²."""
        pin.ccrba(self.pin, self._data, q, np.zeros(self.nv))
        R = np.array(pin.Quaternion(q[3:7]).matrix())
        return np.asarray(R.T @ self._data.Ig.inertia @ R)

    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array:
        """Generalised forces, shape (nv,), that the motion needs, contact forces not counted."""
        return np.array(pin.rnea(self.pin, self._data, q, v, a))

    def _keep_knees_bent(self) -> None:
        """Cuts the limits of the knees so that none gets straight: a straight leg may flip over.

        A knee is the first joint of a leg whose axis is parallel to that of the joint above it.
        """
        self._pose(self.posture)
        placements = self._data.oMi
        for leg in self.legs:
            names = [self.joint_names[v - BASE_V] for v in leg.joints]
            axes = [self._axis(name) for name in names]
            parallel = [bool(abs(a @ b) > _PARALLEL) for a, b in pairwise(axes)]
            if True not in parallel:
                continue
            knee = parallel.index(True) + 1
            follows = parallel[knee:] and parallel[knee]
            end = (
                placements[self.pin.getJointId(names[knee + 1])].translation
                if follows
                else placements[leg.link].act(leg.centre)
            )
            above, here = (placements[self.pin.getJointId(names[i])].translation for i in (knee - 1, knee))
            bend = _angle_about(axes[knee], here - above, end - here)
            place = leg.joints[knee] - BASE_V
            straight = float(self.posture[leg.joints[knee] + 1]) - bend
            if bend > 0.0:
                self.position_lower[place] = max(self.position_lower[place], straight + KNEE_BEND_MIN)
            else:
                self.position_upper[place] = min(self.position_upper[place], straight - KNEE_BEND_MIN)

    def _controlled(self, leg: int) -> tuple[str, ...]:
        chain = self.legs[leg]
        if chain.wheel is None:
            return ()
        state = self.state(self.posture)
        own = list(chain.joints)
        names: list[str] = []
        rows = [state.J_foot[leg][:, own]]
        candidates = {"heading": state.J_heading, "tilt": state.J_tilt, "camber": state.J_camber}
        for name, jacobian in candidates.items():
            trial = np.vstack([*rows, jacobian[leg][None, own]])
            if len(trial) <= len(own) and np.linalg.svd(trial, compute_uv=False)[-1] > _CONTROLLED:
                rows, names = [trial], [*names, name]
        return tuple(names)


def load_model(config: WholeBody) -> WholeBodyModel:
    """The model of a whole body. Raises `InputError`."""
    if not Path(config.urdf).is_file():
        raise FileError("urdf", config.urdf, "cannot be read: there is no such file")
    return WholeBodyModel(config)


def _check_apart(chains: dict[LegName, list[Joint]]) -> None:
    """Raises `InputError` if two legs share a joint: each could not move without the other."""
    owners: dict[str, LegName] = {}
    for name, chain in chains.items():
        for joint in chain:
            if joint.name in owners:
                link = chain[-1].child
                shared = f"shares the joint {shown(joint.name)} with {owners[joint.name]}"
                rule = f"{shared}: each leg must have joints of its own"
                raise InputError(f"legs.{name}", link, rule)
            owners[joint.name] = name


def leg_index(name: LegName) -> int:
    """Place of a leg in arrays over legs."""
    return LEG_NAMES.index(name)


def _angle_about(axis: Array, a: Array, b: Array) -> float:
    """Signed angle from a to b about a unit axis, rad."""
    a, b = a - axis * (axis @ a), b - axis * (axis @ b)
    return float(np.arctan2(axis @ np.cross(a, b), a @ b))


# -- geometry of a wheel: for all legs at once, with the derivative by the angular velocity ω --


def _apply(R: Array, vectors: Array) -> Array:
    return np.asarray((R @ vectors[..., None])[..., 0])


def _row(by_angular_velocity: Array, angular: Array) -> Array:
    """gᵀ J_ω for every leg: (4, 3) and (4, 3, m) to (4, m)."""
    return np.asarray((by_angular_velocity[:, None] @ angular)[:, 0])


def _skew(v: Array) -> Array:
    """[v]×, shape (n, 3, 3)."""
    S = np.zeros((len(v), 3, 3))
    S[:, 0, 1], S[:, 0, 2], S[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    S[:, 1, 0], S[:, 2, 0], S[:, 2, 1] = v[:, 2], -v[:, 1], v[:, 0]
    return S


def _cross(a: Array, b: Array) -> Array:
    """a × b, rows of shape (n, 3): faster than NumPy's for so few rows."""
    return np.stack(
        [
            a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1],
            a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
            a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0],
        ],
        axis=1,
    )


def _down(axle: Array) -> tuple[Array, Array]:
    """Unit vector from the centre to the lowest point of the rim, and its derivative by the axle, (n, 3, 3).

    u = (a a_z − z) / √(1 − a_z²); for a point foot, whose axle is 0, straight down.
    """
    a_z = axle[:, 2]
    s = np.sqrt(np.maximum(1.0 - a_z**2, 1e-6))[:, None]
    wide = axle * a_z[:, None] - _UP
    derivative = np.eye(3) * (a_z[:, None] / s)[..., None]
    derivative[:, :, 2] += axle / s + wide * a_z[:, None] / s**3
    return wide / s, derivative


def _heading(axle: Array) -> tuple[Array, Array]:
    """σ = atan2(−a_x, a_y), and g with σ̇ = g·ω; zero where there is no axle."""
    x, y = axle[:, 0], axle[:, 1]
    square = np.maximum(x**2 + y**2, 1e-6)
    by_axle = np.stack([-y / square, x / square, np.zeros_like(x)], axis=1)
    return np.arctan2(-x, y), _cross(axle, by_axle)


def _camber(axle: Array) -> tuple[Array, Array]:
    """asin(a_z), and g with d/dt = g·ω."""
    z = np.clip(axle[:, 2], -1.0, 1.0)
    by_axle = np.zeros_like(axle)
    by_axle[:, 2] = 1.0 / np.sqrt(np.maximum(1.0 - z**2, 1e-6))
    return np.arcsin(z), _cross(axle, by_axle)


def _tilt(k: Array, n: Array, wheels: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Lean of k in the vertical plane with normal n: atan2(k·(n × z)/|n × z|, k_z), and g with d/dt = g·ω."""
    rho = np.sqrt(np.maximum(n[:, 0] ** 2 + n[:, 1] ** 2, 1e-6))
    t = k[:, 0] * n[:, 1] - k[:, 1] * n[:, 0]
    s, c = t / rho, k[:, 2]
    square = np.maximum(s**2 + c**2, 1e-6)
    by_s, by_c = c / square, -s / square
    by_k = np.stack([by_s * n[:, 1] / rho, -by_s * n[:, 0] / rho, by_c], axis=1)
    by_n = np.stack(
        [
            by_s * (-k[:, 1] / rho - t * n[:, 0] / rho**3),
            by_s * (k[:, 0] / rho - t * n[:, 1] / rho**3),
            np.zeros_like(s),
        ],
        axis=1,
    )
    gradient = _cross(k, by_k) + _cross(n, by_n)
    return np.where(wheels, np.arctan2(s, c), 0.0), gradient * wheels[:, None]
