"""From a URDF to a robot: what comes out, and one sentence for each thing that may be wrong."""

import shutil
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pinocchio", reason="needs the extra whole-body")

import rollgait as rg
from rollgait.errors import InputError
from rollgait.robot import Robot, find_robot
from rollgait.robot.urdf import import_robot
from rollgait.robot.urdf_files import read_urdf
from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.robot.urdf_stance import nominal_stance, reach
from rollgait.robot.whole_body import library_whole_body, load_whole_body, whole_body_names

FIXTURES = Path(__file__).parent.parent / "fixtures"


@pytest.fixture
def roller(tmp_path: Path) -> Path:
    """The fixture's files in a folder of their own, to be spoilt."""
    for suffix in (".urdf", ".srdf", ".yaml"):
        shutil.copy(FIXTURES / f"roller{suffix}", tmp_path)
    return tmp_path / "roller.yaml"


def spoil(file: Path, old: str, new: str, count: int = -1) -> None:
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, count))


def numbers(data) -> list[float]:
    """All numbers in nested data, in order."""
    if isinstance(data, dict):
        return [n for key in sorted(data) for n in numbers(data[key])]
    if isinstance(data, list | tuple):
        return [n for value in data for n in numbers(value)]
    return [float(data)] if isinstance(data, int | float) else []


@pytest.mark.parametrize("name", whole_body_names())
def test_robots_of_the_library_equal_the_import(name: str) -> None:
    found = import_robot(library_whole_body(name)).robot
    known = find_robot(name)
    assert found.model_dump(exclude={"inertia", "legs"}) == known.model_dump(exclude={"inertia", "legs"})
    assert numbers(found.model_dump()) == pytest.approx(numbers(known.model_dump()), abs=2e-4)
    assert [leg.foot for leg in found.leg_list] == [leg.foot for leg in known.leg_list]


def test_the_closed_form_of_the_limb_is_the_hardware() -> None:
    """hip_yaw and the steering joint by the limb's formulas, against inverse kinematics all over the box."""
    from rollgait.plan.certificate.limits import joint_angles
    from rollgait.plan.certificate.limits import reach as limb_reach

    model = WholeBodyModel(library_whole_body("centauro"))
    stance, robot = nominal_stance(model), find_robot("centauro")
    rng = np.random.default_rng(0)
    for _ in range(20):
        offset = rng.uniform(-1, 1, 3) * [0.08, 0.08, 0.04]
        state, errors = reach(model, stance.q, lambda _, offset=offset: stance.state.p_foot + offset)
        assert np.max(errors) < 1e-6
        for i, (leg, chain) in enumerate(zip(robot.leg_list, model.legs, strict=True)):
            foot = state.p_foot[i] - stance.state.p_com
            hip_yaw, steering = joint_angles(leg.limb, foot, np.zeros(()))
            assert hip_yaw == pytest.approx(state.q[chain.joints[0] + 1], abs=2e-3)
            assert steering == pytest.approx(state.q[chain.steering + 1], abs=2e-3)
            knee = state.q[chain.joints[2] + 1]
            extension = np.sqrt(0.3**2 + 0.2**2 + 2 * 0.3 * 0.2 * np.cos(knee))
            assert limb_reach(leg.limb, foot)[0] == pytest.approx(extension, abs=1e-4)


@pytest.mark.parametrize("name", ["centauro", "roller", "hyq"])
def test_the_stance_is_symmetric_level_upright_and_straight(name: str) -> None:
    body = library_whole_body(name) if name == "centauro" else load_whole_body(FIXTURES / f"{name}.yaml")
    model = WholeBodyModel(body)
    stance = nominal_stance(model)
    feet = stance.feet
    assert np.allclose(feet[[0, 2], 1], -feet[[1, 3], 1], atol=1e-8)
    assert np.allclose(feet[[0, 2], 0], feet[[1, 3], 0], atol=1e-8)
    assert np.ptp(feet[:, 2]) < 1e-8
    if name == "centauro":
        assert np.allclose(stance.state.heading, 0.0, atol=1e-8)
        assert np.allclose(stance.state.camber, 0.0, atol=1e-8)


def test_a_toed_out_posture_becomes_straight() -> None:
    body = library_whole_body("centauro").model_copy(update={"posture": "homing_balanced"})
    model = WholeBodyModel(body)
    assert np.abs(model.state(model.posture).heading).max() > 0.09
    assert np.abs(nominal_stance(model).state.heading).max() < 1e-8


def test_fixed_wheels_and_point_feet() -> None:
    roller = import_robot(load_whole_body(FIXTURES / "roller.yaml")).robot
    assert {leg.foot for leg in roller.leg_list} == {"fixed"}
    assert [leg.heading for leg in roller.leg_list] == pytest.approx([0.0] * 4)
    assert roller.legs.FL.speed_max == pytest.approx(30.0 * 0.1)  # wheel joint's limit times radius
    hyq = import_robot(load_whole_body(FIXTURES / "hyq.yaml")).robot
    assert {leg.foot for leg in hyq.leg_list} == {"point"}
    assert [leg.wheel_radius for leg in hyq.leg_list] == pytest.approx([0.02175] * 4)


def test_feet_that_are_no_fixed_wheels_do_not_skid() -> None:
    body = load_whole_body(FIXTURES / "hyq.yaml")
    skids = body.model_copy(update={"planner": body.planner.model_copy(update={"slip_max": 0.1})})
    with pytest.raises(
        InputError, match=r"^planner\.slip_max: 0\.1 must not be given, as no foot is a fixed"
    ):
        import_robot(skids)


def test_the_box_is_reachable_all_over() -> None:
    model = WholeBodyModel(load_whole_body(FIXTURES / "roller.yaml"))
    box = np.array(import_robot(model.config).robot.box)
    stance, rng = nominal_stance(model), np.random.default_rng(0)
    for _ in range(30):
        places = stance.state.p_foot + rng.uniform(-1, 1, (4, 3)) * box
        assert np.max(reach(model, stance.q, lambda _, places=places: places)[1]) < 1e-6


def test_findings_say_what_is_chosen() -> None:
    found = import_robot(load_whole_body(FIXTURES / "roller.yaml"))
    chosen = {f.name for f in found.findings if not f.known}
    assert chosen == {"contact force"}
    assert {"mass", "inertia", "stance FL", "reachable box", "speed"} <= {f.name for f in found.findings}


def test_a_robot_that_is_written_is_read_back(tmp_path: Path) -> None:
    from rollgait.config import dump_yaml

    robot = import_robot(load_whole_body(FIXTURES / "roller.yaml"), "roller.yaml").robot
    file = tmp_path / "robot.yaml"
    file.write_text(dump_yaml(robot.model_dump(mode="json", exclude_none=True)))
    assert find_robot(str(file)) == robot
    assert isinstance(robot, Robot)


def test_a_posture_of_an_srdf_goes_before_the_one_that_is_found(tmp_path: Path) -> None:
    text = (FIXTURES / "roller.urdf").read_text()
    urdf = tmp_path / "bare.urdf"
    urdf.write_text(text)
    srdf, described = FIXTURES / "roller.srdf", import_robot(load_whole_body(FIXTURES / "roller.yaml"))
    found = rg.import_robot(urdf, srdf=srdf, posture="stand")
    np.testing.assert_allclose(found.robot.stance, described.robot.stance, atol=1e-4)
    with pytest.raises(InputError, match=r"^posture: must name a group state .*; valid: stand$"):
        rg.import_robot(urdf, srdf=srdf)


def test_a_floating_joint_at_the_root_counts_once(roller: Path) -> None:
    urdf = roller.with_suffix(".urdf")
    spoil(urdf, '<joint name="weld" type="fixed">', '<joint name="weld" type="floating">')
    assert "world" not in read_urdf(urdf).links
    assert WholeBodyModel(load_whole_body(roller)).nv == 22


def test_a_joint_may_have_the_name_of_a_link(roller: Path) -> None:
    spoil(roller.with_suffix(".urdf"), 'joint name="FL_roll"', 'joint name="FL_wheel"')
    spoil(roller, "FL_roll", "FL_wheel")
    assert WholeBodyModel(load_whole_body(roller)).mass == pytest.approx(40.0)


XACRO = "http://www.ros.org/wiki/xacro"
JOINT = '<joint name="FL_kfe" type="revolute">'
BAD = {
    "posture outside the limits": (".srdf", 'value="1.4"', 'value="3.0"', "FL_kfe: 3.0 must lie in"),
    "xacro": (".urdf", '<link name="world"/>', f'<x:macro xmlns:x="{XACRO}"/>', "a xacro file"),
    "MJCF": (".urdf", '<robot name="roller">', "<mujoco/><!--", "XML"),
    "wrong frame": (".yaml", "wheel: FL_wheel", "wheel: FL_weel", "valid: FL_wheel"),
    "wrong joint": (".yaml", "wheel_joint: FL_roll", "wheel_joint: FL_rol", "valid: FL_roll"),
    "joint of another leg": (".yaml", "wheel_joint: FL_roll", "wheel_joint: FR_roll", "FL_roll"),
    "prismatic joint": (".urdf", JOINT, '<joint name="FL_kfe" type="prismatic">', "prismatic joint, FL_kfe"),
    "mimic joint": (".urdf", JOINT, JOINT + '<mimic joint="FL_hfe"/>', "mimics FL_hfe"),
    "unreachable stance": (".yaml", "posture: stand", "posture: stand\nheight: 0.9", "stance"),
    "unknown posture": (".yaml", "posture: stand", "posture: stad", "valid: stand"),
    "unknown joint": (".yaml", "posture: stand", "posture: stand\njoints: {FL_kfee: 1.0}", "valid: FL_kfe"),
    "no mass": (".urdf", '<mass value="20"/>', '<mass value="0"/>', "mass 0 kg must be greater than 0"),
    "no XML": (".urdf", "</robot>", "", "XML"),
    "no URDF": (".yaml", "urdf: roller.urdf", "urdf: rolle.urdf", "rolle.urdf"),
    "no radius": (".urdf", '<cylinder radius="0.1" length="0.04"/>', '<box size="1 1 1"/>', "radius"),
    "neither wheel nor foot": (".yaml", "{wheel: FL_wheel, wheel_joint: FL_roll}", "{}", "wheel or a foot"),
    "surplus key": (".yaml", "wheel: FL_wheel", "weel: FL_wheel", "valid: wheel"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_sentence(roller: Path, case: str) -> None:
    suffix, old, new, said = BAD[case]
    spoil(roller.with_suffix(suffix), old, new)
    with pytest.raises(InputError) as error:
        import_robot(load_whole_body(roller))
    assert said in str(error.value)
    assert "\n" not in str(error.value)
