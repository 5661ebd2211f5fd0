"""`--bridge` of mpc, execute and drive: others see the run over the real transport; else one sentence."""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import rollgait as rg
from rollgait.cli.app import run
from rollgait.errors import MissingExtraError

pytest.importorskip("mujoco", reason="the extra 'whole-body' is not installed")
pytest.importorskip("cyclonedds", reason="the extra 'ros' is not installed")
from tests.domain import DOMAIN

from rollgait.hardware.operator import Operator
from rollgait.hardware.topics import SHOWN, VELOCITY, decoded, encoded
from rollgait.hardware.transports.dds import DdsTransport
from rollgait.ros.messages import vector
from rollgait.ros.topics import ODOMETRY

WITHIN = 300.0
BRIDGE = ["--bridge", "--domain", str(DOMAIN)]
MPC = ["mpc", "--no-kernels"]
WITHOUT_JOINTS = {"/odom", "/tf", "/plan", "/markers", "/diagnostics"}
SPEED = 0.2


class Others:
    """Another program on the network, as far as a thread is one: sees all, and drives where it is told to."""

    def __init__(self) -> None:
        self._transport = DdsTransport(DOMAIN)
        self.heard: dict[str, list[bytes]] = {topic.name: [] for topic in SHOWN}
        for topic in SHOWN:
            self._transport.subscribe(topic, self.heard[topic.name].append)
        self._transport.advertise([VELOCITY])
        self.drives = False
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._go_on)
        self._thread.start()

    def _go_on(self) -> None:
        twist = encoded(VELOCITY, {"linear": vector([SPEED, 0.0, 0.0])})
        while not self._ends.is_set():
            self._transport.receive(0.02)
            if self.drives:
                self._transport.publish(VELOCITY, twist)

    def last(self, topic: Any) -> dict[str, Any]:
        return decoded(topic, self.heard[topic.name][-1])

    @property
    def topics(self) -> set[str]:
        return {name for name, messages in self.heard.items() if messages}

    def close(self) -> None:
        self._ends.set()
        self._thread.join()
        self._transport.close()


@pytest.fixture
def others() -> Iterator[Others]:
    made = Others()
    yield made
    made.close()


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("plant", "topics"), [("rigid", WITHOUT_JOINTS), ("mujoco", {topic.name for topic in SHOWN})]
)
def test_others_see_a_run_of_the_controller(
    plant: str, topics: set[str], others: Others, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--plant", plant, "--command", f"forward={SPEED}", "--duration", "4"]
    assert run([*MPC, *arguments, *BRIDGE]) == 0
    assert capsys.readouterr().out.startswith(f"ROS 2 on domain {DOMAIN}\ncentauro, {plant}")
    assert others.topics == topics
    twist = others.last(ODOMETRY)["twist"]["twist"]["linear"]
    assert twist["x"] == pytest.approx(SPEED, abs=0.03)


@pytest.mark.slow
def test_others_drive_a_run_and_a_log_is_written_of_it(
    others: Others, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # who tells it to drive is a thread of this process, and may be silent for longer than a program may
    monkeypatch.setattr(Operator, "silent", property(lambda one: math.isinf(one._heard)))
    others.drives = True
    assert run([*MPC, "--command", "cmd_vel", "--duration", "4", "--json", *BRIDGE]) == 0
    report = json.loads(capsys.readouterr().out)  # and nothing else
    assert report["command"] == "what comes on /cmd_vel or /goal_pose"
    assert others.last(ODOMETRY)["twist"]["twist"]["linear"]["x"] == pytest.approx(SPEED, abs=0.03)


@pytest.mark.slow
def test_others_see_plans_carried_out(others: Others, tmp_path: Path) -> None:
    scenario = rg.Scenario(
        horizon=0.8, gait={"kind": "drive"}, robot="centauro", start={"x": 0.0}, goal={"x": 0.04}
    )
    file = rg.plan(scenario).save(tmp_path / "plan.npz")
    assert run(["execute", str(file), "--plant", "rigid", "--no-kernels", *BRIDGE]) == 0
    assert others.topics == WITHOUT_JOINTS
    assert others.last(ODOMETRY)["pose"]["pose"]["position"]["x"] == pytest.approx(0.04, abs=0.02)


@pytest.mark.slow
def test_others_see_and_drive_what_is_driven_on_a_page(others: Others) -> None:
    pytest.importorskip("viser", reason="the extra 'view' is not installed")
    from rollgait.cli.live import opened, reach_if
    from rollgait.mpc.command import VelocityCommand
    from rollgait.view.driving.messages import Request
    from rollgait.view.driving.process import LoopProcess, Setup

    still = Request(VelocityCommand(gait="drive"))
    with opened(reach_if(True, DOMAIN, False, None)) as line:
        loop = LoopProcess(Setup("centauro", "rigid", "drive", others=line))
        try:
            others.drives = True
            end = time.monotonic() + WITHIN
            while loop.exchange(still).actual[0] < 0.75 * SPEED:
                assert time.monotonic() < end
                time.sleep(0.03)
            others.drives = False  # and is gone
            while abs((seen := loop.exchange(still)).actual[0]) > 0.02 or seen.command.forward:
                assert time.monotonic() < end
                time.sleep(0.03)
        finally:
            loop.close()
    assert others.topics == WITHOUT_JOINTS


@pytest.mark.slow
def test_drive_says_where_it_is_seen(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("viser", reason="the extra 'view' is not installed")
    assert run(["drive", "--plant", "rigid", "--port", "0", "--seconds", "0.5", *BRIDGE]) == 0
    first, second, last = capsys.readouterr().out.splitlines()
    assert first == f"ROS 2 on domain {DOMAIN}"
    assert second.startswith("open http://127.0.0.1:")
    assert "real time" in last


COMMANDS = (["mpc"], ["drive"], ["execute", "nowhere.npz"])
REFUSED = {
    ("--domain", "5"): "domain: 5 goes with --bridge",
    ("--foxglove",): "goes with --bridge",
    ("--foxglove-port", "0"): "goes with --bridge",
    ("--bridge", "--domain", "500"): "from 0 to 232",
    ("--bridge", "--foxglove-port", "0"): "goes with --foxglove",
}


def one_sentence(arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(arguments) == 2
    shown = capsys.readouterr()
    assert said in shown.err
    assert len(shown.err.strip().splitlines()) == 1
    assert shown.out == ""


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command[0])
@pytest.mark.parametrize("options", REFUSED, ids=" ".join)
def test_what_is_wrong_is_one_sentence_before_anything_is_done(
    command: list[str], options: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    if command[0] == "drive":
        pytest.importorskip("viser", reason="the extra 'view' is not installed")
    one_sentence([*command, *options], REFUSED[options], capsys)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["mpc", "--command", "cmd_vel"], "goes with --bridge"),
        (["mpc", "--bridge", "--foxglove-commands"], "goes with --command cmd_vel"),
        (["mpc", "--foxglove-commands"], "goes with --bridge"),
    ],
)
def test_commands_from_outside_are_asked_for(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    one_sentence(arguments, said, capsys)


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command[0])
@pytest.mark.parametrize("extra", ["ros", "foxglove"])
def test_a_missing_extra_is_named_before_anything_is_done(
    command: list[str], extra: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if command[0] == "drive":
        pytest.importorskip("viser", reason="the extra 'view' is not installed")

    def missing() -> None:
        raise MissingExtraError("this", extra)

    name = {"ros": "need_dds", "foxglove": "need_foxglove"}[extra]
    monkeypatch.setattr(f"rollgait.hardware.transports.reach.{name}", missing)
    one_sentence([*command, "--bridge", "--foxglove"], f"pip install 'rollgait[{extra}]'", capsys)
