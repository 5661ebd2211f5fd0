"""Bare URDFs: legs, posture, wheels and centres are found, as pinocchio alone finds them, too."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pinocchio", reason="needs the extra whole-body")

import pinocchio as pin

import rollgait as rg
from rollgait.config import load_yaml
from rollgait.errors import InputError
from rollgait.robot.urdf import ImportedRobot
from rollgait.robot.urdf_hip_legs import hip_legs
from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.robot.urdf_stance import nominal_stance, reach
from rollgait.robot.whole_body import DATA_PREFIX, load_whole_body
from tests.robot.lookalikes import LOOKALIKES, SIDES, Lookalike

LEFT = np.array([left for _, left in SIDES.values()])


@pytest.fixture(scope="module", params=LOOKALIKES)
def look(request: pytest.FixtureRequest) -> Lookalike:
    return LOOKALIKES[request.param]


@pytest.fixture(scope="module")
def imported(look: Lookalike, tmp_path_factory: pytest.TempPathFactory) -> ImportedRobot:
    urdf = tmp_path_factory.mktemp("robot") / f"{look.name}.urdf"
    urdf.write_text(look.urdf())
    return rg.import_robot(urdf)


def test_what_is_taken_for_what(look: Lookalike, imported: ImportedRobot) -> None:
    robot = imported.robot
    assert {leg.foot for leg in robot.leg_list} == {look.foot}
    assert robot.mass == pytest.approx(look.mass, rel=1e-4)
    assert [leg.wheel_radius for leg in robot.leg_list] == pytest.approx([look.radius] * 4)
    assert robot.stance[:, 1] == pytest.approx(LEFT * look.half_track, abs=0.01 * look.scale)
    said = {finding.name: finding for finding in imported.findings}
    assert ("meshes" in said) == look.meshes
    assert {f"leg {name}" for name in SIDES} <= set(said)


def test_mass_and_places_by_pinocchio_alone(look: Lookalike, imported: ImportedRobot) -> None:
    """Contact points and CoM of the stance, and how far the feet reach, from the URDF as it was written."""
    model = pin.buildModelFromXML(look.urdf(), pin.JointModelFreeFlyer())
    data = model.createData()
    ours = WholeBodyModel(imported.body)
    stance = nominal_stance(ours)

    def contacts(ours_q: np.ndarray) -> np.ndarray:
        q = pin.neutral(model)
        for name, angle in zip(ours.joint_names, ours_q[7:], strict=True):
            joint = model.joints[model.getJointId(name)]
            if joint.nq == 1:
                assert model.lowerPositionLimit[joint.idx_q] <= angle <= model.upperPositionLimit[joint.idx_q]
                q[joint.idx_q] = angle
        pin.framesForwardKinematics(model, data, q)
        pin.centerOfMass(model, data, q)
        frames = [data.oMf[model.getFrameId(leg.frame)] for _, leg in imported.body.leg_list()]
        shank = look.foot == "point" and look.at_joint
        middles = [
            frame.act(np.array([0.0, 0.0, -0.3 * look.scale] if shank else [0.0, left * look.offset, 0.0]))
            for frame, (_, left) in zip(frames, SIDES.values(), strict=True)
        ]
        return np.array(middles) - [0.0, 0.0, look.radius]

    places = contacts(stance.q)
    assert places - data.com[0] == pytest.approx(imported.robot.stance, abs=2e-5)
    wheels_stay_upright = look.foot == "point" or not look.hip_roll
    for end in imported.robot.foot_boxes().swapaxes(0, 1):
        offset = end * [1.0, 0.0, 1.0]  # without swinging the legs sideways, which tilts fixed wheels
        targets = stance.state.p_foot + offset
        q = reach(ours, stance.q, lambda _, targets=targets: targets)[0].q
        assert contacts(q) - places == pytest.approx(offset, abs=1e-4 if wheels_stay_upright else 1e-3)


def test_the_posture_stands_bent_below_the_hips(look: Lookalike, imported: ImportedRobot) -> None:
    stance = imported.robot.stance
    assert np.ptp(stance[:, 2]) < 1e-6
    ahead = np.array([ahead for ahead, _ in SIDES.values()]) * 0.3 * look.scale
    assert stance[:, 0] - stance[:, 0].mean() == pytest.approx(ahead, abs=0.03 * look.scale)
    body = imported.body
    angles = [angle for name, angle in body.joints.items() if name.endswith("_j3")]
    assert len(angles) == 4
    assert min(np.abs(angles)) > 0.5


def test_the_box_is_reached_and_no_less(look: Lookalike, imported: ImportedRobot) -> None:
    model = WholeBodyModel(imported.body)
    stance, rng = nominal_stance(model), np.random.default_rng(0)
    box = np.array(imported.robot.box) * [1.0, look.hip_roll, 1.0]
    for _ in range(10):
        places = stance.state.p_foot + rng.uniform(-1, 1, (4, 3)) * box
        assert np.max(reach(model, stance.q, lambda _, places=places: places)[1]) < 1e-6
    low, high = imported.robot.foot_boxes().swapaxes(0, 1)
    assert ((high - low)[:, 0] > 0.2 * imported.robot.height).all()
    assert ((high - low)[:, 2] > 0.1 * imported.robot.height).all()


def test_each_leg_reaches_all_of_its_own_box(look: Lookalike, imported: ImportedRobot) -> None:
    model = WholeBodyModel(imported.body)
    stance, rng = nominal_stance(model), np.random.default_rng(0)
    low, high = imported.robot.foot_boxes().swapaxes(0, 1)
    assert (imported.robot.legs.FL.box is None) == (look.foot == "steerable")
    assert low[::2] == pytest.approx(np.stack([low[1::2, 0], -high[1::2, 1], low[1::2, 2]], axis=1))
    for _ in range(10):
        offset = rng.uniform(low, high) * [1.0, look.hip_roll, 1.0]
        places = stance.state.p_foot + offset
        assert np.max(reach(model, stance.q, lambda _, places=places: places)[1]) < 1e-6


def test_what_is_written_is_read_again(look: Lookalike, imported: ImportedRobot, tmp_path: Path) -> None:
    files = imported.save(tmp_path / "robot.yaml")
    assert rg.find_robot(str(files.robot)).stance == pytest.approx(imported.robot.stance)
    assert load_whole_body(files.legs).joints == imported.body.joints
    again = rg.import_robot(imported.body.urdf, legs=files.legs)
    assert again.robot.stance == pytest.approx(imported.robot.stance, abs=1e-4)
    assert again.robot.legs.FL.slip_max == imported.robot.legs.FL.slip_max
    scenario = rg.Scenario.from_yaml(files.first)
    assert scenario.body.mass == pytest.approx(look.mass, rel=1e-4)
    assert (scenario.gait.kind == "drive") == (not look.hip_roll)
    assert load_yaml(files.first)["goal"]["x"] > 0.1 * look.scale


def test_hips_and_knees_in_closed_form(look: Lookalike, imported: ImportedRobot) -> None:
    """Angles are those of inverse kinematics, and out of reach is what that does not reach."""
    model = WholeBodyModel(imported.body)
    stance, rng = nominal_stance(model), np.random.default_rng(0)
    legs = hip_legs(model, stance)
    assert (legs is None) == (look.foot == "steerable")
    if legs is None:
        return
    reached = np.zeros(2, dtype=int)
    for _ in range(8):
        offset = rng.uniform(-0.4, 0.4, (4, 3)) * [1.0, look.hip_roll, 1.0] * imported.robot.height
        places = stance.state.p_foot + offset
        state, errors = reach(model, stance.q, lambda _, places=places: places)
        for leg, chain, place, error in zip(legs, model.legs, places, errors, strict=True):
            angles = leg.joint_angles(place[None])[0]
            reached[int(leg.reaches(place[None])[0])] += 1
            if leg.reaches(place[None])[0] and error < 1e-6:
                assert angles == pytest.approx(state.q[np.array(chain.joints) + 1], abs=1e-6)
            if error < 1e-6:
                assert leg.reaches(place[None])[0]
    assert reached.min() > 3


def test_who_turns_in_no_other_way_is_given_wheels_that_skid(
    look: Lookalike, imported: ImportedRobot
) -> None:
    said = {finding.name: finding for finding in imported.findings}
    skids = look.foot == "fixed" and not look.hip_roll
    slips = [leg.slip_max or 0.0 for leg in imported.robot.leg_list]
    farthest = np.abs(imported.robot.stance[:, 0]).max()
    assert slips == pytest.approx([0.1 * farthest * skids] * 4, abs=1e-3)
    assert ("turns" in said) == ("lateral slip" in said) == skids


def test_wheels_skid_only_where_the_file_of_the_legs_says_so(tmp_path: Path) -> None:
    urdf = tmp_path / "robot.urdf"
    urdf.write_text(LOOKALIKES["fixed-planar"].urdf())
    legs = rg.import_robot(urdf).save(tmp_path / "mine.yaml").legs
    found = legs.read_text()
    assert "\nplanner: {slip_max: " in found
    legs.write_text(found[: found.index("planner:")])
    without = rg.import_robot(urdf, legs=legs)
    assert without.robot.legs.FL.slip_max is None
    (turns,) = [finding for finding in without.findings if finding.name == "turns"]
    assert (turns.value, turns.known) == ("not at all", False)
    legs.write_text(found.replace("slip_max: ", "slip_max: 1"))
    assert rg.import_robot(urdf, legs=legs).robot.legs.HR.slip_max > 1.0


def test_a_leg_that_swings_one_way_only_has_a_long_box(tmp_path: Path) -> None:
    """What stops the foot behind its place does not stop it ahead, nor the planner from using it."""
    look = LOOKALIKES["fixed-one-way"]
    urdf = tmp_path / "robot.urdf"
    urdf.write_text(look.urdf())
    robot = rg.import_robot(urdf).robot
    for low, high in robot.foot_boxes():
        assert high[0] > 2.0 * robot.box[0]
        assert high[0] > 2.0 * -low[0]


def test_a_robot_without_four_legs_is_one_sentence(tmp_path: Path) -> None:
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(
        '<robot name="arm"><link name="a"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>'
    )
    with pytest.raises(InputError, match="legs: must be named in a file") as error:
        rg.import_robot(urdf)
    assert "\n" not in str(error.value)


QUADRUPEDS = {
    "a1_description/urdf/a1.urdf": (13.741, 0.02),
    "go2_description/urdf/go2.urdf": (16.085, 0.0227),
    "hyq_description/robots/hyq_no_sensors.urdf": (86.774, 0.02175),
    "solo_description/robots/solo12.urdf": (2.5, 0.016),
    "anymal_c_simple_description/urdf/anymal.urdf": (52.135, 0.03),
    "b1_description/urdf/b1.urdf": (55.689, 0.04),
}


@pytest.mark.slow
@pytest.mark.parametrize("file", QUADRUPEDS)
def test_quadrupeds_of_example_robot_data(file: str) -> None:
    """Masses and radii as others publish them."""
    from rollgait.robot.whole_body import _place

    mass, radius = QUADRUPEDS[file]
    found = rg.import_robot(_place("urdf", DATA_PREFIX + file, Path()))
    assert found.robot.mass == pytest.approx(mass, abs=2e-3)
    for _, leg in found.body.leg_list():
        assert leg.radius == pytest.approx(radius, abs=2e-4)
    assert {leg.foot for leg in found.robot.leg_list} == {"point"}
    assert found.robot.static_forces() == pytest.approx([found.robot.weight / 4] * 4, rel=0.25)
