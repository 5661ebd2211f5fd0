"""ROS 2 on DDS: names, bytes and hashes as others have them, across processes."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import time
from typing import Any

import numpy as np
import pytest

from rollgait.errors import InputError
from rollgait.hardware.topics import COMMANDS, IMU, JOINT_COMMANDS, OUTPUTS, SENSORS, encoded, types
from rollgait.ros.messages import header, joint_state, quaternion, vector
from rollgait.ros.topics import JOINT_STATES

pytest.importorskip("cyclonedds", reason="the extra 'ros' is not installed")
from rollgait.hardware.transports.dds import DdsTransport, domain_of, idl_type, mangled, topic_name
from tests.domain import DOMAIN
from tests.hardware.own_types import Header, Imu, JointState, Quaternion, Time, Vector3

WITHIN = 300.0
ROW = np.array([0.5, -1.5, 2.5])
STATE = joint_state(7 * 10**9 + 5, ["hip", "knee", "wheel"], ROW, 2.0 * ROW, 3.0 * ROW)
SENSED = {
    "header": header(10**9, "base_link"),
    "orientation": quaternion([0.0, 0.0, 0.6, 0.8]),
    "orientation_covariance": np.arange(9.0),
    "angular_velocity": vector([1.0, 2.0, 3.0]),
}


def by_others() -> dict[str, Any]:
    """The same messages in types that another program has."""
    zeros, none = [0.0] * 9, Vector3(0.0, 0.0, 0.0)
    state = JointState(
        Header(Time(7, 5), ""),
        STATE["name"],
        ROW.tolist(),
        (2.0 * ROW).tolist(),
        (3.0 * ROW).tolist(),
    )
    imu = Imu(
        Header(Time(1, 0), "base_link"),
        Quaternion(0.0, 0.0, 0.6, 0.8),
        [float(k) for k in range(9)],
        Vector3(1.0, 2.0, 3.0),
        zeros,
        none,
        zeros,
    )
    return {JOINT_STATES.type: state, IMU.type: imu}


@pytest.mark.parametrize(("topic", "fields"), [(JOINT_STATES, STATE), (IMU, SENSED)])
def test_bytes_and_type_names_are_those_of_another_implementation(topic: Any, fields: Any) -> None:
    other = by_others()[topic.type]
    assert other.serialize(use_version_2=False) == encoded(topic, fields)
    own: Any = idl_type(topic.type)
    assert own.__idl_typename__ == other.__idl_typename__ == mangled(topic.type).replace("::", ".")
    # XTypes: a hash of the whole structure, by which readers and writers recognise one another
    for each in (own, type(other)):
        each.__idl__.populate()
        each.__idl__.fill_type_data()
    assert own.__idl__._xt_bytedata == type(other).__idl__._xt_bytedata


@pytest.mark.parametrize("topic", [*SENSORS, *COMMANDS, *OUTPUTS])
def test_every_message_survives_the_other_implementation(topic: Any) -> None:
    data = encoded(topic, {})
    kind: Any = idl_type(topic.type)
    assert kind.deserialize(data).serialize(use_version_2=False) == data


def test_topics_have_the_names_that_ros_gives_them() -> None:
    assert topic_name(JOINT_STATES) == "rt/joint_states"
    assert mangled("tf2_msgs/msg/TFMessage") == "tf2_msgs::msg::dds_::TFMessage_"


def test_hashes_follow_the_published_rule() -> None:
    """REP-2016: SHA-256 of the type's description as JSON. Here for std_msgs/msg/Bool, spelt out."""
    field = {
        "name": "data",
        "type": {"type_id": 15, "capacity": 0, "string_capacity": 0, "nested_type_name": ""},
    }
    text = {
        "type_description": {"type_name": "std_msgs/msg/Bool", "fields": [field]},
        "referenced_type_descriptions": [],
    }
    digest = hashlib.sha256(json.dumps(text, separators=(", ", ": ")).encode()).hexdigest()
    assert types().hash_rihs01("std_msgs/msg/Bool") == f"RIHS01_{digest}"
    # as `ros2 topic info -v` prints it
    known = "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"
    assert types().hash_rihs01(JOINT_STATES.type) == known


@pytest.mark.parametrize("wrong", [-1, 233])
def test_a_domain_that_is_none_is_refused(wrong: int) -> None:
    with pytest.raises(InputError, match="domain"):
        domain_of(wrong)


def test_the_domain_is_that_of_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "41")
    assert domain_of(None) == 41
    assert domain_of(3) == 3
    monkeypatch.setenv("ROS_DOMAIN_ID", "forty")
    with pytest.raises(InputError, match="ROS_DOMAIN_ID"):
        domain_of(None)


def _answer(count: int) -> None:
    """Another process, of Cyclone alone with types of its own: reads joint states, answers with commands."""
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    kind = JointState
    participant = DomainParticipant(DOMAIN)
    reader = DataReader(participant, Topic(participant, "rt/joint_states", kind))
    writer = DataWriter(participant, Topic(participant, "rt/joint_commands", kind))
    end = time.monotonic() + WITHIN
    while not writer.get_matched_subscriptions() and time.monotonic() < end:
        time.sleep(0.01)
    while count and time.monotonic() < end:
        for state in reader.take(10):
            state.position = [2.0 * value for value in state.position]
            writer.write(state)
            count -= 1
        time.sleep(0.001)
    time.sleep(0.5)


def test_a_program_of_another_implementation_reads_and_answers() -> None:
    process = multiprocessing.get_context("spawn").Process(target=_answer, args=(3,), daemon=True)
    process.start()
    transport = DdsTransport(DOMAIN)
    came: list[bytes] = []
    transport.subscribe(JOINT_COMMANDS, came.append)
    wanted = encoded(JOINT_COMMANDS, STATE | {"position": 2.0 * ROW})
    try:
        end = time.monotonic() + WITHIN
        while len(came) < 3 and time.monotonic() < end:
            transport.publish(JOINT_STATES, encoded(JOINT_STATES, STATE))
            transport.receive(0.05)
    finally:
        transport.close()
        process.join(WITHIN)
    assert len(came) >= 3
    assert all(data == wanted for data in came)
    assert process.exitcode == 0
