"""Transports in a process of their own, the real ones: what is said arrives, and who says it never waits."""

from __future__ import annotations

import json
import os
import signal
import struct
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from rollgait.errors import InputError
from rollgait.hardware.topics import VELOCITY, decoded, encoded
from rollgait.ros.messages import joint_state, vector
from rollgait.ros.topics import JOINT_STATES

pytest.importorskip("cyclonedds", reason="the extra 'ros' is not installed")
from rollgait.hardware.transports.dds import DdsTransport
from rollgait.hardware.transports.elsewhere import WAITING_MAX, Elsewhere, TransportProcess
from rollgait.hardware.transports.reach import Reach
from tests.domain import DOMAIN

WITHIN = 300.0
ROW = np.array([1.0, -2.0])
STATE = encoded(JOINT_STATES, joint_state(5, ["a", "b"], ROW, ROW))
MESSAGE_DATA = 1

pytestmark = pytest.mark.slow


class Pair:
    """The process and who speaks over it."""

    def __init__(self, reach: Reach) -> None:
        self.process = TransportProcess(reach)
        self.transport = Elsewhere(self.process.line)

    @property
    def pid(self) -> int:
        return int(self.process._process.pid or 0)

    def close(self) -> None:
        self.transport.close()
        self.process.close()


@pytest.fixture
def pair() -> Iterator[Pair]:
    made = Pair(Reach(DOMAIN))
    yield made
    made.close()


def until(done: Callable[[], Any], each: Callable[[], None]) -> None:
    end = time.monotonic() + WITHIN
    while not done():
        assert time.monotonic() < end
        each()


def test_it_is_heard_on_dds_and_hears(pair: Pair) -> None:
    other = DdsTransport(DOMAIN)
    came: list[bytes] = []
    heard: list[bytes] = []
    other.subscribe(JOINT_STATES, came.append)
    pair.transport.subscribe(VELOCITY, heard.append)
    twist = encoded(VELOCITY, {"linear": vector([0.2, 0.0, 0.0])})

    def talk() -> None:
        pair.transport.publish(JOINT_STATES, STATE)
        other.publish(VELOCITY, twist)
        other.receive(0.05)
        pair.transport.receive(0.0)

    try:
        until(lambda: came and heard, talk)
    finally:
        other.close()
    assert came[0] == STATE
    assert heard[0] == twist


def test_foxglove_is_served_from_there_too() -> None:
    pytest.importorskip("foxglove", reason="the extra 'foxglove' is not installed")
    client_of = pytest.importorskip("websockets.sync.client", reason="websockets is not installed")
    pair = Pair(Reach(DOMAIN, 0, foxglove_commands=True))
    heard: list[float] = []
    pair.transport.subscribe(VELOCITY, lambda data: heard.append(decoded(VELOCITY, data)["linear"]["x"]))
    pair.transport.publish(JOINT_STATES, STATE)
    try:
        assert pair.process.said[0] == f"ROS 2 on domain {DOMAIN}"
        url = pair.process.said[1].removeprefix("Foxglove: ")
        with client_of.connect(
            url, subprotocols=["foxglove.sdk.v1"], compression=None, open_timeout=WITHIN
        ) as client:
            channel: Any = None
            while channel is None:
                message = json.loads(client.recv(timeout=WITHIN))
                for each in message.get("channels", ()):
                    channel = each if each["topic"] == JOINT_STATES.name else channel
            subscription = {"id": 7, "channelId": channel["id"]}
            client.send(json.dumps({"op": "subscribe", "subscriptions": [subscription]}))
            mine = {"id": 3, "topic": "/cmd_vel", "encoding": "json", "schemaName": VELOCITY.type}
            client.send(json.dumps({"op": "advertise", "channels": [mine]}))
            client.send(struct.pack("<BI", MESSAGE_DATA, 3) + b'{"linear": {"x": 0.25}}')
            frames: list[bytes] = []

            def talk() -> None:
                pair.transport.publish(JOINT_STATES, STATE)
                pair.transport.receive(0.05)
                try:
                    frame = client.recv(timeout=0.05)
                except TimeoutError:
                    return
                if isinstance(frame, bytes):
                    frames.append(frame)

            until(lambda: frames and heard, talk)
    finally:
        pair.close()
    assert frames[0][13:] == STATE
    assert heard == [0.25]


def test_who_publishes_does_not_wait_for_a_process_that_is_stuck(pair: Pair) -> None:
    os.kill(pair.pid, signal.SIGSTOP)
    try:
        for _ in range(20 * WAITING_MAX):  # more than any pipe holds: else this would never come to an end
            pair.transport.publish(JOINT_STATES, bytes(10_000))
        assert pair.transport.dropped > 0
    finally:
        os.kill(pair.pid, signal.SIGCONT)


def test_a_process_that_has_died_is_no_error_for_who_publishes(pair: Pair) -> None:
    pair.transport.subscribe(VELOCITY, lambda data: None)
    os.kill(pair.pid, signal.SIGKILL)

    def talk() -> None:
        pair.transport.publish(JOINT_STATES, STATE)
        pair.transport.receive(0.01)

    until(lambda: pair.transport.broken, talk)
    pair.transport.publish(JOINT_STATES, STATE)
    pair.transport.receive(0.0)


def test_a_port_in_use_is_said_as_everywhere() -> None:
    pytest.importorskip("foxglove", reason="the extra 'foxglove' is not installed")
    import socket

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match="port"):
            TransportProcess(Reach(DOMAIN, port))


def test_ctrl_c_is_not_for_it(pair: Pair) -> None:
    os.kill(pair.pid, signal.SIGINT)
    other = DdsTransport(DOMAIN)
    came: list[bytes] = []
    other.subscribe(JOINT_STATES, came.append)

    def talk() -> None:
        pair.transport.publish(JOINT_STATES, STATE)
        other.receive(0.05)

    try:
        until(lambda: came, talk)
    finally:
        other.close()
