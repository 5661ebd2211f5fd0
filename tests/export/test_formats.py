"""Exports are read back by readers that share no code with their writers, and say what the motion says."""

from __future__ import annotations

import json
import sqlite3
import xml.etree.ElementTree as ET
from collections import defaultdict
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rollgait.cli.app import run
from rollgait.errors import FileError, InputError
from rollgait.export import FORMATS, write
from rollgait.plan.plan import Plan
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario import find_scenario
from rollgait.terrain import Terrain
from tests.hostile.motions import joints
from tests.plan.builders import spoilt
from tests.terrain.surface import away_from_edges, seen_from_above
from tests.view.builders import motion_plan, plan_on

RATE = 20.0
PLAN = motion_plan(find_scenario("hybrid-forward"))
STAIRS = Terrain.from_parts([{"kind": "stairs", "x": 0.8, "steps": 3, "rise": 0.12, "tread": 0.4}])
ON_STAIRS = plan_on(STAIRS, PLAN)
START = 1.0
"""Stamp of the first message, s."""


def read_mcap(path: Path) -> dict[str, list[Any]]:
    """All messages by topic, read by a reader of its own."""
    reader = pytest.importorskip("mcap_ros2.reader", reason="mcap-ros2-support is not installed")
    result: dict[str, list[Any]] = defaultdict(list)
    for message in reader.read_ros2_messages(str(path)):
        result[message.channel.topic].append(message.ros_msg)
    return result


@pytest.fixture(scope="module")
def topics(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Any]]:
    pytest.importorskip("rosbags", reason="the extra 'mcap' is not installed")
    return read_mcap(write(PLAN, tmp_path_factory.mktemp("mcap") / "plan.mcap", "mcap", RATE))


def stamp(message: Any) -> float:
    return float(message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec)


def xyz(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


def test_mcap_holds_the_contact_forces(topics: dict[str, list[Any]]) -> None:
    s = PLAN.sample_every(RATE)
    for leg, name in enumerate(LEG_NAMES):
        wrenches = topics[f"/contact/{name.lower()}"]
        np.testing.assert_allclose([stamp(w) for w in wrenches], START + s.time, atol=1e-9)
        np.testing.assert_allclose([xyz(w.wrench.force) for w in wrenches], s.force[:, leg])
        assert {w.header.frame_id for w in wrenches} == {f"{name.lower()}_contact"}


def test_mcap_holds_paths_joints_and_markers(topics: dict[str, list[Any]]) -> None:
    s = PLAN.sample_every(RATE)
    (path,) = topics["/plan/com"]
    np.testing.assert_allclose([xyz(pose.pose.position) for pose in path.poses], s.com_position)
    states = topics["/joint_states"]
    names = states[0].name
    angle = np.array([state.position for state in states])
    rate = np.array([state.velocity for state in states])
    wheel, steering = names.index("fr_wheel_joint"), names.index("fr_steering_joint")
    np.testing.assert_allclose(angle[:, steering], s.heading[:, 1] - s.euler[:, 0])
    np.testing.assert_allclose(rate[:, wheel], s.speed[:, 1] / (PLAN.robot.leg_list[1].wheel_radius or 1.0))
    (trajectory,) = topics["/wheel_trajectory_controller/joint_trajectory"]
    columns = [names.index(name) for name in trajectory.joint_names]
    np.testing.assert_allclose([point.positions for point in trajectory.points], angle[:, columns])
    markers = topics["/markers"]
    assert len(markers) == len(s.time)
    kinds = {(marker.ns, marker.id) for marker in markers[0].markers}
    assert {("body", 0), ("feet", 3), ("forces", 0)} <= kinds


def test_rosbag2_holds_the_same_messages(tmp_path: Path, topics: dict[str, list[Any]]) -> None:
    decoder = pytest.importorskip("mcap_ros2._dynamic", reason="mcap-ros2-support is not installed")
    from rollgait.ros.cdr import definition
    from rollgait.ros.topics import WRENCHES

    bag = write(PLAN, tmp_path / "bag", "rosbag2", RATE)
    assert "storage_identifier: sqlite3" in (bag / "metadata.yaml").read_text()
    with sqlite3.connect(bag / "bag.db3") as database:
        rows = database.execute(
            "SELECT messages.data FROM messages JOIN topics ON messages.topic_id = topics.id "
            "WHERE topics.name = '/contact/fl' ORDER BY messages.timestamp"
        ).fetchall()
    database.close()
    types = decoder.generate_dynamic(WRENCHES[0].type, definition(WRENCHES[0].type))
    read = [types[WRENCHES[0].type](data) for (data,) in rows]
    assert [xyz(w.wrench.force) for w in read] == [xyz(w.wrench.force) for w in topics["/contact/fl"]]
    with pytest.raises(FileError, match="new folder"):
        write(PLAN, bag, "rosbag2", RATE)


def ground_of(marker: Any) -> np.ndarray:
    """Corners of the triangles of a marker, (n, 3, 3)."""
    assert marker.type == 11  # TRIANGLE_LIST
    assert len(marker.colors) == len(marker.points)
    assert {color.a for color in marker.colors} == {1.0}
    assert (marker.header.frame_id, xyz(marker.pose.position), marker.pose.orientation.w) == (
        "odom",
        [0] * 3,
        1,
    )
    return np.array([xyz(point) for point in marker.points]).reshape(-1, 3, 3)


def test_mcap_and_rosbag2_hold_the_ground_for_who_comes_later(tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="the extra 'mcap' is not installed")
    mcap = pytest.importorskip("mcap.reader", reason="the extra 'mcap' is not installed")
    file = write(ON_STAIRS, tmp_path / "plan.mcap", "mcap", RATE)
    (marker,) = read_mcap(file)["/ground"]
    points = away_from_edges(STAIRS, np.random.default_rng(0).uniform([-1.0, -1.0], [2.0, 1.0], (300, 2)))
    np.testing.assert_allclose(
        seen_from_above(ground_of(marker), points), STAIRS.height(*points.T), atol=1e-6
    )
    with file.open("rb") as stream:
        channels = mcap.make_reader(stream).get_summary().channels.values()
    offered = {channel.topic: channel.metadata.get("offered_qos_profiles", "") for channel in channels}
    assert "durability: 1" in offered["/ground"]
    bag = write(ON_STAIRS, tmp_path / "bag", "rosbag2", RATE)
    with sqlite3.connect(bag / "bag.db3") as database:
        rows = dict(database.execute("SELECT name, offered_qos_profiles FROM topics").fetchall())
        (data,) = database.execute(
            "SELECT messages.data FROM messages JOIN topics ON messages.topic_id = topics.id "
            "WHERE topics.name = '/ground'"
        ).fetchone()
    database.close()
    assert "durability: 1" in rows["/ground"]
    decoder = pytest.importorskip("mcap_ros2._dynamic", reason="mcap-ros2-support is not installed")
    from rollgait.ros.cdr import definition
    from rollgait.ros.topics import GROUND

    again = decoder.generate_dynamic(GROUND.type, definition(GROUND.type))[GROUND.type](data)
    np.testing.assert_array_equal(ground_of(again), ground_of(marker))


def test_json_holds_the_columns_and_the_scenario(tmp_path: Path) -> None:
    document = json.loads(write(PLAN, tmp_path / "plan.json", "json", RATE).read_text())
    s = PLAN.sample_every(RATE)
    assert document["samples"]["com_x"] == s.com_position[:, 0].tolist()
    assert document["samples"]["HR_fz"] == s.force[:, 3, 2].tolist()
    assert document["scenario"]["goal"]["x"] == PLAN.scenario.goal.x
    assert document["certificate"]["passed"] == PLAN.certificate().passed


def test_mujoco_reads_every_joint_by_its_name(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco", reason="the extra 'whole-body' is not installed")
    pytest.importorskip("pinocchio", reason="the extra 'whole-body' is not installed")
    from rollgait.robot.whole_body import find_whole_body
    from rollgait.simulation.world import build_world
    from rollgait.tracking import track

    scenario = find_scenario("wheeled").with_values({"horizon": 1.0, "goal": {"x": 0.1}})
    tracked = track(motion_plan(scenario), 20.0, force=True)
    file = write(tracked, tmp_path / "keys.xml", "mujoco", 20.0)
    model = build_world(find_whole_body(tracked.robot), tracked.joint_names).model
    keys = ET.parse(file).getroot().findall("keyframe/key")
    assert len(keys) == len(tracked.time)
    for index, key in enumerate(keys):
        qpos, qvel = (np.array(key.get(name, "").split(), dtype=float) for name in ("qpos", "qvel"))
        assert float(key.get("time", "")) == pytest.approx(tracked.time[index])
        assert (len(qpos), len(qvel)) == (model.nq, model.nv)
        np.testing.assert_allclose(qpos[:3], tracked.base_position[index], rtol=1e-7)
        for column, name in enumerate(tracked.joint_names):
            number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)
            place, rate = model.jnt_qposadr[number], model.jnt_dofadr[number]
            assert qpos[place] == pytest.approx(tracked.joint_position[index, column], abs=1e-7)
            assert qvel[rate] == pytest.approx(tracked.joint_velocity[index, column], abs=1e-7)


@pytest.mark.parametrize("kind", ["stairs", "map"])
def test_mujoco_stands_on_the_ground(kind: str, tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco", reason="the extra 'whole-body' is not installed")
    rng = np.random.default_rng(1)
    hills = Terrain.from_map(0.05 * rng.random((50, 30)), 0.1, (-2.0, -1.5))
    terrain = STAIRS if kind == "stairs" else hills
    moved = joints()
    file = write(replace(moved, terrain=terrain), tmp_path / "keys.xml", "mujoco", 10.0)
    body = '<body><freejoint/><geom size="0.1"/></body>'  # which has none of the joints by hand
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><include file="keys.xml"/><worldbody>{body}</worldbody></mujoco>',
        {"keys.xml": file.read_bytes()},
    )
    np.testing.assert_allclose(model.key_qpos[-1, :3], moved.base_position[-1], atol=1e-6)
    data = mujoco.MjData(model)
    data.qpos[:3] = [0.0, 0.0, 50.0]
    mujoco.mj_forward(model, data)
    nodes = None if terrain.map is None else terrain.map.nodes()[1:-1, 1:-1].reshape(-1, 2)
    points = rng.uniform([-1.0, -1.0], [2.0, 1.0], (100, 2)) if nodes is None else nodes[::7]
    for x, y in points:
        hit = np.zeros(1, dtype=np.int32)
        way = mujoco.mj_ray(model, data, [x, y, 5.0], [0.0, 0.0, -1.0], None, 1, -1, hit)
        assert 5.0 - way == pytest.approx(float(terrain.height(x, y)), abs=2e-5)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e200])
@pytest.mark.parametrize(
    "command", [*(f"export --format {name}" for name in FORMATS), "plot", "record", "track"]
)
def test_what_no_number_is_in_a_plan_is_said_in_one_sentence(
    command: str, value: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The last iterate of a solver that failed is saved, and judged; nobody can draw it."""
    path, out = tmp_path / "plan.npz", tmp_path / ("out.html" if command == "record" else "out")
    spoilt(PLAN, "force", (3, 1, 0), value).save(path)
    name, *options = command.split()
    assert run([name, str(path), *options, "--out", str(out)]) == 2
    assert f"trajectory.force: {value:.6g} must lie between" in " ".join(capsys.readouterr().err.split())
    assert not out.exists()


def test_plans_have_no_keyframes_and_joints_no_columns(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="track the plan"):
        write(PLAN, tmp_path / "a.xml", "mujoco")
    with pytest.raises(InputError, match="plans only"):
        write(object(), tmp_path / "a.csv", "csv")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", sorted(set(FORMATS) - {"mujoco"}))
def test_the_command_writes_every_format(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("rosbags", reason="the extra 'mcap' is not installed")
    plan = PLAN.save(tmp_path / "plan.npz")
    target = tmp_path / f"out.{name}"
    assert run(["export", str(plan), "--format", name, "--rate", "5", "--out", str(target)]) == 0
    assert target.exists()
    assert capsys.readouterr().out.strip() == str(target)
    assert isinstance(Plan.load(plan), Plan)
