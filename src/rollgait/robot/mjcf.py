"""MJCF as URDF: MuJoCo reads it, with its defaults, includes and inferred masses; here it is written down.

A link's frame is that of its body, or at the body's joint where that is beside it; of several joints of one
body each but the last gets a link without mass. Angles count from the reference position of the MJCF.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rollgait.errors import FileError, MissingExtraError
from rollgait.robot.whole_body import EXTRA

if TYPE_CHECKING:
    import mujoco

Array = NDArray[np.float64]
Pose = tuple[Array, Array]
"""R (3, 3) and p (3,), m."""

REASON_MAX: Final = 200
"""Most characters of MuJoCo's own words in a message."""

_HERE: Final[Pose] = (np.eye(3), np.zeros(3))


def urdf_of_mjcf(file: Path) -> ET.Element:
    """The robot of an MJCF file as the XML of a URDF: the tree that hangs on a free joint, or the largest.

    Raises:
        FileError: MuJoCo does not understand it, or it has a joint that URDF does not know.
        MissingExtraError: MuJoCo is not installed.
    """
    status = file.stat()
    return ET.fromstring(_converted(str(file.absolute()), status.st_mtime_ns, status.st_size))


@lru_cache(maxsize=8)
def _converted(file: str, written: int, size: int) -> str:
    """The URDF of a file that was written at this time, ns: many ask for it in a row."""
    try:
        import mujoco
    except ImportError:
        raise MissingExtraError("reading MJCF", EXTRA) from None
    try:
        spec = mujoco.MjSpec.from_file(file)
        missing = _without_missing_meshes(spec, Path(file).parent)
        model = spec.compile()
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        reason = " ".join(str(error).split())[:REASON_MAX]
        raise FileError("urdf", file, f"is MJCF that MuJoCo does not understand: {reason}") from None
    meshes = {mesh.name: _mesh_file(mesh, spec, Path(file).parent) for mesh in spec.meshes}
    return ET.tostring(_Conversion(file, model, meshes, missing).robot(), encoding="unicode")


def _mesh_file(mesh: Any, spec: Any, folder: Path) -> Path | None:
    """Where MuJoCo looks for the file of a mesh; None if the MJCF holds its vertices itself."""
    return folder / (spec.meshdir or ".") / mesh.file if mesh.file else None


def _without_missing_meshes(spec: Any, folder: Path) -> dict[str, list[str]]:
    """Takes out what is drawn with meshes of which there is no file: their names by the names of bodies."""
    files = {mesh.name or Path(mesh.file).stem: _mesh_file(mesh, spec, folder) for mesh in spec.meshes}
    gone = {name for name, place in files.items() if place is not None and not place.is_file()}
    missing: dict[str, list[str]] = {}
    for geom in list(spec.geoms):
        if geom.meshname in gone:
            missing.setdefault(geom.parent.name, []).append(str(files[geom.meshname]))
            spec.delete(geom)
    for mesh in list(spec.meshes):
        if (mesh.name or Path(mesh.file).stem) in gone:
            spec.delete(mesh)
    return missing


class _Conversion:
    """One MJCF on its way to a URDF."""

    def __init__(
        self,
        file: str,
        model: mujoco.MjModel,
        meshes: dict[str, Path | None],
        missing: dict[str, list[str]],
    ) -> None:
        import mujoco

        self.file = file
        self.model: Any = model
        self.meshes = meshes
        self.missing = missing
        self.kinds: dict[int, str] = {int(kind): kind.name for kind in mujoco.mjtJoint.__members__.values()}
        self.shapes: dict[int, str] = {int(kind): kind.name for kind in mujoco.mjtGeom.__members__.values()}
        self.objects: Any = mujoco.mjtObj
        self.named = mujoco.mj_id2name
        self.root = ET.Element("robot", name=Path(file).stem)

    def robot(self) -> ET.Element:
        self._add_body(self._base(), above=None, frame=_HERE)
        return self.root

    # -- the tree --

    def _base(self) -> int:
        """The body that everything of the robot hangs on."""
        m = self.model
        top = [b for b in range(1, m.nbody) if m.body_parentid[b] == 0]
        free = [b for b in top if any(self._kind(j) == "mjJNT_FREE" for j in self._joints(b))]
        moving = {b: int(np.sum(m.body_rootid[m.jnt_bodyid] == b)) for b in top}
        if not top:
            raise FileError("urdf", self.file, "is MJCF without a body")
        if not free and sum(count > 0 for count in moving.values()) > 1:
            rule = "is MJCF whose legs hang on the world: the base must be a body with a freejoint"
            raise FileError("urdf", self.file, rule)
        return max(free or top, key=lambda b: moving[b])

    def _add_body(self, body: int, above: str | None, frame: Pose) -> None:
        """A body, the joints it hangs on, and all below it.

        Args:
            body: its number.
            above: the link it hangs on; None for the base.
            frame: of the body in the frame of that link.
        """
        m, name = self.model, self._name("mjOBJ_BODY", body)
        link, shift = name, np.zeros(3)
        if above is not None:
            joints = self._joints(body)
            for number, j in enumerate(joints):
                last = number == len(joints) - 1
                link = name if last else f"{name}_{number}"
                place = np.array(m.jnt_pos[j])  # in the frame of the body
                R, p = frame
                self._add_joint(j, above, link, (R, p + R @ (place - shift)))
                frame, shift, above = _HERE, place, link
                if not last:
                    ET.SubElement(self.root, "link", name=link)
            if not joints:
                self._connect(f"{name}_fixed", "fixed", above, name, frame)
        self._add_link(body, link, shift)
        for child in range(1, m.nbody):
            if m.body_parentid[child] == body:
                R = _matrix(m.body_quat[child])
                self._add_body(child, link, (R, np.array(m.body_pos[child]) - shift))

    def _joints(self, body: int) -> list[int]:
        first, count = int(self.model.body_jntadr[body]), int(self.model.body_jntnum[body])
        return list(range(first, first + count))

    def _kind(self, joint: int) -> str:
        return self.kinds[int(self.model.jnt_type[joint])]

    def _add_joint(self, joint: int, above: str, link: str, frame: Pose) -> None:
        m, name = self.model, self._name("mjOBJ_JOINT", joint)
        kind = self._kind(joint)
        if kind not in ("mjJNT_HINGE", "mjJNT_SLIDE"):
            rule = f"is MJCF with the joint {name}, which must be a hinge or a slide"
            raise FileError("urdf", self.file, rule)
        limited = bool(m.jnt_limited[joint])
        turns = kind == "mjJNT_HINGE"
        tag = ("revolute" if limited else "continuous") if turns else "prismatic"
        element = self._connect(name, tag, above, link, frame)
        ET.SubElement(element, "axis", xyz=_text(m.jnt_axis[joint]))
        reference = float(m.qpos0[m.jnt_qposadr[joint]])
        ends = m.jnt_range[joint] - reference if limited else np.array([0.0, 0.0])
        limit = {"effort": _text([self._effort(joint)]), "velocity": "0"}  # 0: not known
        if limited or not turns:
            limit |= {"lower": _text(ends[:1]), "upper": _text(ends[1:])}
        ET.SubElement(element, "limit", limit)

    def _effort(self, joint: int) -> float:
        """Largest force or torque of the motors on a joint, N or N m; 0 if there is no limit."""
        m = self.model
        if m.jnt_actfrclimited[joint]:
            return float(np.abs(m.jnt_actfrcrange[joint]).max())
        motors = [a for a in range(m.nu) if m.actuator_trntype[a] == 0 and m.actuator_trnid[a, 0] == joint]
        return max((self._strength(a) for a in motors), default=0.0)

    def _strength(self, motor: int) -> float:
        """Largest force or torque of a motor; 0 if there is no limit or its control is no force."""
        m = self.model
        gear = abs(float(m.actuator_gear[motor, 0]))
        if m.actuator_forcelimited[motor]:
            return gear * float(np.abs(m.actuator_forcerange[motor]).max())
        is_force = m.actuator_gaintype[motor] == 0 and m.actuator_biastype[motor] == 0
        if is_force and m.actuator_ctrllimited[motor]:
            gain = abs(float(m.actuator_gainprm[motor, 0]))
            return gear * gain * float(np.abs(m.actuator_ctrlrange[motor]).max())
        return 0.0

    def _connect(self, name: str, kind: str, above: str, link: str, frame: Pose) -> ET.Element:
        element = ET.SubElement(self.root, "joint", name=name, type=kind)
        ET.SubElement(element, "parent", link=above)
        ET.SubElement(element, "child", link=link)
        element.append(_origin(frame))
        return element

    # -- what a link is --

    def _add_link(self, body: int, name: str, shift: Array) -> None:
        m = self.model
        link = ET.SubElement(self.root, "link", name=name)
        if m.body_mass[body] > 0.0:
            R = _matrix(m.body_iquat[body])
            tensor = R @ np.diag(m.body_inertia[body]) @ R.T
            inertial = ET.SubElement(link, "inertial")
            inertial.append(_origin((np.eye(3), np.array(m.body_ipos[body]) - shift)))
            ET.SubElement(inertial, "mass", value=_text([m.body_mass[body]]))
            pairs = (("ixx", 0, 0), ("iyy", 1, 1), ("izz", 2, 2), ("ixy", 0, 1), ("ixz", 0, 2), ("iyz", 1, 2))
            ET.SubElement(inertial, "inertia", {key: _text([tensor[i, k]]) for key, i, k in pairs})
        geoms = [g for g in range(m.ngeom) if m.geom_bodyid[g] == body]
        solid = [g for g in geoms if m.geom_contype[g] or m.geom_conaffinity[g]]
        for tag, chosen in (("visual", [g for g in geoms if g not in solid] or solid), ("collision", solid)):
            for geom in chosen:
                for shape, pose in self._shapes(geom):
                    element = ET.SubElement(link, tag)
                    element.append(_origin((pose[0], pose[1] - shift)))
                    ET.SubElement(element, "geometry").append(shape)
        for file in self.missing.get(self._name("mjOBJ_BODY", body), []):
            geometry = ET.SubElement(ET.SubElement(link, "visual"), "geometry")
            ET.SubElement(geometry, "mesh", filename=file)

    def _shapes(self, geom: int) -> Iterator[tuple[ET.Element, Pose]]:
        """The shapes of a geom, in the frame of its body; none for what URDF does not know."""
        m = self.model
        kind, size = self.shapes[int(m.geom_type[geom])], m.geom_size[geom]
        R, p = _matrix(m.geom_quat[geom]), np.array(m.geom_pos[geom])
        if kind == "mjGEOM_SPHERE":
            yield ET.Element("sphere", radius=_text(size[:1])), (R, p)
        elif kind in ("mjGEOM_BOX", "mjGEOM_ELLIPSOID"):
            yield ET.Element("box", size=_text(2.0 * size)), (R, p)
        elif kind in ("mjGEOM_CYLINDER", "mjGEOM_CAPSULE"):
            yield ET.Element("cylinder", radius=_text(size[:1]), length=_text(2.0 * size[1:2])), (R, p)
            if kind == "mjGEOM_CAPSULE":
                for end in (-1.0, 1.0):
                    ball = p + end * size[1] * R[:, 2]
                    yield ET.Element("sphere", radius=_text(size[:1])), (R, ball)
        elif kind == "mjGEOM_MESH":
            mesh = int(m.geom_dataid[geom])
            file = self.meshes.get(self._name("mjOBJ_MESH", mesh))
            if file is not None:  # MuJoCo has moved its vertices to its principal axes
                R = R @ _matrix(m.mesh_quat[mesh]).T
                p = p - R @ np.array(m.mesh_pos[mesh])
                scale = _text(m.mesh_scale[mesh])
                yield ET.Element("mesh", filename=str(file), scale=scale), (R, p)

    def _name(self, kind: str, number: int) -> str:
        name = self.named(self.model, getattr(self.objects, kind), number)
        return str(name or f"{kind.removeprefix('mjOBJ_').lower()}_{number}")


def _matrix(wxyz: Any) -> Array:
    return np.asarray(Rotation.from_quat(np.array(wxyz), scalar_first=True).as_matrix())


def _origin(frame: Pose) -> ET.Element:
    return ET.Element("origin", xyz=_text(frame[1]), rpy=_text(_roll_pitch_yaw(frame[0])))


def _roll_pitch_yaw(R: Array) -> tuple[float, float, float]:
    """R = Rz(yaw) Ry(pitch) Rx(roll); with the x axis straight up or down the roll is 0."""
    upright = math.hypot(R[0, 0], R[1, 0])
    pitch = math.atan2(-R[2, 0], upright)
    if upright < 1e-9:
        return 0.0, pitch, math.atan2(-R[0, 1], R[1, 1])
    return math.atan2(R[2, 1], R[2, 2]), pitch, math.atan2(R[1, 0], R[0, 0])


def _text(values: Any) -> str:
    return " ".join(f"{float(value):.12g}" for value in np.asarray(values).ravel())
