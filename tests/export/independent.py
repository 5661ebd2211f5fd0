"""A reader of bags that knows nothing of rollgait: mcap-ros2-support or rosbags, and pinocchio for robots."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest


@dataclass(frozen=True)
class Bag:
    """A bag: messages, types and offered qualities of service by topic."""

    messages: dict[str, list[Any]]
    types: dict[str, str]
    qualities: dict[str, str]


def read_mcap(file: Path) -> Bag:
    reader = pytest.importorskip("mcap_ros2.reader", reason="mcap-ros2-support is not installed")
    make_reader = pytest.importorskip("mcap.reader", reason="the extra 'mcap' is not installed").make_reader
    messages: dict[str, list[Any]] = defaultdict(list)
    for message in reader.read_ros2_messages(str(file)):
        messages[message.channel.topic].append(message.ros_msg)
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    channels = summary.channels.values()
    return Bag(
        dict(messages),
        {c.topic: summary.schemas[c.schema_id].name for c in channels},
        {c.topic: c.metadata["offered_qos_profiles"] for c in channels},
    )


def read_rosbag2(folder: Path) -> Bag:
    highlevel = pytest.importorskip("rosbags.highlevel", reason="the extra 'mcap' is not installed")
    messages: dict[str, list[Any]] = defaultdict(list)
    with highlevel.AnyReader([folder]) as reader:
        for connection, _, data in reader.messages():
            messages[connection.topic].append(reader.deserialize(data, connection.msgtype))
        types = {c.topic: c.msgtype for c in reader.connections}
        qualities = {c.topic: str(c.ext.offered_qos_profiles) for c in reader.connections}
    return Bag(dict(messages), types, qualities)


def seconds(stamp: Any) -> float:
    return float(stamp.sec + 1e-9 * stamp.nanosec)


def matrix(transform: Any) -> np.ndarray:
    """(4, 4) of a `geometry_msgs/Transform`, by the definition of a quaternion."""
    q, p = transform.rotation, transform.translation
    x, y, z, w = q.x, q.y, q.z, q.w
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), p.x],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), p.y],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), p.z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def frames_in_world(bag: Bag, world: str = "map") -> Iterator[dict[str, np.ndarray]]:
    """Poses (4, 4) in the world of all frames at each message on /tf, as tf2 finds them: by the tree."""
    (once,) = bag.messages["/tf_static"]
    for message in bag.messages["/tf"]:
        parents: dict[str, tuple[str, np.ndarray]] = {}
        for t in [*once.transforms, *message.transforms]:
            assert t.child_frame_id not in parents, f"{t.child_frame_id} hangs on two frames"
            parents[t.child_frame_id] = (t.header.frame_id, matrix(t.transform))
        found = {world: np.eye(4)}
        while waiting := [
            child for child, (parent, _) in parents.items() if child not in found and parent in found
        ]:
            for child in waiting:
                parent, pose = parents[child]
                found[child] = found[parent] @ pose
        assert set(found) == {world, *parents}, "frames do not hang together"
        yield found


def links_in_world(bag: Bag) -> Iterator[dict[str, np.ndarray]]:
    """Poses (4, 4) of all links at each of /joint_states: /robot_description moved by them, base by /tf."""
    pin = pytest.importorskip("pinocchio", reason="the extra 'whole-body' is not installed")
    (description,) = bag.messages["/robot_description"]
    model = pin.buildModelFromXML(description.data, pin.JointModelFreeFlyer())
    data = model.createData()
    root = next(f.name for f in model.frames if f.parentJoint == 1 and str(f.type) == "BODY")
    for state, frames in zip(bag.messages["/joint_states"], frames_in_world(bag), strict=True):
        q = pin.neutral(model)
        base = frames[root]
        q[:3], q[3:7] = base[:3, 3], pin.Quaternion(base[:3, :3]).coeffs()
        assert set(state.name) == set(model.names[2:])
        for name, angle in zip(state.name, state.position, strict=True):
            joint = model.joints[model.getJointId(name)]
            q[joint.idx_q : joint.idx_q + joint.nq] = (
                [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
            )
        pin.framesForwardKinematics(model, data, q)
        yield {
            frame.name: np.array(data.oMf[number].homogeneous)
            for number, frame in enumerate(model.frames)
            if str(frame.type) == "BODY"
        }
