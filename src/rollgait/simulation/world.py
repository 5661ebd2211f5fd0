"""The world in MuJoCo: the robot's URDF with a free base, its feet, and the ground.

On a plane only the feet collide; on a terrain the base and the legs do as well, with the shapes that the URDF
gives them for it. A wheel is an ellipsoid, thin along its axle: a cylinder of full width would scrub
where it steers. MuJoCo's contacts are soft: a foot sinks in by a fraction of a millimetre and creeps by
millimetres per second.
"""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from typing import Any, Final

import mujoco
import numpy as np
from numpy.typing import NDArray

from rollgait.errors import FileError, InputError
from rollgait.plant.disturbances import Disturbances, Payload
from rollgait.robot.robot import GRAVITY, LEG_NAMES
from rollgait.robot.standing_com import LinkLoad, link_loads
from rollgait.robot.urdf_feet import FootShape, measure_foot
from rollgait.robot.urdf_files import UNLIMITED, Urdf, read_urdf
from rollgait.robot.whole_body import WholeBody
from rollgait.simulation.ground_bodies import CONTACT_TIME, GROUND, add_plane, add_terrain
from rollgait.terrain.terrain import Terrain

Array = NDArray[np.float64]

TIME_STEP: Final = 1e-3
"""Of the simulation, s."""

IMPEDANCE_RATIO: Final = 50.0
"""Of frictional to normal constraints: with MuJoCo's default of 1 a loaded foot slides."""

SLIDING_TIME: Final = 0.2
"""Time constant with which friction takes speed out of feet that are meant to slide, s. MuJoCo lifts what
slides at v as much as an approach at μ v would: with the time constant of a contact's normal, 5 ms, a wheel
at 0.1 m/s bounces a hundred times a second, and while it is in the air its drive spins it up along its
heading, so that the rest of its friction is across. A robot on stiff legs of a plane that skids on the spot
then turns at 0.35 of the rate that Coulomb's law has, with this at 0.8."""

PAYLOAD_RADIUS: Final = 0.05
"""Radius of the ball that a load is drawn as, and an unplanned one is, m."""

WHEEL_WIDTH: Final = 0.25
"""Half the width of a wheel's ellipsoid as a share of its radius."""

POINT_RADIUS: Final = 0.01
"""Radius of a point foot of which no radius is known, m."""

INERTIA_MIN: Final = 1e-9
"""Smallest principal moment of inertia of a link, kg m²; MuJoCo refuses less."""

_FOOT: Final = "foot_"
_HIDDEN: Final = 3
_PAIRS: Final = ("xx", "yy", "zz", "xy", "xz", "yz")
_ROOT: Final = "root_link"
_MESHES: Final = (".stl", ".obj", ".msh")


@dataclass(frozen=True)
class World:
    """A compiled world, and where things are in it.

    Attributes:
        model: MuJoCo's model.
        base: number of the body that is the base link.
        joint_names: the driven joints, in the order of the arrays below and of the actuators.
        position: (n_j,), places of the joints in qpos.
        velocity: (n_j,), places in qvel.
        effort_max: (n_j,), N m, inf where there is no limit.
        feet: (4,), numbers of the geoms that are meant to touch the ground, FL, FR, HL, HR.
        foot_of: for each geom the number of its foot, 0 to 3; −1 if it is none.
        wheels, steering: for each leg the place of its wheel and steering joint in `joint_names`; None where
            it has none.
        legs: for each leg the places of the joints that carry it, without its wheel's, from the base down.
        joints: (n_j,), numbers of the joints in MuJoCo's model.
        radius: (4,), radius of the feet as the controller knows it, m.
        lift: by how much the true feet raise the robot above where the plan has it, m.
    """

    model: Any
    base: int
    joint_names: tuple[str, ...]
    position: NDArray[np.int_]
    velocity: NDArray[np.int_]
    effort_max: Array
    feet: tuple[int, ...]
    foot_of: tuple[int, ...]
    wheels: tuple[int | None, ...]
    steering: tuple[int | None, ...]
    legs: tuple[NDArray[np.int_], ...]
    joints: NDArray[np.int_]
    radius: Array
    lift: float

    def put(self, data: Any, base_position: Array, base_quaternion: Array, joint_position: Array) -> None:
        """Puts the robot somewhere; what follows from it, MuJoCo has yet to compute.

        Args:
            data: MuJoCo's data.
            base_position: origin of the base link, (3,), m.
            base_quaternion: base link to world, (x, y, z, w), (4,).
            joint_position: (n_j,), rad.
        """
        data.qpos[:3] = base_position
        data.qpos[3:7] = np.roll(base_quaternion, 1)
        data.qpos[self.position] = joint_position


def build_world(
    body: WholeBody,
    joint_names: tuple[str, ...],
    disturbances: Disturbances | None = None,
    *,
    damping: Array | None = None,
    ground_height: float = 0.0,
    terrain: Terrain | None = None,
    about: Array | None = None,
    sliding: bool = False,
    visual: bool = False,
) -> World:
    """The robot on the ground, with what it carries.

    Args:
        body: the whole body.
        joint_names: joints that get an actuator, in this order.
        disturbances: friction, radius error, payload and slope are part of the world.
        damping: of the drives, (n_j,), N m s/rad: part of their torque, and integrated implicitly.
        ground_height: z of the ground where that is a plane, m.
        terrain: the ground, in place of the plane. Base and legs then collide with it, too.
        about: where the robot starts on it, (2,), m; the origin if not given.
        sliding: feet slide on the plane as planned, not by accident: see `SLIDING_TIME`.
        visual: load the meshes for people to look at.

    Raises:
        InputError: a joint or a link is not in the URDF.
        FileError: MuJoCo does not understand the URDF, or a mesh is missing.
    """
    given = disturbances or Disturbances()
    urdf = read_urdf(body.urdf)
    colliding = set() if terrain is None else _colliding_links(body, urdf)
    spec = _read(urdf, visual, colliding)
    _set_options(spec, given)
    root = spec.worldbody.first_body()
    root.add_freejoint(name="floating_base")
    efforts = _limits(urdf)
    wheels = {leg.wheel_joint for _, leg in body.leg_list()}
    for joint in spec.joints:
        low, high = joint.range
        if joint.name in wheels or low == high or max(abs(low), abs(high)) >= UNLIMITED:
            joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
        joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE  # the actuators do that
    known, used = [], []
    for name, leg in body.leg_list():
        shape = measure_foot(urdf, f"legs.{name}", leg)
        nominal = shape.radius
        true = (nominal or POINT_RADIUS) * (1.0 + given.radius_error * (leg.wheel is not None))
        _add_foot(spec, name, leg.frame, shape, true, given.friction)
        known.append(nominal)
        used.append(true)
    if terrain is None:
        add_plane(spec, ground_height, given.friction, visual)
        if sliding:
            _let_slide(spec, given.friction)
    else:
        add_terrain(spec, terrain, np.zeros(2) if about is None else about, given.friction, visual)
    for number, load in enumerate(link_loads(body)):
        _add_load(root, f"load_{number}", load)
    if given.payload is not None:
        _add_load(root, "payload", _as_ball(given.payload))
    missing = [name for name in joint_names if name not in {joint.name for joint in spec.joints}]
    if missing:
        raise InputError("joints", missing[0], f"is not a joint of {urdf.path.name}")
    effort_max = np.array([efforts.get(name, np.inf) for name in joint_names])
    for place, driven in enumerate(joint_names):
        _add_drive(spec, driven, 0.0 if damping is None else float(damping[place]), effort_max[place])
    try:
        model = spec.compile()
    except ValueError as error:
        raise FileError("urdf", body.urdf, f"is not understood by MuJoCo: {_first_line(error)}") from None
    places = [model.joint(name) for name in joint_names]
    index = {name: place for place, name in enumerate(joint_names)}
    feet = tuple(model.geom(_FOOT + name).id for name in LEG_NAMES)
    return World(
        model=model,
        base=1,
        joint_names=joint_names,
        position=np.array([joint.qposadr[0] for joint in places]),
        velocity=np.array([joint.dofadr[0] for joint in places]),
        effort_max=effort_max,
        feet=feet,
        foot_of=tuple(feet.index(geom) if geom in feet else -1 for geom in range(model.ngeom)),
        wheels=tuple(index.get(leg.wheel_joint or "") for _, leg in body.leg_list()),
        steering=tuple(index.get(leg.steering_joint or "") for _, leg in body.leg_list()),
        legs=leg_joints(body, urdf, joint_names),
        joints=np.array([joint.id for joint in places]),
        radius=np.array(known),
        lift=float(np.mean(np.subtract(used, known))),
    )


def leg_joints(body: WholeBody, urdf: Urdf, joint_names: tuple[str, ...]) -> tuple[NDArray[np.int_], ...]:
    """For each leg the places in `joint_names` of its joints without the wheel's, from the base down."""
    legs = []
    for _, leg in body.leg_list():
        names = [joint.name for joint in urdf.chain(leg.frame) if joint.name != leg.wheel_joint]
        legs.append(np.array([joint_names.index(name) for name in names if name in joint_names], dtype=int))
    return tuple(legs)


def _colliding_links(body: WholeBody, urdf: Urdf) -> set[str]:
    """What may touch the ground beside the feet before the robot has fallen: links of base and legs."""
    joints = [joint for _, leg in body.leg_list() for joint in urdf.chain(leg.frame)]
    feet = {name for _, leg in body.leg_list() for name in (leg.frame, leg.wheel)}
    return {name for joint in joints for name in (joint.parent, joint.child)} - feet


def _read(urdf: Urdf, visual: bool, colliding: set[str]) -> Any:
    """The URDF as MuJoCo's editable description, with the collision geometry of some links only."""
    root = copy.deepcopy(urdf.root)
    for link in root.findall("link"):
        if link.get("name") == "world":  # MuJoCo would weld it
            _rename(root, "world", _ROOT)
        wanted = {"visual": visual, "collision": link.get("name") in colliding}
        for part in [*link.findall("collision"), *link.findall("visual")]:
            if not (wanted[part.tag] and _is_loadable(part, urdf)):
                link.remove(part)
        _repair_inertia(link)
    for extension in root.findall("mujoco"):
        root.remove(extension)
    settings = {"strippath": "false", "discardvisual": "false", "fusestatic": "false", "autolimits": "true"}
    ET.SubElement(ET.SubElement(root, "mujoco"), "compiler", settings)
    try:
        spec = mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
    except ValueError as error:
        raise FileError(
            "urdf", str(urdf.path), f"is not understood by MuJoCo: {_first_line(error)}"
        ) from None
    for geom in spec.geoms:
        if geom.contype:  # collision geometry: it meets the ground, not the robot itself
            geom.conaffinity, geom.mass, geom.group = 0, 0.0, _HIDDEN
            geom.solref[0] = CONTACT_TIME
    for mesh in spec.meshes:
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # of what is flat, too; it has no mass
    return spec


def _repair_inertia(link: ET.Element) -> None:
    """An inertia that no body can have, as dummy links carry, becomes that of a ball with the same trace."""
    inertia = link.find("inertial/inertia")
    if inertia is None:
        return
    xx, yy, zz, xy, xz, yz = (float(inertia.get(f"i{pair}", "0")) for pair in _PAIRS)
    a, b, c = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if a > INERTIA_MIN and a + b >= c:
        return
    ball = max((xx + yy + zz) / 3.0, INERTIA_MIN)
    for pair in _PAIRS:
        inertia.set(f"i{pair}", repr(ball if pair[0] == pair[1] else 0.0))


def _rename(root: ET.Element, old: str, new: str) -> None:
    for element in root.iter():
        for key in ("name", "link"):
            if element.tag in ("link", "parent", "child") and element.get(key) == old:
                element.set(key, new)


def _is_loadable(part: ET.Element, urdf: Urdf) -> bool:
    """Whether MuJoCo can load a visual or a collision geometry; makes the path of its mesh absolute."""
    for mesh in part.iter("mesh"):
        file = urdf.find_mesh(mesh.get("filename", ""))
        if file is None or file.suffix.lower() not in _MESHES:
            return False
        mesh.set("filename", str(file.absolute()))
    return True


def _limits(urdf: Urdf) -> dict[str, float]:
    """Effort limits by joint, N m; a URDF writes 0 for "not known"."""
    limits = {}
    for joint in urdf.root.findall("joint"):
        limit = joint.find("limit")
        effort = 0.0 if limit is None else float(limit.get("effort", "0"))
        limits[joint.get("name", "")] = effort if 0.0 < effort < UNLIMITED else np.inf
    return limits


def _add_foot(spec: Any, name: str, frame: str, shape: FootShape, radius: float, friction: float) -> None:
    body = spec.body(frame)
    foot = {
        "name": _FOOT + name,
        "mass": 0.0,
        "contype": 1,
        "conaffinity": 0,
        "condim": 3,
        "solref": [CONTACT_TIME, 1.0],
        "friction": [friction, 0.0, 0.0],
        "rgba": [0.1, 0.1, 0.1, 0.35],
    }
    if not shape.axle.any():
        size = [radius, 0.0, 0.0]
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=size, pos=shape.centre, **foot)
        return
    half = WHEEL_WIDTH * radius * shape.axle
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_ELLIPSOID,
        size=[radius, radius, radius],
        fromto=[*(shape.centre - half), *(shape.centre + half)],
        **foot,
    )


def _let_slide(spec: Any, friction: float) -> None:
    """Contacts of feet and plane in which friction is slower, and by as much stiffer: creep is the same."""
    spec.option.impratio *= SLIDING_TIME / CONTACT_TIME
    for name in LEG_NAMES:
        pair = spec.add_pair(geomname1=GROUND, geomname2=_FOOT + name, condim=3)
        pair.friction = [friction, friction, 0.0, 0.0, 0.0]
        pair.solref = [CONTACT_TIME, 1.0]
        pair.solreffriction = [SLIDING_TIME, 1.0]


def _as_ball(payload: Payload) -> LinkLoad:
    """What no plan knows is a ball."""
    inertia = 0.4 * payload.mass * PAYLOAD_RADIUS**2 * np.eye(3)
    return LinkLoad(payload.mass, np.array(payload.place), inertia)


def _add_load(root: Any, name: str, load: LinkLoad) -> None:
    """A body of its own: MuJoCo ignores the mass of a geom in a body whose inertia the URDF gives."""
    body = root.add_body(name=name, pos=load.place, mass=load.mass)
    body.ipos = [0.0, 0.0, 0.0]
    body.inertia = np.maximum(np.diag(load.inertia), INERTIA_MIN)
    body.explicitinertial = True
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[PAYLOAD_RADIUS, 0.0, 0.0],
        contype=0,
        conaffinity=0,
        rgba=[0.8, 0.3, 0.1, 1.0],
    )


def _add_drive(spec: Any, joint: str, damping: float, effort_max: float) -> None:
    """A torque (the control) less the drive's damping, together within the effort limit."""
    drive = spec.add_actuator(
        name=joint,
        target=joint,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
    )
    drive.gainprm[0] = 1.0
    drive.biasprm[2] = -damping
    if np.isfinite(effort_max):
        drive.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
        drive.forcerange = [-effort_max, effort_max]


def _set_options(spec: Any, given: Disturbances) -> None:
    slope = np.radians(given.slope_deg)
    option = spec.option
    option.timestep = TIME_STEP
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = IMPEDANCE_RATIO
    # a simulation that has become unstable shall end as a fall, not start anew
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    option.gravity = [-GRAVITY * np.sin(slope), 0.0, -GRAVITY * np.cos(slope)]


def _first_line(error: Exception) -> str:
    return str(error).strip().splitlines()[0]
