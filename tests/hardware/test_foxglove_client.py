"""Foxglove's own client library reads what is said to it, by Foxglove's own reading of types and bytes.

It needs Node.js and, once, `npm install --prefix tests/hardware/foxglove_client`.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rollgait.hardware.reports import OK, Health, diagnostics
from rollgait.hardware.topics import DIAGNOSTICS, JOINT_COMMANDS, PLAN, SHOWN, VELOCITY, decoded, encoded
from rollgait.ros.cdr import definition
from rollgait.ros.markers import force_marker
from rollgait.ros.messages import Fields, Pose, joint_state, odometry, path, transforms
from rollgait.ros.topics import JOINT_STATES, MARKERS, ODOMETRY, TF

pytest.importorskip("foxglove", reason="the extra 'foxglove' is not installed")
from rollgait.hardware.transports.foxglove import FoxgloveTransport

FOLDER = Path(__file__).parent / "foxglove_client"
NODE = shutil.which("node")
WITHIN = 300.0
ROW, QUATERNION = np.array([1.0, -2.0, 0.5]), np.array([0.0, 0.0, 0.6, 0.8])
NAMES = ["a", "b", "c"]
POSE = Pose("odom", "base_link", ROW, QUATERNION)
SAID: dict[Any, Fields] = {
    JOINT_STATES: joint_state(5, NAMES, ROW, 2.0 * ROW, 3.0 * ROW),
    JOINT_COMMANDS: joint_state(6, NAMES, 4.0 * ROW, ROW),
    ODOMETRY: odometry(7, POSE, ROW, ROW),
    TF: transforms(8 * 10**9, [POSE]),
    PLAN: path([9, 10], "odom", np.array([ROW, 2.0 * ROW]), np.array([QUATERNION, QUATERNION])),
    MARKERS: {"markers": [force_marker(11, "odom", 1, ROW, ROW)]},
    DIAGNOSTICS: diagnostics(Health(OK, "a test", "well", "centauro", {"key": 1.5}), 12),
}

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        NODE is None or not (FOLDER / "node_modules").is_dir(),
        reason="needs Node.js and npm install --prefix tests/hardware/foxglove_client",
    ),
]


def as_read(value: Any) -> Any:
    """A message as JSON has it."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, list):
        return [as_read(each) for each in value]
    if isinstance(value, dict):
        return {key: as_read(each) for key, each in value.items()}
    return value


def assert_holds(read: Any, said: Any, where: str) -> None:
    """All that was said was read; what was left out is read as zero or empty, wherever it is."""
    if isinstance(said, dict):
        for key, value in said.items():
            assert_holds(read[key], value, f"{where}.{key}")
    elif isinstance(said, list):
        assert len(read) == len(said), where
        for number, value in enumerate(said):
            assert_holds(read[number], value, f"{where}[{number}]")
    else:
        assert read == (pytest.approx(said, rel=1e-6) if isinstance(said, float) else said), where  # float32


def test_foxgloves_client_reads_every_topic_and_commands() -> None:
    assert set(SAID) == set(SHOWN)
    server = FoxgloveTransport(0, commands=True, topics=SHOWN)
    heard: list[float] = []
    server.subscribe(VELOCITY, lambda data: heard.append(decoded(VELOCITY, data)["linear"]["x"]))
    done = threading.Event()

    def say() -> None:
        while not done.is_set():
            for topic, fields in SAID.items():
                server.publish(topic, encoded(topic, fields))
            server.receive(0.02)

    saying = threading.Thread(target=say)
    saying.start()
    try:
        command = [str(NODE), "client.cjs", f"ws://127.0.0.1:{server.port}"]
        arguments = [json.dumps([topic.name for topic in SHOWN]), definition(VELOCITY.type)]
        ran = subprocess.run(
            [*command, *arguments], cwd=FOLDER, capture_output=True, text=True, timeout=WITHIN, check=False
        )
    finally:
        done.set()
        saying.join()
        server.close()
    assert ran.returncode == 0, ran.stderr
    found = json.loads(ran.stdout)
    for topic, fields in SAID.items():
        assert_holds(found[topic.name], as_read(fields), topic.name)
    assert heard[0] == 0.25
