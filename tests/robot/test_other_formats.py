"""Robots that are not URDF: MJCF against MuJoCo's own kinematics, xacro, names of public robots."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pinocchio", reason="needs the extra whole-body")

import mujoco
import pinocchio as pin

from rollgait.errors import InputError
from rollgait.robot.model_files import model_file
from rollgait.robot.urdf_build import build_model
from rollgait.robot.urdf_discovery import discover
from rollgait.robot.urdf_files import read_urdf
from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.robot.urdf_shapes import shapes_of, welded
from tests.robot.lookalikes import LOOKALIKES

FREE = (
    '<link name="world"/><joint name="free" type="floating"><parent link="world"/>'
    '<child link="trunk"/></joint>'
    '<mujoco><compiler fusestatic="false"/></mujoco></robot>'
)

ODD = """<mujoco>
<compiler angle="degree"/>
<asset><mesh name="wedge" file="wedge.obj" scale="2 1 1"/><mesh name="gone" file="gone.stl"/></asset>
<worldbody>
  <geom type="plane" size="5 5 1"/>
  <body name="post"><geom size="0.1"/></body>
  <body name="base" pos="0 0 0.5" euler="10 20 30"><freejoint/>
    <geom type="box" size="0.3 0.2 0.1" mass="10"/><geom type="mesh" mesh="gone" contype="0" conaffinity="0"/>
    <body name="arm" pos="0.3 0.1 0" euler="0 90 0">
      <joint name="a" axis="1 1 0" pos="0.05 0.02 -0.1" range="-40 80" ref="15" actuatorfrcrange="-7 7"/>
      <geom type="capsule" fromto="0 0 0 0.2 0.1 0" size="0.03" mass="1"/>
      <geom type="mesh" mesh="wedge" pos="0.1 0 0.2" euler="0 0 70" contype="0" conaffinity="0" mass="0"/>
      <body pos="0.2 0.1 0">
        <joint name="b" axis="0 0 1" pos="0 0.3 0"/><geom type="cylinder" size="0.1 0.02" mass="0.5"/>
        <body name="tip" pos="0 0 0.1"><geom type="sphere" size="0.02" mass="0.1"/></body>
      </body>
    </body>
  </body>
</worldbody>
<actuator><motor joint="b" gear="3" ctrlrange="-2 1"/></actuator>
</mujoco>"""

WEDGE = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.4]])


@pytest.fixture
def odd(tmp_path: Path) -> Path:
    faces = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
    vertices = "".join(f"v {x} {y} {z}\n" for x, y, z in WEDGE)
    (tmp_path / "wedge.obj").write_text(vertices + faces)
    file = tmp_path / "odd.xml"
    file.write_text(ODD)
    return file


def as_mjcf(urdf: str) -> str:
    """A URDF as MuJoCo writes it down; it reads no meshes that are missing."""
    spec = mujoco.MjSpec.from_string(re.sub("<visual>.*?</visual>", "", urdf).replace("</robot>", FREE))
    spec.compile()
    return str(spec.to_xml())


@pytest.mark.parametrize("name", ["fixed-at-joint", "steerable-plain", "point-at-joint"])
def test_mjcf_is_the_robot_that_its_urdf_is(name: str, tmp_path: Path) -> None:
    look = LOOKALIKES[name]
    models = []
    for suffix, text in ((".urdf", look.urdf()), (".xml", as_mjcf(look.urdf()))):
        file = (tmp_path / name).with_suffix(suffix)
        file.write_text(text)
        models.append(WholeBodyModel(discover(file)))
    ours, theirs = models
    assert theirs.joint_names == ours.joint_names
    assert theirs.mass == pytest.approx(look.mass, rel=1e-5)
    for limits in ("position_lower", "position_upper", "effort_max"):
        np.testing.assert_allclose(getattr(theirs, limits), getattr(ours, limits), rtol=1e-5)
    rng = np.random.default_rng(0)
    for _ in range(3):
        q = ours.integrate(ours.posture, 0.3 * rng.normal(size=ours.nv))
        a, b = ours.state(q), theirs.state(q)
        np.testing.assert_allclose(b.p_com, a.p_com, atol=1e-6)
        np.testing.assert_allclose(b.p_foot, a.p_foot, atol=1e-4)  # posture and centres are rounded
        np.testing.assert_allclose(theirs.inertia(q), ours.inertia(q), rtol=1e-4, atol=1e-6)


def test_bodies_are_where_mujoco_has_them(odd: Path) -> None:
    """Joints beside their bodies, reference angles, turned frames, bodies without name."""
    spec = mujoco.MjSpec.from_file(str(odd))
    spec.delete(next(geom for geom in spec.geoms if geom.meshname == "gone"))
    spec.delete(spec.mesh("gone"))
    theirs = spec.compile()
    data = mujoco.MjData(theirs)
    urdf = read_urdf(odd)
    model = build_model(urdf)
    ours = model.createData()
    assert sorted(model.names[2:]) == ["a", "b"]
    rng = np.random.default_rng(0)
    for _ in range(5):
        angles = rng.uniform(-0.5, 0.5, 2)
        q = pin.neutral(model)
        for name, angle in zip("ab", angles, strict=True):
            q[model.joints[model.getJointId(name)].idx_q] = angle
            data.joint(name).qpos = angle + theirs.qpos0[theirs.joint(name).qposadr]
        mujoco.mj_forward(theirs, data)
        pin.framesForwardKinematics(model, ours, q)
        pin.centerOfMass(model, ours, q)
        base = pin.SE3(data.body("base").xmat.reshape(3, 3), data.body("base").xpos)
        assert base.act(ours.com[0]) == pytest.approx(data.body("base").subtree_com, abs=1e-9)
        tip = base * ours.oMf[model.getFrameId("tip")]
        assert tip.translation == pytest.approx(data.body("tip").xpos, abs=1e-9)
        assert tip.rotation == pytest.approx(data.body("tip").xmat.reshape(3, 3), abs=1e-9)


def test_limits_and_shapes_of_mjcf(odd: Path) -> None:
    urdf = read_urdf(odd)
    limit = urdf.joint_elements["a"].find("limit").attrib
    assert [float(limit[k]) for k in ("lower", "upper")] == pytest.approx(np.radians([-55.0, 65.0]))
    assert (float(limit["effort"]), float(urdf.joint_elements["b"].find("limit").get("effort"))) == (7.0, 6.0)
    arm = {"arm": welded(urdf, "arm")["arm"]}
    assert sorted(shape.kind for shape in shapes_of(urdf, arm, "collision")) == [
        "cylinder",
        "sphere",
        "sphere",
    ]
    (wedge,) = shapes_of(urdf, arm, "visual")
    c, s = np.cos(np.radians(70.0)), np.sin(np.radians(70.0))
    turned = WEDGE * [2.0, 1.0, 1.0] @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    expected = turned + np.array([0.1, 0.0, 0.2]) - [0.05, 0.02, -0.1]  # the link's frame is at the joint
    distance = np.linalg.norm(wedge.points()[:, None] - expected, axis=2)
    assert distance.min(axis=0).max() < 1e-6
    assert urdf.missing_meshes() == [str(odd.parent / "gone.stl")]


def test_mjcf_that_is_wrong_is_one_sentence(odd: Path) -> None:
    odd.write_text(
        ODD.replace('<joint name="b" axis="0 0 1" pos="0 0.3 0"/>', '<joint name="b" type="ball"/>')
    )
    with pytest.raises(InputError, match="the joint b, which must be a hinge or a slide"):
        read_urdf(odd)
    odd.write_text(ODD.replace("<freejoint/>", "<freejoin/>"))
    with pytest.raises(InputError, match=r"MuJoCo does not understand: .*freejoin") as error:
        read_urdf(odd)
    assert "\n" not in str(error.value)
    legs = '<body name="post"><joint name="p"/><geom size="0.1"/></body>'
    odd.write_text(
        ODD.replace("<freejoint/>", "").replace('<body name="post"><geom size="0.1"/></body>', legs)
    )
    with pytest.raises(InputError, match="must be a body with a freejoint"):
        read_urdf(odd)


XACRO = """<robot name="box" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="m" value="2"/>
<link name="a"><inertial><mass value="${2 * m}"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


def test_only_an_import_expands_xacro(tmp_path: Path) -> None:
    """It holds expressions; opening a robot that names one must not evaluate them."""
    file = tmp_path / "box.urdf.xacro"
    file.write_text(XACRO)
    with pytest.raises(InputError, match=r"is a xacro file: .* xacro box.urdf.xacro > box-expanded.urdf"):
        read_urdf(file)
    assert list(tmp_path.iterdir()) == [file]


def test_xacro_is_expanded_where_a_package_does_that(tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    file = tmp_path / "box.urdf.xacro"
    file.write_text(XACRO)
    assert model_file(file) == tmp_path / "box-expanded.urdf"
    assert float(read_urdf(model_file(file)).links["a"].find("inertial/mass").get("value")) == 4.0
    file.write_text(XACRO.replace("2 * m", "2 * n"))
    with pytest.raises(InputError, match=r"refuses: .*n"):
        model_file(file)


def test_names_of_public_robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a package that has the form of robot_descriptions."""
    package = tmp_path / "robot_descriptions"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "hopper_mj_description.py").write_text("MJCF_PATH = '/robots/hopper.xml'")
    (package / "offline_description.py").write_text("raise OSError('no network')")
    for name in [name for name in sys.modules if name.startswith("robot_descriptions")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.syspath_prepend(tmp_path)
    assert model_file("hopper") == model_file("hopper_mj_description") == Path("/robots/hopper.xml")
    assert model_file("unheard_of") == Path("unheard_of")
    with pytest.raises(InputError, match=r"model: 'offline' cannot be had from .*: no network"):
        model_file("offline")
    for name in [name for name in sys.modules if name.startswith("robot_descriptions")]:
        monkeypatch.delitem(sys.modules, name)


def test_a_file_of_example_robot_data_is_found_by_its_prefix() -> None:
    file = model_file("example-robot-data:hyq_description/robots/hyq_no_sensors.urdf")
    assert read_urdf(file)
    for path in ("nothing.urdf", "../robots", "../../../../etc/passwd"):
        with pytest.raises(InputError, match="there is no such file in the package"):
            model_file(f"example-robot-data:{path}")
