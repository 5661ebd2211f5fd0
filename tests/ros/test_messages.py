"""Messages of plain data, encoded by us, are read by a decoder that shares no code with us."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rollgait.robot.robot import Robot
from rollgait.ros import markers, messages
from rollgait.ros.messages import Pose
from tests.hostile.motions import plan

pytest.importorskip("rosbags", reason="the extra 'mcap' is not installed")
from rollgait.ros import cdr

FINITE = st.floats(-1e9, 1e9)
ROWS = st.integers(0, 4).flatmap(lambda n: st.lists(FINITE, min_size=n, max_size=n))
STAMPS = st.integers(0, 2**31 * 10**9 - 1)


def read(name: str, fields: messages.Fields) -> Any:
    """A message as others read it."""
    decoder = pytest.importorskip("mcap_ros2._dynamic", reason="mcap-ros2-support is not installed")
    return decoder.generate_dynamic(name, cdr.definition(name))[name](cdr.encode(name, fields))


def same(seen: Any, fields: Any) -> bool:
    """Whether a message that was read says what was written."""
    if isinstance(fields, dict):
        return all(same(getattr(seen, key), value) for key, value in fields.items())
    if isinstance(fields, list | np.ndarray):
        return len(seen) == len(fields) and all(same(a, b) for a, b in zip(seen, fields, strict=True))
    return bool(seen == fields)


@settings(max_examples=30)
@given(STAMPS, ROWS, st.text(max_size=5).filter(lambda text: "\0" not in text))
def test_joint_states_come_back(time: int, row: list[float], name: str) -> None:
    position = np.array(row)
    fields = messages.joint_state(time, [name] * len(row), position, 2.0 * position)
    assert same(read("sensor_msgs/msg/JointState", fields), fields)
    again = cdr.decode("sensor_msgs/msg/JointState", cdr.encode("sensor_msgs/msg/JointState", fields))
    assert again["header"] == fields["header"]
    assert again["name"] == fields["name"]
    np.testing.assert_array_equal(again["velocity"], fields["velocity"])


@settings(max_examples=20)
@given(STAMPS, st.lists(FINITE, min_size=14, max_size=14))
def test_poses_and_velocities_come_back(time: int, numbers: list[float]) -> None:
    x = np.array(numbers)
    base = Pose("odom", "base_link", x[:3], x[3:7])
    tf = messages.transforms(time, [base, base])
    assert same(read("tf2_msgs/msg/TFMessage", tf), tf)
    odometry = messages.odometry(time, base, x[7:10], x[10:13])
    assert same(read("nav_msgs/msg/Odometry", odometry), odometry)
    wrench = messages.wrench(time, "foot", x[:3])
    assert same(read("geometry_msgs/msg/WrenchStamped", wrench), wrench)


def test_trajectories_begin_now_and_have_no_efforts() -> None:
    rows = np.arange(6.0).reshape(3, 2)
    times = np.array([0.0, 0.25, 1.5])
    fields = messages.joint_trajectory(["a", "b"], times, rows, 2.0 * rows, 3.0 * rows)
    seen = read("trajectory_msgs/msg/JointTrajectory", fields)
    assert same(seen, fields)
    assert (seen.header.stamp.sec, seen.header.stamp.nanosec) == (0, 0)
    since = [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in seen.points]
    np.testing.assert_allclose(since, times)
    assert not any(len(p.effort) for p in seen.points)


def test_markers_are_of_unit_quaternions_and_seen() -> None:
    robot: Robot = plan().robot
    s = plan().sample(0.5)
    upright = np.tile(markers.UPRIGHT, (4, 1))
    found = markers.robot_markers(
        7, "odom", robot, s.com_position, upright[0], s.foot_position, upright, s.force
    )
    found["markers"] += markers.foothold_markers(7, "odom", [(0, np.ones(3), np.array([0.0, 0.6, 0.8]))])[
        "markers"
    ]
    seen = read("visualization_msgs/msg/MarkerArray", found)
    assert len({(m.ns, m.id) for m in seen.markers}) == len(seen.markers) == 10
    for m in seen.markers:
        q = m.pose.orientation
        assert q.x**2 + q.y**2 + q.z**2 + q.w**2 == pytest.approx(1.0)
        assert m.color.a == 1.0
    arrow = next(m for m in seen.markers if m.ns == "forces")
    assert arrow.points[1].z - arrow.points[0].z == pytest.approx(markers.FORCE_SCALE * s.force[0, 2])


def test_what_is_left_out_is_empty_and_what_is_unknown_refused() -> None:
    seen = read("visualization_msgs/msg/Marker", {"ns": "a"})
    assert (seen.ns, seen.id, seen.points, seen.pose.orientation.w) == ("a", 0, [], 1.0)
    with pytest.raises(ValueError, match="no field nom"):
        cdr.encode("visualization_msgs/msg/Marker", {"nom": "a"})


def test_hashes_of_types_are_those_of_ros() -> None:
    """That of String, as any ROS 2 since Iron has it on its wire (`ros2 topic info -v`)."""
    known = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
    assert cdr.type_hash("std_msgs/msg/String") == known
