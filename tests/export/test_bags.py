"""Who has nothing but a bag finds every link where it was put, and what shows the bag names what is in it."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ruamel.yaml import YAML

from rollgait.cli.app import run
from rollgait.errors import InputError
from rollgait.export import write
from rollgait.export.ros2 import REST
from rollgait.mpc.log import MpcLog
from rollgait.plan.plan import Plan
from rollgait.robot.library import find_robot
from rollgait.robot.robot import LEG_NAMES, Robot
from rollgait.scenario import find_scenario
from rollgait.simulation import SimulationLog
from rollgait.tracking import JointTrajectory
from tests.export.independent import Bag, frames_in_world, links_in_world, read_mcap, read_rosbag2, seconds
from tests.hostile.motions import controller, joints, simulation
from tests.view.builders import motion_plan, plan_on

pytest.importorskip("rosbags", reason="the extra 'mcap' is not installed")

RATE = 5.0
TOLERANCE = 1e-3
"""How far a link may be from where it was put, m."""
FIXTURES = Path(__file__).parents[1] / "fixtures"
FORMATS: dict[str, Callable[[Path], Bag]] = {"mcap": read_mcap, "rosbag2": read_rosbag2}


def distance(a: np.ndarray, b: np.ndarray) -> float:
    """Largest distance between the corners of a cube of 1 m with its centre in each of two frames, m."""
    corners = np.array([[x, y, z, 2.0] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2.0
    return float(np.linalg.norm((corners @ (a - b).T)[:, :3], axis=1).max())


def urdf_of(name: str) -> Path:
    from rollgait.robot.whole_body import DATA_PREFIX, _place

    place = {
        "hyq": f"{DATA_PREFIX}hyq_description/robots/hyq_no_sensors.urdf",
        "solo12": f"{DATA_PREFIX}solo_description/robots/solo12.urdf",
        "odd": "odd.urdf",
    }[name]
    return _place("urdf", place, FIXTURES)


def described(name: str, folder: Path) -> Robot:
    """A robot with the whole body of this name; the planner's figures of another do no harm here."""
    if name in ("centauro", "rover", "strider"):
        return find_robot(name)
    from rollgait.config import dump_yaml
    from rollgait.robot.urdf_discovery import discover

    body = discover(urdf_of(name))
    (folder / "body.yaml").write_text(dump_yaml(body.model_dump(mode="json", exclude_none=True)))
    return find_robot("strider").model_copy(update={"name": name, "whole_body": str(folder / "body.yaml")})


Body = JointTrajectory | SimulationLog | MpcLog
"""What has all joints."""


def at_random(robot: Robot) -> JointTrajectory:
    """Any motion of the whole body: what it does is nobody's business here."""
    from rollgait.robot.urdf_model import load_model
    from rollgait.robot.whole_body import find_whole_body

    rng, some = np.random.default_rng(7), joints()
    names, count = load_model(find_whole_body(robot)).joint_names, len(some.time)
    quaternion = rng.normal(size=(count, 4))
    return replace(
        some,
        robot=robot,
        joint_names=names,
        joint_position=rng.uniform(-3.0, 3.0, (count, len(names))),
        joint_velocity=rng.normal(size=(count, len(names))),
        joint_torque=rng.normal(size=(count, len(names))),
        base_position=rng.normal(size=(count, 3)),
        base_quaternion=quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True),
    )


def where_it_was_put(moved: Body) -> list[dict[str, np.ndarray]]:
    """Poses (4, 4) of all links by the model that tracking has."""
    import pinocchio as pin

    from rollgait.robot.urdf_model import load_model
    from rollgait.robot.whole_body import find_whole_body

    model = load_model(find_whole_body(moved.robot)).pin
    data, result = model.createData(), []
    for k in range(len(moved.time)):
        q = np.concatenate([moved.base_position[k], moved.base_quaternion[k], moved.joint_position[k]])
        pin.framesForwardKinematics(model, data, q)
        result.append(
            {
                frame.name: np.array(data.oMf[number].homogeneous)
                for number, frame in enumerate(model.frames)
                if str(frame.type) == "BODY"
            }
        )
    return result


def worst(moved: Body, bag: Bag) -> float:
    """The farthest that any link is from where it was put, by the description as by /tf, m."""
    put, far = where_it_was_put(moved), 0.0
    assert len(bag.messages["/joint_states"]) == len(bag.messages["/tf"]) == len(put)
    for there, links, frames in zip(put, links_in_world(bag), frames_in_world(bag), strict=True):
        assert set(there) <= set(links) & set(frames)
        far = max(
            far, *(distance(pose, seen[name]) for name, pose in there.items() for seen in (links, frames))
        )
    return far


@pytest.mark.parametrize("name", ["centauro", "rover", "strider", "hyq", "solo12", "odd"])
@pytest.mark.parametrize("format", FORMATS)
def test_a_stranger_finds_every_link_where_it_was_put(name: str, format: str, tmp_path: Path) -> None:
    pytest.importorskip("pinocchio", reason="the extra 'whole-body' is not installed")
    moved = at_random(described(name, tmp_path))
    bag = FORMATS[format](write(moved, tmp_path / f"out.{format}", format, 1000.0, meshes="package"))
    assert worst(moved, bag) <= TOLERANCE


def test_a_stranger_finds_every_link_where_tracking_put_it(tmp_path: Path) -> None:
    pytest.importorskip("pinocchio", reason="the extra 'whole-body' is not installed")
    from rollgait.tracking import track

    scenario = find_scenario("wheeled").with_values({"horizon": 1.0, "goal": {"x": 0.1}})
    moved = track(motion_plan(scenario), 20.0, force=True)
    bag = read_mcap(write(moved, tmp_path / "joints.mcap", "mcap", 20.0, meshes="package"))
    assert worst(moved, bag) <= TOLERANCE
    feet = moved.reference.foot_position
    radius = moved.robot.leg_list[0].wheel_radius or 0.0
    for k, frames in enumerate(frames_in_world(bag)):
        for leg in range(4):
            centre = frames[f"wheel_{leg + 1}"][:3, 3]
            assert np.linalg.norm(centre - feet[k, leg] - [0, 0, radius]) <= 0.02  # as well as it was tracked


@pytest.mark.parametrize("feet", ["steerable", "fixed", "point"])
@pytest.mark.parametrize("format", FORMATS)
def test_a_plan_is_of_a_robot_too(feet: str, format: str, tmp_path: Path) -> None:
    """By the description as by /tf: the base at the CoM, wheels over the footholds, axles as they head."""
    pytest.importorskip("pinocchio", reason="the extra 'whole-body' is not installed")
    scenario = find_scenario("hybrid-goback")
    plan = motion_plan(scenario, scenario.body.with_feet(feet))  # type: ignore[arg-type]
    bag = FORMATS[format](write(plan, tmp_path / f"out.{format}", format, RATE))
    s = plan.sample_every(RATE)
    for k, (links, frames) in enumerate(zip(links_in_world(bag), frames_in_world(bag), strict=True)):
        assert max(distance(pose, frames[name]) for name, pose in links.items()) <= 1e-9
        np.testing.assert_allclose(links["base_link"][:3, 3], s.com_position[k], atol=1e-12)
        for leg, name in enumerate(LEG_NAMES):
            data = plan.robot.leg_list[leg]
            end = links[f"{name.lower()}_wheel"]
            over = s.foot_position[k, leg] + [0.0, 0.0, data.foot_radius]
            np.testing.assert_allclose(end[:3, 3], over, atol=1e-9)
            heading = s.heading[k, leg] if feet != "point" else s.euler[k, 0]
            np.testing.assert_allclose(end[:3, 1], [-np.sin(heading), np.cos(heading), 0.0], atol=1e-6)


PARTS = ("joint_names", "joint_position", "base_position", "base_quaternion", "robot")


@pytest.mark.parametrize("name", ["centauro", "strider"])
def test_a_stranger_finds_the_links_of_a_simulation(name: str, tmp_path: Path) -> None:
    pytest.importorskip("pinocchio", reason="the extra 'whole-body' is not installed")
    moved, log = at_random(described(name, tmp_path)), simulation()
    parts = {part: getattr(moved, part) for part in PARTS}
    rates = dict.fromkeys(("joint_velocity", "joint_torque", "torque_peak"), moved.joint_velocity)
    log = replace(log, **parts, **rates, effort_max=np.full(len(moved.joint_names), np.inf))
    file = write(log, tmp_path / "run.mcap", "mcap", 1000.0, meshes="package")
    bag = read_mcap(file)
    assert worst(log, bag) <= TOLERANCE
    np.testing.assert_array_equal(bag.messages["/joint_states"][3].effort, log.joint_torque[3])
    source = log.save(tmp_path / "run.npz")
    command = ["export", str(source), "--format", "mcap", "--rate", "1000", "--meshes", "package"]
    assert run([*command, "--out", str(tmp_path / "again.mcap")]) == 0


@pytest.mark.parametrize("name", ["centauro", "strider"])
def test_a_stranger_finds_the_links_of_a_run_of_the_controller(name: str, tmp_path: Path) -> None:
    pytest.importorskip("pinocchio", reason="the extra 'whole-body' is not installed")
    moved, log = at_random(described(name, tmp_path)), controller()
    rows = np.arange(len(log.time)) % len(moved.time)
    log = replace(
        log,
        robot=moved.robot,
        joint_names=moved.joint_names,
        joint_position=moved.joint_position[rows],
        base_position=moved.base_position[rows],
        base_quaternion=moved.base_quaternion[rows],
    )
    bag = read_mcap(write(log, tmp_path / "run.mcap", "mcap", 1000.0, meshes="package"))
    assert worst(log, bag) <= TOLERANCE
    document = json.loads(write(log, tmp_path / "run.json", "json", 10.0).read_text())
    assert document["joints"]["names"] == list(log.joint_names)
    assert np.shape(document["joints"]["acceleration"]) == np.shape(document["joints"]["position"])


def test_a_run_without_legs_is_exported_as_a_plan_is(tmp_path: Path) -> None:
    log = controller()
    bag = read_mcap(write(log, tmp_path / "run.mcap", "mcap", 20.0))
    for k, links in enumerate(links_in_world(bag)):
        row = min(5 * k, len(log.time) - 1)
        np.testing.assert_allclose(links["base_link"][:3, 3], log.com_position[row], atol=1e-9)
    wheels = bag.messages["/wheel_trajectory_controller/joint_trajectory"][0]
    assert len(wheels.points) == len(bag.messages["/tf"])


@pytest.fixture(scope="module")
def plan() -> Plan:
    return motion_plan(find_scenario("hybrid-forward"))


@pytest.fixture(scope="module")
def bags(plan: Plan, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Bag]:
    folder = tmp_path_factory.mktemp("bags")
    return {name: read(write(plan, folder / f"p.{name}", name, RATE)) for name, read in FORMATS.items()}


TYPES = {
    "/robot_description": "std_msgs/msg/String",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/odom": "nav_msgs/msg/Odometry",
    "/joint_trajectory_controller/joint_trajectory": "trajectory_msgs/msg/JointTrajectory",
    "/wheel_trajectory_controller/joint_trajectory": "trajectory_msgs/msg/JointTrajectory",
    "/plan/com": "nav_msgs/msg/Path",
    "/plan/footholds": "visualization_msgs/msg/MarkerArray",
    "/markers": "visualization_msgs/msg/MarkerArray",
    "/ground": "visualization_msgs/msg/Marker",
}
LATCHED = {"/robot_description", "/tf_static", "/ground", "/plan/com", "/plan/footholds"}


@pytest.mark.parametrize("format", FORMATS)
def test_types_and_qualities_are_those_that_listeners_ask_for(format: str, bags: dict[str, Bag]) -> None:
    bag = bags[format]
    assert {topic: bag.types[topic] for topic in TYPES} == TYPES
    assert set(bag.messages) == set(bag.types)
    for topic, text in bag.qualities.items():
        if format == "mcap":
            (quality,) = YAML(typ="safe").load(text)
            durable, reliable = quality["durability"] == 1, quality["reliability"] == 1
        else:
            durable, reliable = "TRANSIENT_LOCAL" in text, "RELIABLE" in text and "BEST" not in text
        latched = topic in LATCHED or topic.startswith("/plan/")
        assert (durable, reliable) == (latched, True), topic


def test_frames_follow_the_conventions(plan: Plan, bags: dict[str, Bag]) -> None:
    s = plan.sample_every(RATE)
    for k, frames in enumerate(frames_in_world(bags["mcap"])):
        np.testing.assert_array_equal(frames["odom"], np.eye(4))
        foot = frames["base_footprint"]
        np.testing.assert_allclose(foot[2, :3], [0.0, 0.0, 1.0], atol=1e-9)  # upright
        np.testing.assert_allclose(foot[:2, 3], s.foot_position[k, :, :2].mean(axis=0), atol=1e-9)
        assert foot[2, 3] == pytest.approx(s.foot_position[k, :, 2].min())
        assert np.arctan2(foot[1, 0], foot[0, 0]) == pytest.approx(s.euler[k, 0], abs=1e-9)
        for leg, name in enumerate(LEG_NAMES):
            touched = frames[f"{name.lower()}_contact"]
            np.testing.assert_allclose(touched[:3, 3], s.contact_position[k, leg], atol=1e-9)


def test_controllers_get_their_own_joints(bags: dict[str, Bag]) -> None:
    messages = bags["rosbag2"].messages
    (legs,) = messages["/joint_trajectory_controller/joint_trajectory"]
    (wheels,) = messages["/wheel_trajectory_controller/joint_trajectory"]
    assert {name.split("_", 1)[1] for name in legs.joint_names} == {"steering_joint"}
    assert {name.split("_", 1)[1] for name in wheels.joint_names} == {"wheel_joint"}
    for trajectory in (legs, wheels):
        times = np.array([seconds(point.time_from_start) for point in trajectory.points])
        assert seconds(trajectory.header.stamp) == 0.0
        assert times[0] == 0.0
        assert np.all(np.diff(times) > 0.0)
        velocity = np.array([point.velocities for point in trajectory.points])
        acceleration = np.array([point.accelerations for point in trajectory.points])
        np.testing.assert_allclose(acceleration[1:-2], np.gradient(velocity, times, axis=0)[1:-2], atol=1e-9)
        assert not any(len(point.effort) for point in trajectory.points)


@pytest.mark.parametrize("fastest", [0.005, 0.05])
def test_joints_that_hardly_move_at_the_end_stand(fastest: float, tmp_path: Path) -> None:
    pytest.importorskip("pinocchio", reason="the extra 'whole-body' is not installed")
    moved = at_random(find_robot("strider"))
    moved.joint_velocity[-1] = fastest * np.linspace(-1.0, 1.0, len(moved.joint_names))
    bag = read_mcap(write(moved, tmp_path / "a.mcap", "mcap", 1000.0))
    (legs,) = bag.messages["/joint_trajectory_controller/joint_trajectory"]
    said = moved.joint_velocity[-1] if fastest > REST else np.zeros(len(moved.joint_names))
    np.testing.assert_array_equal(legs.points[-1].velocities, said)
    np.testing.assert_array_equal(legs.points[-2].velocities, moved.joint_velocity[-2])


def test_controllers_are_named_as_asked(plan: Plan, tmp_path: Path) -> None:
    asked = {"front": ["f*_joint"], "left_hind/wheel": ["hl_wheel_joint"]}
    bag = read_mcap(write(plan, tmp_path / "a.mcap", "mcap", RATE, controllers=asked))
    (front,) = bag.messages["/front/joint_trajectory"]
    (wheel,) = bag.messages["/left_hind/wheel/joint_trajectory"]
    assert (len(front.joint_names), wheel.joint_names) == (4, ["hl_wheel_joint"])
    for wrong, words in (
        ({"a": ["knee"]}, "must be a joint"),
        ({"a": ["f*"], "b": ["fl_wheel_joint"]}, "which a has"),
        ({"1 2": ["*"]}, "name for ROS"),
    ):
        with pytest.raises(InputError, match=words):
            write(plan, tmp_path / "b.mcap", "mcap", RATE, controllers=wrong)
    with pytest.raises(InputError, match="is for bags"):
        write(plan, tmp_path / "b.csv", "csv", RATE, controllers=asked)
    with pytest.raises(InputError, match="must be one of"):
        write(plan, tmp_path / "b.mcap", "mcap", RATE, meshes="inside")
    assert not list(tmp_path.glob("b*"))


def test_what_a_robot_carries_is_in_its_description(tmp_path: Path) -> None:
    pin = pytest.importorskip("pinocchio", reason="the extra 'whole-body' is not installed")
    robot = find_robot("strider").with_payload(3.0, (0.05, 0.0, 0.1)).with_payload(1.0)
    moved = at_random(robot)
    bag = read_mcap(write(moved, tmp_path / "a.mcap", "mcap", 1000.0))
    assert worst(moved, bag) <= TOLERANCE
    model = pin.buildModelFromXML(bag.messages["/robot_description"][0].data, pin.JointModelFreeFlyer())
    assert pin.computeTotalMass(model) == pytest.approx(robot.mass, rel=1e-6)


# -- meshes --


def mesh_names(bag: Bag) -> set[str]:
    import xml.etree.ElementTree as ET

    root = ET.fromstring(bag.messages["/robot_description"][0].data)
    return {mesh.get("filename", "") for mesh in root.iter("mesh")}


@pytest.mark.parametrize("name", ["centauro", "odd"])
def test_meshes_resolve_as_ros_finds_packages(name: str, tmp_path: Path) -> None:
    pytest.importorskip("pinocchio", reason="the extra 'whole-body' is not installed")
    moved = at_random(described(name, tmp_path))
    file = write(moved, tmp_path / "out.mcap", "mcap", RATE)
    names = mesh_names(read_mcap(file))
    assert names
    assert str(Path.home()).encode() not in file.read_bytes()
    assert all(name.startswith("package://") and ".." not in name for name in names)
    prefix = tmp_path / "out_meshes"
    found = 0
    for name_ in names:
        package, _, rest = name_.removeprefix("package://").partition("/")
        if (prefix / "share" / package / rest).is_file():
            found += 1
            assert (prefix / "share/ament_index/resource_index/packages" / package).is_file()
            assert f"<name>{package}</name>" in (prefix / "share" / package / "package.xml").read_text()
    assert found == (len(names) if name == "centauro" else 2)
    endings = {path.suffix.lower() for path in prefix.rglob("*") if path.is_file()}
    assert endings <= {".stl", ".dae", ".xml", ""}


def test_nothing_of_this_machine_is_in_a_bag_unless_asked_for(tmp_path: Path) -> None:
    pytest.importorskip("pinocchio", reason="the extra 'whole-body' is not installed")
    moved = at_random(described("odd", tmp_path))
    for meshes in ("beside", "package", "file"):
        file = write(moved, tmp_path / f"{meshes}.mcap", "mcap", RATE, meshes=meshes)
        (said,) = read_mcap(file).messages["/robot_description"]
        beside = [path.read_text() for path in tmp_path.glob(f"{meshes}.[fr]*")]
        assert len(beside) == 2
        hidden = ["/secret/", str(FIXTURES), str(tmp_path)]
        told = [word for word in hidden for text in (said.data, *beside) if word in text]
        assert told == ([str(FIXTURES)] if meshes == "file" else [])


# -- what shows a bag --


def panels(node: Any) -> list[str]:
    if isinstance(node, str):
        return [node]
    return [*panels(node["first"]), *panels(node["second"])]


def test_the_layout_names_what_is_in_the_bag(plan: Plan, tmp_path: Path) -> None:
    bag = read_mcap(write(plan, tmp_path / "plan.mcap", "mcap", RATE))
    layout = json.loads((tmp_path / "plan.foxglove.json").read_text())
    assert sorted(panels(layout["layout"])) == sorted(layout["configById"])
    frames = set(next(frames_in_world(bag)))
    scene = layout["configById"]["3D!rollgait"]
    assert set(scene["topics"]) <= set(bag.types)
    assert {"/robot_description", "/ground", "/plan/com"} <= set(scene["topics"])
    assert {scene["followTf"], scene["layers"]["grid"]["frameId"]} <= frames
    assert {name.removeprefix("frame:") for name in scene["transforms"]} <= frames
    for name, panel in layout["configById"].items():
        for series in panel.get("paths", []):
            topic, _, path = series["value"].partition(".")
            value = bag.messages[topic][0]
            for part in path.split("."):
                field, _, index = part.partition("[")
                value = getattr(value, field)
                value = value[int(index.rstrip("]"))] if index else value
            assert isinstance(float(value), float), name


def test_the_layout_has_the_settings_that_the_app_knows(plan: Plan, tmp_path: Path) -> None:
    """Against the types that Foxglove's own SDK has for them."""
    known = pytest.importorskip("foxglove.layouts", reason="foxglove-sdk is not installed")

    def check(settings: dict[str, Any], kind: type) -> None:
        assert set(settings) <= set(kind().to_json and kind()._to_dict()), kind.__name__

    write(plan, tmp_path / "plan.mcap", "mcap", RATE)
    configs = json.loads((tmp_path / "plan.foxglove.json").read_text())["configById"]
    scene = configs.pop("3D!rollgait")
    check(scene, known.ThreeDeeConfig)
    check(scene["cameraState"], known.ThreeDeeCameraState)
    check(scene["scene"], known.BaseRendererSceneSettings)
    check(scene["layers"]["grid"], known.BaseRendererGridLayerSettings)
    for topic, settings in scene["topics"].items():
        is_robot, is_path = topic == "/robot_description", topic.startswith("/plan/") and "holds" not in topic
        kind = known.BaseRendererPosesTopicSettings if is_path else known.BaseRendererRosMarkerTopicSettings
        check(settings, known.BaseRendererUrdfTopicSettings if is_robot else kind)
    for plot in configs.values():
        title = plot.pop("title")
        check(plot, known.PlotConfig)
        assert isinstance(title, str)
        for series in plot["paths"]:
            assert set(series) <= set(known.PlotSeries(value="")._to_dict())


def test_rviz_shows_what_is_in_the_bag(plan: Plan, tmp_path: Path) -> None:
    bag = read_rosbag2(write(plan, tmp_path / "plan_bag", "rosbag2", RATE))
    config = YAML(typ="safe").load((tmp_path / "plan_bag.rviz").read_text())["Visualization Manager"]
    frames = set(next(frames_in_world(bag)))
    assert config["Global Options"]["Fixed Frame"] in frames
    assert config["Views"]["Current"]["Target Frame"] in frames
    kinds = {
        "RobotModel": "std_msgs/msg/String",
        "Marker": "visualization_msgs/msg/Marker",
        "MarkerArray": "visualization_msgs/msg/MarkerArray",
        "Path": "nav_msgs/msg/Path",
    }
    seen = set()
    for display in config["Displays"]:
        topic = display.get("Topic") or display.get("Description Topic")
        if topic is None:
            continue
        name = topic["Value"]
        seen.add(name)
        assert bag.types[name] == kinds[display["Class"].split("/")[1]]
        assert (topic["Durability Policy"] == "Transient Local") == ("TRANSIENT_LOCAL" in bag.qualities[name])
    assert {"/robot_description", "/ground", "/markers", "/plan/com"} <= seen


def test_others_open_the_bags(plan: Plan, tmp_path: Path) -> None:
    """And find the same in both."""
    file = write(plan, tmp_path / "plan.mcap", "mcap", RATE)
    folder = write(plan, tmp_path / "plan_bag", "rosbag2", RATE)
    from rosbags.highlevel import AnyReader

    with AnyReader([folder]) as bag, AnyReader([file]) as other:
        assert bag.message_count == other.message_count
        assert {c.topic for c in bag.connections} == {c.topic for c in other.connections}


def test_the_command_takes_meshes_and_controllers(tmp_path: Path, plan: Plan) -> None:
    source, target = plan.save(tmp_path / "plan.npz"), tmp_path / "out.mcap"
    command = ["export", str(source), "--format", "mcap", "--rate", "5", "--out", str(target)]
    assert run([*command, "--meshes", "package", "--controller", "all=*_joint"]) == 0
    assert "/all/joint_trajectory" in read_mcap(target).types
    assert run([*command, "--meshes", "inside"]) == 2
    assert run([*command, "--controller", "all"]) == 2
    assert run([*command[:3], "csv", "--meshes", "package"]) == 2


def test_the_ground_is_that_of_the_plan(plan: Plan, tmp_path: Path) -> None:
    from rollgait.terrain import Terrain

    stairs = Terrain.from_parts([{"kind": "stairs", "x": 0.8, "steps": 3, "rise": 0.12, "tread": 0.4}])
    bag = read_mcap(write(plan_on(stairs, plan), tmp_path / "plan.mcap", "mcap", RATE))
    (ground,) = bag.messages["/ground"]
    assert max(point.z for point in ground.points) == pytest.approx(0.36)
