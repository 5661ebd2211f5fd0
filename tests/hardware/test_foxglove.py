"""Foxglove's protocol, spoken by a client of its own that shares no code with the server."""

from __future__ import annotations

import json
import struct
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from rollgait.errors import InputError
from rollgait.hardware.topics import OUTPUTS, VELOCITY, decoded, encoded
from rollgait.ros.messages import joint_state
from rollgait.ros.topics import JOINT_STATES

pytest.importorskip("foxglove", reason="the extra 'foxglove' is not installed")
pytest.importorskip("websockets", reason="websockets is not installed")
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from rollgait.hardware.transports.foxglove import FoxgloveTransport

PROTOCOL = "foxglove.sdk.v1"
MESSAGE_DATA = 1
WITHIN = 300.0
ROW = np.array([1.0, -2.0])
STATE = joint_state(5, ["a", "b"], ROW, 2.0 * ROW, 3.0 * ROW)


@pytest.fixture
def server() -> Iterator[FoxgloveTransport]:
    transport = FoxgloveTransport(0, commands=True)
    yield transport
    transport.close()


def connected(server: FoxgloveTransport) -> Any:
    return connect(
        f"ws://127.0.0.1:{server.port}",
        subprotocols=[Subprotocol(PROTOCOL)],
        compression=None,
        open_timeout=WITHIN,
    )


def told(client: Any, operation: str) -> dict[str, Any]:
    """The next message of the server of this kind."""
    while True:
        text = client.recv(timeout=WITHIN)
        if isinstance(text, str) and (message := json.loads(text))["op"] == operation:
            return dict(message)


def test_a_client_reads_what_is_published(server: FoxgloveTransport) -> None:
    server.publish(JOINT_STATES, encoded(JOINT_STATES, STATE))
    with connected(server) as client:
        (channel,) = [
            each for each in told(client, "advertise")["channels"] if each["topic"] == JOINT_STATES.name
        ]
        assert channel["encoding"] == "cdr"
        assert channel["schemaName"] == "sensor_msgs/msg/JointState"
        assert channel["schemaEncoding"] == "ros2msg"
        client.send(json.dumps({"op": "subscribe", "subscriptions": [{"id": 7, "channelId": channel["id"]}]}))
        frame: Any = ""
        while isinstance(frame, str):
            server.publish(JOINT_STATES, encoded(JOINT_STATES, STATE))
            try:
                frame = client.recv(timeout=0.2)
            except TimeoutError:
                continue
        kind, subscription, _ = struct.unpack("<BIQ", frame[:13])
        assert (kind, subscription) == (MESSAGE_DATA, 7)
        assert frame[13:] == encoded(JOINT_STATES, STATE)
        decoder = pytest.importorskip("mcap_ros2._dynamic", reason="mcap-ros2-support is not installed")
        read = decoder.generate_dynamic(channel["schemaName"], channel["schema"])[channel["schemaName"]]
        np.testing.assert_array_equal(read(frame[13:]).effort, STATE["effort"])


def test_who_comes_before_the_first_message_gets_all_topics(server: FoxgloveTransport) -> None:
    """Each channel is there before a client is: one made under its eyes may refuse its subscription."""
    with connected(server) as client:
        channels = told(client, "advertise")["channels"]
        assert {each["topic"] for each in channels} == {topic.name for topic in OUTPUTS}
        wanted = [{"id": each["id"], "channelId": each["id"]} for each in channels]
        client.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))
        came: set[int] = set()
        end = time.monotonic() + WITHIN
        while len(came) < len(wanted) and time.monotonic() < end:
            for topic in OUTPUTS:
                server.publish(topic, encoded(topic, {}))
            while len(came) < len(wanted):
                try:
                    frame = client.recv(timeout=0.05)
                except TimeoutError:
                    break
                assert isinstance(frame, bytes), frame  # neither a new channel nor a refusal
                came.add(struct.unpack("<BI", frame[:5])[1])
    assert came == {each["id"] for each in channels}


@pytest.mark.parametrize("encoding", ["cdr", "json"])
def test_a_client_commands_and_nothing_it_sends_does_harm(server: FoxgloveTransport, encoding: str) -> None:
    came: list[float] = []
    server.subscribe(VELOCITY, lambda data: came.append(decoded(VELOCITY, data)["linear"]["x"]))
    with connected(server) as client:
        assert "clientPublish" in told(client, "serverInfo")["capabilities"]
        channel = {"id": 3, "topic": "/cmd_vel", "encoding": encoding, "schemaName": VELOCITY.type}
        client.send(json.dumps({"op": "advertise", "channels": [channel]}))
        fields = {"linear": {"x": 0.25}}
        good = encoded(VELOCITY, fields) if encoding == "cdr" else json.dumps(fields).encode()
        if encoding == "json":
            client.send(struct.pack("<BI", MESSAGE_DATA, 3) + b"[1, 2")
        client.send(struct.pack("<BI", MESSAGE_DATA, 3) + good)
        end = time.monotonic() + WITHIN
        while not came and time.monotonic() < end:
            server.receive(0.2)
    assert came == [0.25]


def test_without_commands_clients_are_not_asked_for_any() -> None:
    server = FoxgloveTransport(0)
    try:
        with connected(server) as client:
            assert "clientPublish" not in told(client, "serverInfo")["capabilities"]
    finally:
        server.close()


def test_a_port_in_use_is_refused(server: FoxgloveTransport) -> None:
    with pytest.raises(InputError, match="port"):
        FoxgloveTransport(server.port)
